//! The capacity of a tracker, and the bytes that it takes. Both are fixed when the library is built.

use smr_core::{Paper, Quality, Robust, Target};

/// The largest area of a box of the paper's tracker, in pixels: `SMR_PIXELS` in the environment of the build, or 4096
/// (64x64).
pub const PIXELS: usize = number(option_env!("SMR_PIXELS"), 4096);

/// The most offsets of its search window on an axis: `SMR_SPAN` in the environment of the build, or 161 (the paper's).
pub const SPAN: usize = number(option_env!("SMR_SPAN"), 161);

/// The paper's tracker with these capacities.
pub(crate) type PaperTarget = Paper<PIXELS, SPAN>;

/// Alignment of all memory from the caller: `SMR_ALIGNMENT` in the header.
pub const ALIGNMENT: usize = 8;

/// `SMR_PAPER_TARGET_SIZE` in the header: a byte for each pixel, the fixed fields, and a small reserve.
pub const PAPER_TARGET_SIZE: usize = PIXELS.next_multiple_of(8) + size_of::<[usize; 10]>() + 112;

/// Bytes that the table of a 32-bit processor without DSP or SIMD takes more: it has entries for differences of both
/// signs. The header leaves room for them, so that it fits every processor.
pub(crate) const SIGNED_DIFFERENCES: usize = 512;

/// `SMR_PAPER_WORKSPACE_SIZE` in the header: a byte for each pixel, five words of 32 bits for each offset, 22 words and
/// 672 bytes of other fields, and the larger table.
pub const PAPER_WORKSPACE_SIZE: usize =
    PIXELS.next_multiple_of(8) + (20 * SPAN).next_multiple_of(8) + size_of::<[usize; 22]>() + 672 + SIGNED_DIFFERENCES;

/// `SMR_PAPER_SAVED_SIZE` in the header.
pub const PAPER_SAVED_SIZE: usize = PIXELS + 94;

/// Bytes that the refiner adds to a target. The header leaves room for them, so that it fits the library with and
/// without the refiner.
pub(crate) const REFINER: usize = 1056;
/// Bytes that it adds to the saved form.
const SAVED_REFINER: usize = 1044;

/// `SMR_ROBUST_TARGET_SIZE` in the header.
pub const ROBUST_TARGET_SIZE: usize = 11344 + REFINER + size_of::<[usize; 8]>();

/// `SMR_ROBUST_WORKSPACE_SIZE` in the header.
pub const ROBUST_WORKSPACE_SIZE: usize = 39856 + SIGNED_DIFFERENCES + size_of::<[usize; 16]>();

/// `SMR_ROBUST_SAVED_SIZE` in the header.
pub const ROBUST_SAVED_SIZE: usize = 11306 + SAVED_REFINER;

/// `SMR_POOR_QUALITY` in the header.
const POOR_QUALITY: u16 = 1023;

const _: () = assert!(PAPER_SAVED_SIZE == PaperTarget::SAVED_SIZE);
const _: () =
    assert!(ROBUST_SAVED_SIZE == Robust::SAVED_SIZE || ROBUST_SAVED_SIZE == Robust::SAVED_SIZE + SAVED_REFINER);
const _: () = assert!(POOR_QUALITY == Quality::POOR_BELOW);

/// Parses `text` at compile time; `default` if there is no text. Anything but a number above 0 is a compile error.
#[allow(clippy::panic)] // evaluated by the compiler only
const fn number(text: Option<&str>, default: usize) -> usize {
    let Some(text) = text else { return default };
    match usize::from_str_radix(text, 10) {
        Ok(number) if number > 0 => number,
        _ => panic!("SMR_PIXELS and SMR_SPAN must be numbers above 0"),
    }
}
