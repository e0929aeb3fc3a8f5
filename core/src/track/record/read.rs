//! Parses and checks the entries of a record.
//!
//! Bytes that belong to no entry may hold the heads of many damaged entries, each of which claims most of the record. So
//! that the work stays linear in the size of the record, [`Entries`] checksums damaged entries of [`DAMAGED`] times that
//! size. After that, an entry that holds a whole `SMRB` is cut off by it, and skipped bytes that may hold an entry are
//! damage. An intact record never gets there.

use super::{AROUND, HEAD, Tag, VERSION};
use crate::image::{FineRect, Frame, Image, Rect};
use crate::similarity::Table;
use crate::track::checksum::Crc;
use crate::track::saved::Reader;
use crate::track::{Answer, Settings, State};
use core::{fmt, mem};

/// `TABLE`: number of entries in a similarity table. `MAX_NUMBERS`: maximum number of a configuration's other values.
const TABLE: usize = 256;
const MAX_NUMBERS: usize = 32;
/// The largest content of an `SMRB` in any version, in bytes.
const MAX_BEGIN: usize = 640;
/// The bytes of damaged entries that are checksummed for each byte of the record.
const DAMAGED: usize = 8;

/// The entries of `record`, in order. Bytes that belong to no entry are skipped before an `SMRB` (begin) and at the
/// end: restarted firmware appends to a truncated record, see [`Entries::cut_off`]. The [module](super) has an example.
#[must_use]
pub const fn entries(record: &[u8]) -> Entries<'_> {
    Entries { record, at: 0, next: 0, cut_off: 0, begin: None, spare: record.len().saturating_mul(DAMAGED), work: 0 }
}

/// Parses the complete entry at the start of `bytes`. Its first [`HEAD`] bytes end with the length of its content.
///
/// # Errors
/// [`Flaw::NoEntry`] if no whole entry begins there, else what is wrong with its content.
pub fn first(bytes: &[u8]) -> Result<Found<'_>, Damage> {
    let of = |flaw| Damage { at: 0, flaw };
    let claim = Claim::at(bytes).filter(Claim::is_intact).ok_or(of(Flaw::NoEntry(bytes.len())))?;
    let entry = read(claim.tag, claim.content).map_err(of)?;
    Ok(Found { at: 0, size: claim.size(), number: claim.number, entry })
}

/// An iterator over the entries of a record: see [`entries`]. It ends after the first damage.
#[derive(Clone, Debug)]
pub struct Entries<'a> {
    record: &'a [u8],
    at: usize,
    /// The number that the next entry must have, unless it begins a record.
    next: u32,
    cut_off: usize,
    /// The last answer of `find_begin`.
    begin: Option<usize>,
    /// Bytes of damaged entries that may still be checksummed.
    spare: usize,
    work: u64,
}

/// An entry, and its place in the record.
#[derive(Clone, Copy, Debug)]
pub struct Found<'a> {
    /// Offset of the entry in the record, in bytes.
    pub at: usize,
    /// Size of the entry in bytes.
    pub size: usize,
    /// Sequence number: 0 for [`Entry::Begin`], then 1, 2, 3, ...
    pub number: u32,
    /// The content of the entry.
    pub entry: Entry<'a>,
}

/// An event of a flight.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// A record begins, with this tracker and configuration.
    Begin(Begin<'a>),
    /// A lock on `bbox`. The lock read the part `window` of the frame.
    Lock {
        /// The frame; only the pixels of `window` are in memory.
        frame: Frame<'a>,
        /// The part of the frame that the lock read.
        window: Rect,
        /// The box that was locked.
        bbox: Rect,
    },
    /// A call of `Target::moved`: the picture's motion from a turn of the camera, in units of 1/256 pixel.
    Moved {
        /// Motion to the right.
        right: i32,
        /// Motion down.
        down: i32,
    },
    /// An update is about to begin.
    Window {
        /// The frame; only the pixels of `window` and of `sweep` are in memory.
        frame: Frame<'a>,
        /// The part of the frame that the update may read in any state of the target (`Target::window`).
        window: Rect,
        /// A second part of the frame that the update may read for a lost target (`Target::sweep_window`).
        sweep: Option<Rect>,
    },
    /// The answer of the update.
    Answer(Answer),
    /// The saved target that the tracker continued with.
    Restored(&'a [u8]),
}

/// The tracker that a record begins with.
#[derive(Clone, Copy)]
pub struct Begin<'a> {
    /// The tracker's letter, [`Recorded::TRACKER`](super::Recorded::TRACKER).
    pub tracker: u8,
    numbers: &'a [u8],
}

impl fmt::Debug for Begin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Begin").field("tracker", &char::from(self.tracker)).finish_non_exhaustive()
    }
}

impl Begin<'_> {
    /// The recorded configuration; `None` if it is no valid `C` of this tracker, or if its similarity table is neither the paper's nor
    /// the one in `rest`. `rest` also supplies the settings that a record lacks (no answer depends on them).
    #[must_use]
    pub fn config<C: Settings>(&self, rest: &C) -> Option<C> {
        let mut numbers = self.numbers.as_chunks().0.iter().copied().map(u16::from_le_bytes);
        let entries = numbers.clone().take(TABLE);
        let mut tables = [&Table::PAPER, rest.table()].into_iter();
        let table = tables.find(|table| table.entries().iter().copied().eq(entries.clone()))?;
        numbers.nth(TABLE - 1)?;
        let (mut all, count) = ([0; MAX_NUMBERS], numbers.len());
        all.iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
        let found = C::of_numbers(table, all.get(..count)?)
            .ok()
            .filter(|_| C::KINDS.iter().any(|&kind| kind as u8 == self.tracker))?;
        let mut config = *rest;
        config.put(table, &found.numbers());
        Some(config)
    }
}

/// The damage of a record, and its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Damage {
    /// Offset of the damage in the record, in bytes.
    pub at: usize,
    /// The kind of damage.
    pub flaw: Flaw,
}

/// A kind of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// The count of bytes from `Damage::at` on that belong to no entry, although an entry other than `Entry::Begin`
    /// follows them, or may follow: after 8 times the record's bytes in damaged entries, no others are checked. From
    /// `first`: the count of all bytes passed to it, because no intact entry begins there.
    NoEntry(usize),
    /// The entry with this number is missing.
    Missing(u32),
    /// The record is of this version, not of [`VERSION`].
    OtherVersion(u16),
    /// The content of an entry is invalid for its tag.
    Content,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = self.at;
        match self.flaw {
            Flaw::NoEntry(bytes) => write!(f, "{bytes} bytes at byte {at} are damaged: no entry"),
            Flaw::Missing(number) => write!(f, "byte {at}: entry {number} is missing"),
            Flaw::OtherVersion(version) => {
                write!(f, "byte {at}: version {version} of the record: expected {VERSION}")
            }
            Flaw::Content => write!(f, "the entry at byte {at} does not hold what its kind holds"),
        }
    }
}

impl core::error::Error for Damage {}

impl Entries<'_> {
    /// The count of bytes that the latest call of `next` skipped because they belong to no entry: those directly before
    /// the entry that it found, or those at the end of the record if it found none.
    #[must_use]
    pub const fn cut_off(&self) -> usize {
        self.cut_off
    }

    /// The work so far: the bytes that were checksummed, at most 70 for each byte of the record, however it is damaged.
    #[must_use]
    pub const fn work(&self) -> u64 {
        self.work
    }

    fn is_intact(&mut self, claim: &Claim<'_>) -> bool {
        self.work += claim.size() as u64;
        claim.is_intact()
    }

    /// True if the entry that `claim` describes begins at `self.at`. `None` if that may be so, but no work is left to
    /// tell. `is_next`: no bytes were skipped before it.
    fn check(&mut self, claim: &Claim<'_>, is_next: bool) -> Option<bool> {
        if claim.is_begin() {
            return Some(self.find_begin(self.at) == self.at);
        }
        if claim.size() <= self.spare {
            let is_intact = self.is_intact(claim);
            self.spare -= if is_intact { 0 } else { claim.size() };
            return Some(is_intact);
        }
        // If an entry that ends before the next `SMRB` is damaged, its bytes are skipped and never checksummed again.
        is_next.then(|| self.at + claim.size() <= self.find_begin(self.at + 1) && self.is_intact(claim))
    }

    /// Offset of the first intact `SMRB` from `start` on; the end of the record if there is none. `start` never decreases,
    /// so no byte is searched twice.
    fn find_begin(&mut self, start: usize) -> usize {
        if let Some(begin) = self.begin.filter(|&begin| begin >= start) {
            return begin;
        }
        let mut begin = start;
        while let Some(rest) = self.record.get(begin..).filter(|rest| !rest.is_empty()) {
            if Claim::at(rest).is_some_and(|claim| claim.is_begin() && self.is_intact(&claim)) {
                break;
            }
            begin += 1;
        }
        self.begin = Some(begin);
        begin
    }

    fn end(&mut self) {
        self.record = &[];
    }
}

impl<'a> Iterator for Entries<'a> {
    type Item = Result<Found<'a>, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        let start = self.at;
        let claim = loop {
            let rest = self.record.get(self.at..).filter(|rest| !rest.is_empty());
            let Some(rest) = rest else {
                self.cut_off = self.at - start.min(self.at);
                self.at = start;
                self.end();
                return None;
            };
            if let Some(claim) = Claim::at(rest) {
                match self.check(&claim, self.at == start) {
                    Some(true) => break claim,
                    Some(false) => {}
                    None => {
                        self.end();
                        return Some(Err(Damage { at: start, flaw: Flaw::NoEntry(self.at - start) }));
                    }
                }
            }
            self.at += 1;
        };
        let at = self.at;
        self.cut_off = at - start.min(at);
        let (size, Claim { tag, number, content, .. }) = (claim.size(), claim);
        self.at += size;
        let expected = if tag == Tag::Begin { 0 } else { self.next };
        self.next = number.wrapping_add(1);
        let entry = if self.cut_off > 0 && tag != Tag::Begin {
            Err(Damage { at: start, flaw: Flaw::NoEntry(self.cut_off) })
        } else if number != expected {
            Err(Damage { at, flaw: Flaw::Missing(expected) })
        } else {
            read(tag, content).map_err(|flaw| Damage { at, flaw })
        };
        if entry.is_err() {
            self.end();
        }
        Some(entry.map(|entry| Found { at, size, number, entry }))
    }
}

/// The entry that a head describes. All its bytes are there, but they may be damaged.
struct Claim<'a> {
    tag: Tag,
    number: u32,
    content: &'a [u8],
    /// Head and content.
    summed: &'a [u8],
    sum: u32,
}

impl<'a> Claim<'a> {
    /// The claim of the head at the start of `bytes`; `None` if there is none, or if the entry is incomplete.
    #[inline(never)]
    fn at(bytes: &'a [u8]) -> Option<Self> {
        let mut head = Reader { bytes };
        let tag = head.take()?;
        let tag = Tag::ALL.into_iter().find(|known| known.bytes() == tag)?;
        let (number, length) = (head.u32()?, usize::try_from(head.u32()?).ok()?);
        let content = head.slice(length)?;
        let sum = head.u32()?;
        Some(Self { tag, number, content, summed: bytes.get(..HEAD + content.len())?, sum })
    }

    const fn size(&self) -> usize {
        AROUND + self.content.len()
    }

    /// True for an `SMRB` that any version can have written. No two of them begin within 12 bytes, and each is small, so
    /// the work to check all of them is at most (640 + 16) / 12 bytes for each byte of the record.
    const fn is_begin(&self) -> bool {
        matches!(self.tag, Tag::Begin) && self.number == 0 && self.content.len() <= MAX_BEGIN
    }

    fn is_intact(&self) -> bool {
        Crc::of(self.summed) == self.sum
    }
}

#[inline(never)]
fn read(tag: Tag, content: &[u8]) -> Result<Entry<'_>, Flaw> {
    let mut from = Reader { bytes: content };
    if tag == Tag::Begin {
        let version = from.u16().ok_or(Flaw::Content)?;
        if version != VERSION {
            return Err(Flaw::OtherVersion(version));
        }
    }
    entry(tag, &mut from).filter(|_| from.is_empty()).ok_or(Flaw::Content)
}

fn entry<'a>(tag: Tag, from: &mut Reader<'a>) -> Option<Entry<'a>> {
    Some(match tag {
        Tag::Begin => {
            let [tracker, _] = from.take()?;
            Entry::Begin(Begin { tracker, numbers: mem::take(&mut from.bytes) })
        }
        Tag::Lock => {
            let (size, bbox, window) = (from.size()?, from.rect()?, from.rect()?);
            Entry::Lock { frame: from.frame(size, window)?, window, bbox }
        }
        Tag::Moved => Entry::Moved { right: from.i32()?, down: from.i32()? },
        Tag::Window => {
            let (size, window, sweep) = (from.size()?, from.rect()?, from.rect()?);
            let sweep = Some(sweep).filter(|sweep| !sweep.is_empty());
            let mut frame = from.frame(size, window)?;
            if let Some(sweep) = sweep {
                let (image, x, y) = from.part(sweep)?;
                frame = frame.and_part(image, x, y).ok()?;
            }
            Entry::Window { frame, window, sweep }
        }
        Tag::Answer => Entry::Answer(from.answer()?),
        Tag::Restored => Entry::Restored(mem::take(&mut from.bytes)),
    })
}

/// Each function reads the next value of an entry's content; `None` if too few bytes are left or the value is invalid.
impl<'a> Reader<'a> {
    fn size(&mut self) -> Option<(u16, u16)> {
        Some((self.u16()?, self.u16()?))
    }

    fn rect(&mut self) -> Option<Rect> {
        let (x, y) = self.size()?;
        let (width, height) = self.size()?;
        Some(Rect::new(x.into(), y.into(), width, height))
    }

    /// (image, x, y): the next pixels as the image of `window`, and the window's top left corner.
    fn part(&mut self, window: Rect) -> Option<(Image<'a>, u16, u16)> {
        let pixels = self.slice(usize::try_from(window.area()).ok()?)?;
        let image = Image::new(pixels, window.width, window.height).ok()?;
        Some((image, u16::try_from(window.x).ok()?, u16::try_from(window.y).ok()?))
    }

    fn frame(&mut self, (width, height): (u16, u16), window: Rect) -> Option<Frame<'a>> {
        let (image, x, y) = self.part(window)?;
        Frame::part(image, x, y, width, height).ok()
    }

    fn answer(&mut self) -> Option<Answer> {
        let fine = FineRect { x: self.i32()?, y: self.i32()?, width: self.u32()?, height: self.u32()? };
        let [state, flags] = self.take()?;
        let (confidence, ratio) = (self.u16()?, self.u16()?);
        let (runner_up, alpha, identity) = (self.u16()?, self.u16()?, self.u16()?);
        let if_there = |bit: u8, number: u16| (flags & bit != 0).then_some(number);
        let answer = Answer {
            bbox: fine.whole(),
            fine,
            state: State::from_code(state)?,
            confidence,
            ratio,
            runner_up_ratio: if_there(2, runner_up),
            alpha: if_there(4, alpha),
            identity: if_there(8, identity),
            scale: self.u32()?,
            found_again: flags & 1 != 0,
        };
        (flags < 16).then_some(answer)
    }
}
