//! How much a tracker can hold, fixed when the library is built, and the memory which that takes.

use crate::method::{Scratch, Stored};
use smr_core::{Paper, Quality, Robust, Target};

/// The largest area of a box of the paper's tracker, in pixels: `SMR_PIXELS` of the environment of the build, or 4096 (64x64).
pub const PIXELS: usize = number(option_env!("SMR_PIXELS"), 4096);

/// The most offsets of its window on an axis: `SMR_SPAN` of the environment of the build, or 161 (the paper's).
pub const SPAN: usize = number(option_env!("SMR_SPAN"), 161);

/// The paper's tracker as it is built.
pub(crate) type PaperTarget = Paper<PIXELS, SPAN>;

/// Alignment of all memory that C gives: `SMR_ALIGNMENT` of the header.
pub const ALIGNMENT: usize = 8;

/// `SMR_PAPER_TARGET_SIZE` of the header: a byte a pixel, and what the fixed fields take with some to spare.
pub const PAPER_TARGET_SIZE: usize = PIXELS.next_multiple_of(8) + size_of::<[usize; 8]>() + 96;

/// `SMR_PAPER_WORKSPACE_SIZE` of the header: a byte a pixel, five words an offset, a table and the fixed fields.
pub const PAPER_WORKSPACE_SIZE: usize =
    PIXELS.next_multiple_of(8) + (20 * SPAN).next_multiple_of(8) + size_of::<[usize; 22]>() + 648;

/// `SMR_PAPER_SAVED_SIZE` of the header.
pub const PAPER_SAVED_SIZE: usize = PIXELS + 42;

/// `SMR_ROBUST_TARGET_SIZE` of the header.
pub const ROBUST_TARGET_SIZE: usize = 11344 + size_of::<[usize; 6]>();

/// `SMR_ROBUST_WORKSPACE_SIZE` of the header.
pub const ROBUST_WORKSPACE_SIZE: usize = 39872 + size_of::<[usize; 16]>();

/// `SMR_ROBUST_SAVED_SIZE` of the header.
pub const ROBUST_SAVED_SIZE: usize = 11276;

/// `SMR_POOR_QUALITY` of the header.
const POOR_QUALITY: u16 = 1023;
const _: () = assert!(POOR_QUALITY == Quality::POOR_BELOW);

/// The header promises the size to C on every target; and it shall not promise much more than is used.
const fn holds<T>(size: usize) -> bool {
    align_of::<T>() <= ALIGNMENT
        && size_of::<T>() <= size
        && size - size_of::<T>() <= 64
        && size.is_multiple_of(ALIGNMENT)
}

const _: () = assert!(holds::<Stored<PaperTarget>>(PAPER_TARGET_SIZE));
const _: () = assert!(holds::<Scratch<PaperTarget>>(PAPER_WORKSPACE_SIZE));
const _: () = assert!(PAPER_SAVED_SIZE == PaperTarget::SAVED_SIZE);
const _: () = assert!(holds::<Stored<Robust>>(ROBUST_TARGET_SIZE));
const _: () = assert!(holds::<Scratch<Robust>>(ROBUST_WORKSPACE_SIZE));
const _: () = assert!(ROBUST_SAVED_SIZE == Robust::SAVED_SIZE);

/// The number that `text` spells, at compile time; `default` if there is no text. Anything else does not compile.
#[allow(clippy::panic)] // only ever evaluated by the compiler
const fn number(text: Option<&str>, default: usize) -> usize {
    let Some(text) = text else { return default };
    match usize::from_str_radix(text, 10) {
        Ok(number) if number > 0 => number,
        _ => panic!("SMR_PIXELS and SMR_SPAN are numbers above 0"),
    }
}
