//! A flight record: everything that a tracker saw and answered, as bytes that can be replayed on any machine.
//!
//! Firmware passes each event to a [`Recorder`], which passes bytes to your function: for a file, flash, a serial line
//! or a log. `host-sim replay FILE`, or [`replay()`] in your own program, runs the record through the same code and
//! reports the first difference. After a power failure the record is valid up to its last complete entry.
//!
//! ```
//! use smr_core::record::{Entry, Recorder, entries, replay};
//! use smr_core::{Frame, Image, Paper, Rect, Tracker};
//! # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
//! # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
//! # let mut file = Vec::new();
//! let target = Rect::new(20, 10, 16, 16);
//! let mut tracker = Tracker::<Paper<256, 161>>::new();
//! let mut recorder = Recorder::begin(tracker.target(), |bytes| std::io::Write::write_all(&mut file, bytes))?;
//! tracker.lock(&frame, target)?;
//! recorder.lock(tracker.target(), &frame, target)?;
//! // In every further frame:
//! recorder.window(tracker.target(), &frame)?; // before the update, so that the record has an update that never ends
//! let answer = tracker.update(&frame)?;
//! recorder.answer(&answer)?;
//!
//! for found in entries(&file) {
//!     let found = found?; // bytes that are no entry, or an entry that is missing
//!     assert!(found.number > 0 || matches!(found.entry, Entry::Begin(_)));
//! }
//! let replayed = replay(&file, &mut tracker, |tracker, frame| tracker.update(frame))?;
//! assert_eq!((replayed.locks, replayed.answers), (1, 1));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! # Cost
//!
//! | entry | bytes |
//! |---|---|
//! | begin | 584 ([`Paper`](crate::Paper)) or 556 ([`Robust`](crate::Robust); with the refiner 558) |
//! | lock | 36 + pixels of [`Target::lock_window`] |
//! | frame | 84 + pixels of [`Target::windows`] |
//!
//! The answer depends on these pixels. The window of [`Paper`](crate::Paper) is the box enlarged by the radius on each
//! side: a frame takes 9300 bytes for a box of 64x64 with a window of +-16. The window of [`Robust`](crate::Robust) is
//! about 16 times the area of its target.
//!
//! The recorder needs 64 bytes of stack and no other memory, and the time of a CRC-32 over the bytes and of the writer.
//!
//! # The bytes, version 2
//!
//! A record is a sequence of entries. Numbers are little-endian; signed ones are in two's complement.
//!
//! | bytes of an entry | content |
//! |---|---|
//! | 0 to 3 | the tag: `SMRB`, `SMRL`, `SMRM`, `SMRW`, `SMRA` or `SMRS` |
//! | 4 to 7 | the number of the entry: 0 for `SMRB`, then 1, 2, 3, ... |
//! | 8 to 11 | length of the content |
//! | then | the content of the entry, see below |
//! | last 4 | CRC-32 (the one of Ethernet and zip) of all bytes of the entry before it |
//!
//! The content of each entry:
//!
//! - `SMRB`, begin: version (2 bytes: 2), tracker (1 byte: `P`, `R`, or `S` for `R` of the small size), 0 (1 byte), the
//!   configuration (2 bytes a number)
//! - `SMRL`, lock: frame: width, height; box: left, top, width, height; window: the same (2 bytes each); its pixels,
//!   row by row
//! - `SMRM`, moved: right, down, in 1/256 pixel (4 bytes each, signed)
//! - `SMRW`, window: frame: width, height; first part: left, top, width, height; second part: the same (2 bytes each;
//!   all 0 if there is no second part); the pixels of the first part, the pixels of the second part
//! - `SMRA`, answer: fine box: left, top (4 bytes each, signed), width, height (4 bytes each); state (1 byte,
//!   [`State::code`](super::State::code): 0 tracking, 1 leaving, 2 uncertain, 3 lost); flags (1 byte, a sum of: 1 found
//!   again, 2 has a runner-up, 4 has an alpha, 8 has an identity); confidence, ratio, runner-up's ratio, alpha, identity
//!   (2 bytes each, 0 if there is none); scale (4 bytes)
//! - `SMRS`, restored: the saved target ([`Target::save`]) that the tracker continued with
//!
//! The numbers of the configuration of each tracker:
//!
//! - `P`: the 256 entries of the table, then [`paper::Config`](crate::paper::Config)'s [`Settings::SETTINGS`]
//! - `R` and `S`: the 256 entries of the table, then those of [`robust::Config`](crate::robust::Config), with four numbers that
//!   are always 1 after `sweep`. The number of the refiner is left out if it is off
//!
//! A window without an answer is an update that was cancelled or did not end. A new `SMRB` may follow anywhere, even in
//! the middle of an entry that was cut off: firmware that restarts appends to the record. Its content has at most 640
//! bytes in every version.

mod read;
mod replay;
#[cfg(test)]
mod tests;

pub use read::{Begin, Damage, Entries, Entry, Flaw, Found, entries, first};
pub use replay::{Difference, Player, Replayed, Stop, replay};

use super::checksum::Crc;
use super::settings::recorded;
use super::update::SEAL;
use super::{Answer, Settings, Target};
use crate::image::{Frame, Image, Rect, Windows};

/// The version of the format.
pub const VERSION: u16 = 2;
/// The size of an entry's head in bytes; its last four bytes are the length of the content.
pub const HEAD: usize = 12;
/// The size of an entry in bytes, without its content.
pub const AROUND: usize = HEAD + 4;

/// The kind of an entry: its first four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Tag {
    /// A tracker and its configuration.
    Begin,
    /// A lock on a box.
    Lock,
    /// A turn of the camera.
    Moved,
    /// The pixels of an update that is about to begin.
    Window,
    /// The answer of an update.
    Answer,
    /// A saved target that was restored.
    Restored,
}

impl Tag {
    /// All tags.
    pub const ALL: [Self; 6] = [Self::Begin, Self::Lock, Self::Moved, Self::Window, Self::Answer, Self::Restored];

    /// The bytes of the tag in a record.
    #[must_use]
    pub const fn bytes(self) -> [u8; 4] {
        *match self {
            Self::Begin => b"SMRB",
            Self::Lock => b"SMRL",
            Self::Moved => b"SMRM",
            Self::Window => b"SMRW",
            Self::Answer => b"SMRA",
            Self::Restored => b"SMRS",
        }
    }
}

/// A target of either tracker, for a `Recorder`. [`Settings::of_numbers`] restores the configuration from a record.
pub trait Recorded: Target<Config: Settings> {
    /// The letter of the tracker in a record: `P`, `R`, or `S` for the robust tracker of the small size.
    const TRACKER: u8 = Self::LETTER;
}

impl<T: Target<Config: Settings>> Recorded for T {}

/// Writes a record; see the [module](self). Each call writes one entry in chunks: a row of pixels, a saved target, or
/// at most 64 bytes. After an error of the writer, later calls write nothing, so that nothing follows half an entry. An
/// entry with more than `u32::MAX` bytes of content, as the two windows of a frame of 65,535x65,535 pixels can have, is
/// not written either, nor are later ones: see [`Recorder::is_whole`].
pub struct Recorder<W> {
    write: W,
    entries: u32,
    failed: bool,
}

impl<W> core::fmt::Debug for Recorder<W> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Recorder").field("entries", &self.entries).field("failed", &self.failed).finish_non_exhaustive()
    }
}

impl<E, W: FnMut(&[u8]) -> Result<(), E>> Recorder<W> {
    /// Begins a record of `target`. If the target is already locked, call [`Recorder::restored`] next.
    ///
    /// # Errors
    /// The writer's.
    pub fn begin<T: Recorded>(target: &T, write: W) -> Result<Self, E> {
        let mut recorder = Self::resume(0, write);
        recorder.beginning(target)?;
        Ok(recorder)
    }

    /// A recorder that continues a record after its first `entries` entries, 1 or more. For programs that do not keep the
    /// recorder, but [`Recorder::entries`], as the interface for C does.
    pub const fn resume(entries: u32, write: W) -> Self {
        Self { write, entries, failed: false }
    }

    /// The number of entries so far: also the number of the next entry. An entry that failed counts.
    pub const fn entries(&self) -> u32 {
        self.entries
    }

    fn beginning<T: Recorded>(&mut self, target: &T) -> Result<(), E> {
        let mut numbers = 0;
        recorded(target.config(), |_| numbers += 1);
        self.entry(Tag::Begin, 4 + 2 * numbers, |entry| {
            entry.u16(VERSION);
            entry.put(&[T::TRACKER, 0]);
            recorded(target.config(), |number| entry.u16(number));
        })
    }

    /// Records the lock of `target` on `locked` in `frame`. Call it after [`Target::lock`], if that has succeeded.
    ///
    /// # Errors
    /// The writer's.
    pub fn lock<T: Recorded>(&mut self, target: &T, frame: &Frame<'_>, locked: Rect) -> Result<(), E> {
        self.lock_of(frame, locked, target.lock_window(frame.bounds(), locked))
    }

    /// As [`Recorder::lock`], for a program that has only the lock window of the target, not its type.
    ///
    /// # Errors
    /// The writer's.
    #[inline(never)] // one copy for both trackers
    pub fn lock_of(&mut self, frame: &Frame<'_>, locked: Rect, window: Rect) -> Result<(), E> {
        // A lock whose `window` is empty or not wholly in memory has failed and changed nothing: nothing to record.
        let Some(pixels) = frame.patch(window) else { return Ok(()) };
        self.entry(Tag::Lock, 20 + u64::from(window.area()), |entry| {
            entry.size(frame);
            entry.rect(locked);
            entry.rect(window);
            entry.image(&pixels);
        })
    }

    /// Records a call of [`Target::moved`].
    ///
    /// # Errors
    /// The writer's.
    pub fn moved(&mut self, right: i32, down: i32) -> Result<(), E> {
        self.entry(Tag::Moved, 8, |entry| {
            entry.put(&right.to_le_bytes());
            entry.put(&down.to_le_bytes());
        })
    }

    /// Records the pixels that the next update will read. Call it before [`Target::update`] or before the update's
    /// first step. Writes nothing if the update would fail.
    ///
    /// # Errors
    /// The writer's.
    pub fn window<T: Recorded>(&mut self, target: &T, frame: &Frame<'_>) -> Result<(), E> {
        if target.check(frame, SEAL).is_err() {
            return Ok(());
        }
        target.windows().map_or(Ok(()), |windows| self.window_of(frame, windows))
    }

    /// As [`Recorder::window`], for a program that has only the [`Target::windows`] of the target, not its type. Call it
    /// only before an update that cannot fail: one that has passed [`Checked::update`](crate::calls::Checked::update).
    ///
    /// # Errors
    /// The writer's.
    #[inline(never)] // one copy for both trackers
    pub fn window_of(&mut self, frame: &Frame<'_>, windows: Windows) -> Result<(), E> {
        let (window, sweep) = windows.split();
        let sweep = sweep.unwrap_or_default();
        self.entry(Tag::Window, 20 + u64::from(window.area()) + u64::from(sweep.area()), |entry| {
            entry.size(frame);
            entry.rect(window);
            entry.rect(sweep);
            for pixels in [window, sweep].iter().filter_map(|&part| frame.patch(part)) {
                entry.image(&pixels);
            }
        })
    }

    /// Records the answer of the update.
    ///
    /// # Errors
    /// The writer's.
    pub fn answer(&mut self, answer: &Answer) -> Result<(), E> {
        let Answer { fine, state, confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again, .. } =
            *answer;
        let flag = |is: bool, bit: u8| if is { bit } else { 0 };
        let flags = flag(found_again, 1)
            | flag(runner_up_ratio.is_some(), 2)
            | flag(alpha.is_some(), 4)
            | flag(identity.is_some(), 8);
        self.entry(Tag::Answer, 32, |entry| {
            for side in [fine.x.cast_unsigned(), fine.y.cast_unsigned(), fine.width, fine.height] {
                entry.put(&side.to_le_bytes());
            }
            entry.put(&[state.code(), flags]);
            for number in [Some(confidence), Some(ratio), runner_up_ratio, alpha, identity] {
                entry.u16(number.unwrap_or(0));
            }
            entry.put(&scale.to_le_bytes());
        })
    }

    /// Records that the tracker continues with a saved target. Call it after [`Target::restore`], with the same bytes.
    /// Entries from then on do not depend on those before, so a long flight can be split into several records.
    ///
    /// # Errors
    /// The writer's.
    pub fn restored(&mut self, saved: &[u8]) -> Result<(), E> {
        self.entry(Tag::Restored, saved.len() as u64, |entry| entry.put(saved))
    }

    /// True if everything was written; false once the writer has failed or an entry was too large.
    pub const fn is_whole(&self) -> bool {
        !self.failed
    }

    fn entry(&mut self, tag: Tag, length: u64, fill: impl FnOnce(&mut Writing<'_, E, W>)) -> Result<(), E> {
        let Ok(length) = u32::try_from(length) else {
            self.failed = true;
            return Ok(());
        };
        if self.failed {
            return Ok(());
        }
        let mut entry = Writing { write: &mut self.write, sum: Crc::new(), held: [0; HELD], used: 0, result: Ok(()) };
        entry.put(&tag.bytes());
        entry.put(&self.entries.to_le_bytes());
        entry.put(&length.to_le_bytes());
        fill(&mut entry);
        let result = entry.finish();
        self.entries = self.entries.wrapping_add(1);
        self.failed = result.is_err();
        result
    }
}

/// The size of the buffer that collects short writes, in bytes.
const HELD: usize = 64;

/// The entry that is being written. After an error it writes nothing more.
struct Writing<'a, E, W> {
    write: &'a mut W,
    sum: Crc,
    held: [u8; HELD],
    used: usize,
    result: Result<(), E>,
}

impl<E, W: FnMut(&[u8]) -> Result<(), E>> Writing<'_, E, W> {
    #[inline(never)] // one copy in flash
    fn put(&mut self, bytes: &[u8]) {
        self.sum.update(bytes);
        self.hold(bytes);
    }

    /// Buffers or writes bytes, without adding them to the checksum.
    fn hold(&mut self, bytes: &[u8]) {
        if bytes.len() > HELD - self.used.min(HELD) {
            self.flush();
        }
        match self.held.get_mut(self.used..self.used + bytes.len()) {
            Some(place) => {
                place.iter_mut().zip(bytes).for_each(|(place, &byte)| *place = byte);
                self.used += bytes.len();
            }
            None if self.result.is_ok() => self.result = (self.write)(bytes),
            None => {}
        }
    }

    fn flush(&mut self) {
        let held = self.held.get(..self.used).unwrap_or_default();
        if !held.is_empty() && self.result.is_ok() {
            self.result = (self.write)(held);
        }
        self.used = 0;
    }

    #[inline(never)] // one copy in flash
    fn finish(mut self) -> Result<(), E> {
        let sum = self.sum.finish();
        self.hold(&sum.to_le_bytes());
        self.flush();
        self.result
    }

    #[inline(never)] // one copy in flash
    fn u16(&mut self, number: u16) {
        self.put(&number.to_le_bytes());
    }

    fn size(&mut self, frame: &Frame<'_>) {
        let Rect { width, height, .. } = frame.bounds();
        self.u16(width);
        self.u16(height);
    }

    /// Adds a rectangle that lies inside the frame, so no coordinate is negative.
    #[inline(never)] // one copy in flash
    fn rect(&mut self, rect: Rect) {
        for place in [rect.x, rect.y] {
            self.u16(u16::try_from(place).unwrap_or(0));
        }
        self.u16(rect.width);
        self.u16(rect.height);
    }

    #[inline(never)] // one copy in flash
    fn image(&mut self, image: &Image<'_>) {
        // `Image::rows` would compile to a division by the stride, with a panic if that is 0.
        (0..image.height()).for_each(|y| self.put(image.row(y)));
    }
}

/// Writes bytes of a record to the log of defmt, as one line. `host-sim replay` finds these lines in the printed log.
///
/// ```rust,ignore
/// let Ok(mut recorder) = Recorder::begin(tracker.target(), to_defmt);
/// ```
///
/// # Errors
/// Never.
#[cfg(feature = "defmt")]
pub fn to_defmt(bytes: &[u8]) -> Result<(), core::convert::Infallible> {
    defmt::println!("smr-record {=[u8]:02x}", bytes);
    Ok(())
}
