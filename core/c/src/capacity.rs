//! The largest box and search window of a tracker, and its bytes of memory, all fixed when the library is built.

use smr_core::robust::Small;
use smr_core::{Paper, Quality, Robust, Target};

/// The largest area of the paper tracker's box, in pixels: `SMR_PIXELS` in the build's environment, or 4096.
pub const PIXELS: usize = number(option_env!("SMR_PIXELS"), 4096);

/// Largest number of offsets on an axis of the paper tracker's window: `SMR_SPAN` in the build's environment, or 161.
pub const SPAN: usize = number(option_env!("SMR_SPAN"), 161);

pub(crate) type PaperTarget = Paper<PIXELS, SPAN>;
pub(crate) type SmallTarget = Robust<Small>;

/// Alignment of storage and workspace in bytes: `SMR_ALIGNMENT` in the header.
pub const ALIGNMENT: usize = 8;

/// Bytes of the paper tracker (`SMR_PAPER_TARGET_SIZE`): `PIXELS`, the fixed fields, and a small reserve.
pub const PAPER_TARGET_SIZE: usize = PIXELS.next_multiple_of(8) + size_of::<[usize; 12]>() + 120;

/// Extra bytes of the table of similarities on 32-bit processors without DSP or SIMD, for its entries for negative
/// differences. On other processors the table has no such entries. The header's sizes always include these bytes, so
/// that one header fits every processor.
pub(crate) const SIGNED_DIFFERENCES: usize = 512;

/// Bytes of the paper tracker's workspace (`SMR_PAPER_WORKSPACE_SIZE`): `PIXELS`, five 32-bit words for each of
/// `SPAN` offsets, 22 pointer-sized words and 672 bytes for other fields, and `SIGNED_DIFFERENCES`.
pub const PAPER_WORKSPACE_SIZE: usize =
    PIXELS.next_multiple_of(8) + (20 * SPAN).next_multiple_of(8) + size_of::<[usize; 22]>() + 672 + SIGNED_DIFFERENCES;

/// Largest size of a saved target of the paper tracker, in bytes: `SMR_PAPER_SAVED_SIZE` in the header.
pub const PAPER_SAVED_SIZE: usize = PIXELS + 94;

/// Bytes that the refiner adds to a robust tracker of this library: 0 without it. In the header `SMR_REFINER` decides.
pub const REFINER: usize = if <Robust as Target>::SAVED_SIZE == ROBUST_SAVED_SIZE { 1056 } else { 0 };
/// Bytes that the refiner adds to a saved target.
const SAVED_REFINER: usize = 1046;

/// Bytes of a robust tracker, without its workspace: `SMR_ROBUST_TARGET_SIZE` in the header.
pub const ROBUST_TARGET_SIZE: usize = 11352 + REFINER + size_of::<[usize; 10]>();

/// Bytes of the robust tracker's workspace: `SMR_ROBUST_WORKSPACE_SIZE` in the header.
pub const ROBUST_WORKSPACE_SIZE: usize = 39160 + SIGNED_DIFFERENCES + size_of::<[usize; 16]>();

/// Largest size of a saved target of the robust tracker, in bytes: `SMR_ROBUST_SAVED_SIZE` in the header.
pub const ROBUST_SAVED_SIZE: usize = 11310 + SAVED_REFINER;

/// Bytes of a small robust tracker, without its workspace: `SMR_ROBUST_SMALL_TARGET_SIZE` in the header.
pub const ROBUST_SMALL_TARGET_SIZE: usize = 9224 + REFINER + size_of::<[usize; 10]>();

/// Bytes of the small robust tracker's workspace: `SMR_ROBUST_SMALL_WORKSPACE_SIZE` in the header.
pub const ROBUST_SMALL_WORKSPACE_SIZE: usize = 34112 + SIGNED_DIFFERENCES + size_of::<[usize; 16]>();

/// Largest size of a saved target of the small robust tracker, in bytes: `SMR_ROBUST_SMALL_SAVED_SIZE` in the header.
pub const ROBUST_SMALL_SAVED_SIZE: usize = 9182 + SAVED_REFINER;

/// Quality below which a target is poor, in units of 1/65535 (0 to 65535): `SMR_POOR_QUALITY` in the header.
const POOR_QUALITY: u16 = 1023;

const _: () = assert!(PAPER_SAVED_SIZE == PaperTarget::SAVED_SIZE);
const _: () = assert!(saves::<Robust>(ROBUST_SAVED_SIZE) && saves::<SmallTarget>(ROBUST_SMALL_SAVED_SIZE));
const _: () = assert!(POOR_QUALITY == Quality::POOR_BELOW);

/// True if a robust tracker saves at most `size` bytes, with or without the refiner.
const fn saves<T: Target>(size: usize) -> bool {
    size == T::SAVED_SIZE || size == T::SAVED_SIZE + SAVED_REFINER
}

/// Parses a number above 0 at compile time; any other text is a compile error. Returns `default` for `None`.
#[allow(clippy::panic)] // evaluated by the compiler only
const fn number(text: Option<&str>, default: usize) -> usize {
    let Some(text) = text else { return default };
    match usize::from_str_radix(text, 10) {
        Ok(number) if number > 0 => number,
        _ => panic!("SMR_PIXELS and SMR_SPAN must be numbers above 0"),
    }
}
