//! How much a tracker can hold, fixed when the library is built, and the storage which that takes.

use crate::tracker::smr_tracker;

/// The largest area of a box, in pixels: `SMR_PIXELS` of the environment of the build, or 4096 (64x64).
pub const PIXELS: usize = number(option_env!("SMR_PIXELS"), 4096);

/// The most offsets of the window on an axis: `SMR_SPAN` of the environment of the build, or 161 (the paper's).
pub const SPAN: usize = number(option_env!("SMR_SPAN"), 161);

/// `SMR_TRACKER_SIZE` of the header: two bytes a pixel, five words an offset, the table that is cut off at alpha, and what the fixed fields take with some to
/// spare.
pub const STORAGE_SIZE: usize =
    2 * PIXELS.next_multiple_of(8) + (20 * SPAN).next_multiple_of(8) + size_of::<[usize; 28]>() + 656;

/// `SMR_TRACKER_ALIGN` of the header.
pub const STORAGE_ALIGN: usize = size_of::<usize>();

// The header promises both to C, on every target; and it shall not promise much more than is used.
const _: () = assert!(align_of::<smr_tracker>() == STORAGE_ALIGN);
const _: () = assert!(size_of::<smr_tracker>() <= STORAGE_SIZE);
const _: () = assert!(STORAGE_SIZE - size_of::<smr_tracker>() <= 64);

/// The number that `text` spells, at compile time; `default` if there is no text. Anything else does not compile.
#[allow(clippy::panic)] // only ever evaluated by the compiler
const fn number(text: Option<&str>, default: usize) -> usize {
    let Some(text) = text else { return default };
    match usize::from_str_radix(text, 10) {
        Ok(number) if number > 0 => number,
        _ => panic!("SMR_PIXELS and SMR_SPAN are numbers above 0"),
    }
}
