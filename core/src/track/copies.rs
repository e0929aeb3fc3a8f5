//! Two saved copies of a target, written in turn: if the power fails while one is written, the other one is whole.
//!
//! | bytes | content |
//! |---|---|
//! | first | the target, as [`Target::save`] writes it; it ends with its checksum |
//! | 4 | number of the copy |
//! | 4 | checksum (CRC-32) of the number and the target's checksum |
//!
//! The second checksum ties the number to its target. A new number beside an old or unfinished target is not accepted
//! as a copy.
//!
//! ```
//! use smr_core::{Frame, Image, Rect, Robust, Target, Tracker, copies, robust};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! # let pixels: Vec<u8> = (0..96 * 96).map(|at: u32| (at.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
//! # let mut tracker = Tracker::<Robust>::new(robust::Config::robust())?;
//! # tracker.lock(&Frame::whole(Image::new(&pixels, 96, 96)?), Rect::new(30, 30, 24, 24))?;
//! // Two places in flash. At the start: continue with the newer copy, if there is one.
//! const SIZE: usize = copies::size(Robust::SAVED_SIZE);
//! let mut flash = [[0xFF; SIZE], [0xFF; SIZE]];
//! let [first, second] = &flash;
//! if let Some(copy) = copies::newest(first, second) {
//!     tracker.restore(copy.saved)?;
//! }
//!
//! // From time to time: write over the older one.
//! let [first, second] = &flash;
//! let (place, number) = copies::next(first, second);
//! copies::write(tracker.target(), number, &mut flash[place])?;
//!
//! let [first, second] = &flash;
//! assert_eq!(copies::newest(first, second).map(|copy| (copy.place, copy.number)), Some((0, 1)));
//! assert_eq!(copies::next(first, second), (1, 2));
//! # Ok(())
//! # }
//! ```

use super::checksum::Crc;
use super::saved::{SaveError, whole_length};
use super::target::Target;

/// Bytes of the number and of the checksum.
const AROUND: usize = 8;

/// The size in bytes of a copy whose target takes `saved` bytes: see [`Target::saved_size`] and [`Target::SAVED_SIZE`].
#[must_use]
pub const fn size(saved: usize) -> usize {
    saved + AROUND
}

/// A copy that is whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SavedCopy<'a> {
    /// The place of the copy. 0: the first, 1: the second.
    pub place: usize,
    /// The number with which it was written.
    pub number: u32,
    /// The saved target, for [`Target::restore`].
    pub saved: &'a [u8],
}

/// Writes the target and makes it a copy with this number. Returns how many bytes the copy takes.
///
/// # Errors
/// Those of [`Target::save`]. The bytes are then unchanged.
pub fn write<T: Target>(target: &T, number: u32, bytes: &mut [u8]) -> Result<usize, SaveError> {
    let needed = target.saved_size()?;
    let bytes = bytes.get_mut(..size(needed)).ok_or(SaveError::BufferTooSmall)?;
    let saved = target.save(bytes)?;
    seal(number, saved, bytes)
}

/// Makes a copy of a target that [`Target::save`] has written into the first `saved` bytes: writes number and checksum
/// behind it. Returns how many bytes the copy takes. [`write()`] saves and seals.
///
/// # Errors
/// [`SaveError::BufferTooSmall`]. The bytes are then unchanged.
pub fn seal(number: u32, saved: usize, bytes: &mut [u8]) -> Result<usize, SaveError> {
    let (saved, rest) = bytes.split_at_mut_checked(saved).ok_or(SaveError::BufferTooSmall)?;
    let around = rest.first_chunk_mut::<AROUND>().ok_or(SaveError::BufferTooSmall)?;
    *around = (u64::from(checksum(number, saved)) << 32 | u64::from(number)).to_le_bytes();
    Ok(size(saved.len()))
}

/// The newer one of two copies; `None` if neither is whole. Other bytes may follow each copy. Only [`Target::restore`]
/// checks that the copy fits the tracker and its configuration.
///
/// Numbers start again at 0 after `u32::MAX`, so the newer number is the one that is ahead by less than half of all
/// numbers.
#[must_use]
pub fn newest<'a>(first: &'a [u8], second: &'a [u8]) -> Option<SavedCopy<'a>> {
    match (read(0, first), read(1, second)) {
        (Some(first), Some(second)) => {
            let ahead = second.number.wrapping_sub(first.number).cast_signed();
            Some(if ahead > 0 { second } else { first })
        }
        (first, second) => first.or(second),
    }
}

/// The place of the next copy, 0 or 1, and its number. It overwrites the older copy, or the one that is not whole.
#[must_use]
pub fn next(first: &[u8], second: &[u8]) -> (usize, u32) {
    newest(first, second).map_or((0, 1), |copy| (1 - copy.place, copy.number.wrapping_add(1)))
}

/// The copy in `bytes`, if it is whole.
fn read(place: usize, bytes: &[u8]) -> Option<SavedCopy<'_>> {
    let (saved, rest) = bytes.split_at_checked(whole_length(bytes)?)?;
    let (number, rest) = rest.split_first_chunk::<4>()?;
    let number = u32::from_le_bytes(*number);
    let sum = u32::from_le_bytes(*rest.first_chunk::<4>()?);
    (sum == checksum(number, saved)).then_some(SavedCopy { place, number, saved })
}

/// The checksum of the number and of the checksum at the end of the target. (The CRC of any bytes followed by their own
/// CRC is a constant, so the whole target would add nothing.)
fn checksum(number: u32, saved: &[u8]) -> u32 {
    let mut sum = Crc::new();
    sum.update(&number.to_le_bytes());
    sum.update(saved.last_chunk::<4>().map_or(&[], |sum| sum));
    sum.finish()
}
