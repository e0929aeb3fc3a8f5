//! A target as bytes: versioned, checked, and the same on every platform.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 2 | `SMR` |
//! | 3 | which tracker: `P` or `R` |
//! | 4, 5 | version of this form |
//! | 6 to 9 | checksum of the configuration |
//! | 10 to 13 | length of all |
//! | then | what the tracker remembers |
//! | last 4 | checksum of all bytes before |
//!
//! Numbers are little-endian; checksums are CRC-32 (that of Ethernet and zip). The configuration itself is not saved: a table cannot be
//! rebuilt from its address, and firmware has its configuration anyway.

use super::checksum::Crc;
use core::fmt;

const MAGIC: [u8; 3] = *b"SMR";
const VERSION: u16 = 2;
const HEAD: usize = 14;
/// Bytes beside what a tracker remembers.
pub(super) const AROUND: usize = HEAD + 4;

/// Which tracker wrote the bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Kind {
    Paper = b'P',
    Robust = b'R',
}

/// The checksum of a configuration, over those of its numbers that answers depend on.
pub(super) struct ConfigSum(Crc);

impl ConfigSum {
    pub(super) const fn new() -> Self {
        Self(Crc::new())
    }

    pub(super) fn add(&mut self, number: u16) {
        self.0.update(&number.to_le_bytes());
    }

    pub(super) fn finish(self) -> u32 {
        self.0.finish()
    }
}

/// Writes numbers one after the other.
pub(super) struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    /// For a target of so many bytes in all. Nothing is written if there is no room for them.
    pub(super) fn new(bytes: &'a mut [u8], size: usize, kind: Kind, config: u32) -> Result<Self, SaveError> {
        let bytes = bytes.get_mut(..size).ok_or(SaveError::BufferTooSmall)?;
        let mut writer = Self { bytes, at: 0 };
        writer.put(&MAGIC);
        writer.put(&[kind as u8]);
        writer.u16(VERSION);
        writer.u32(config);
        writer.u32(u32::try_from(size).unwrap_or(u32::MAX));
        Ok(writer)
    }

    #[inline(never)] // one copy in flash
    pub(super) fn put(&mut self, bytes: &[u8]) {
        let end = self.at + bytes.len();
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.iter_mut().zip(bytes).for_each(|(place, &byte)| *place = byte);
        }
        self.at = end;
    }

    pub(super) fn u16(&mut self, number: u16) {
        self.put(&number.to_le_bytes());
    }

    pub(super) fn u32(&mut self, number: u32) {
        self.put(&number.to_le_bytes());
    }

    pub(super) fn i32(&mut self, number: i32) {
        self.u32(number.cast_unsigned());
    }

    pub(super) fn i64(&mut self, number: i64) {
        self.put(&number.to_le_bytes());
    }

    /// The checksum; says how many bytes there are in all.
    pub(super) fn finish(mut self) -> usize {
        let sum = Crc::of(self.bytes.get(..self.at).unwrap_or_default());
        self.u32(sum);
        self.at
    }
}

/// Reads numbers one after the other; `None` where the bytes end.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// The part that a tracker of this `kind` has written, if the rest of the bytes is as it should be.
    pub(super) fn new(bytes: &'a [u8], kind: Kind, config: u32) -> Result<Self, RestoreError> {
        let mut head = Reader { bytes };
        if head.take::<3>() != Some(MAGIC) {
            return Err(RestoreError::NotSaved);
        }
        let tracker = head.u8().ok_or(RestoreError::Truncated)?;
        if head.u16().ok_or(RestoreError::Truncated)? != VERSION {
            return Err(RestoreError::OtherVersion);
        }
        let (saved_config, length) = (head.u32(), head.u32());
        let (Some(saved_config), Some(length)) = (saved_config, length) else { return Err(RestoreError::Truncated) };
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if length < AROUND {
            return Err(RestoreError::Damaged);
        }
        let all = bytes.get(..length).ok_or(RestoreError::Truncated)?;
        let (body, sum) = all.split_at_checked(length - 4).ok_or(RestoreError::Truncated)?;
        if (Reader { bytes: sum }).u32() != Some(Crc::of(body)) {
            return Err(RestoreError::Damaged);
        }
        if tracker != kind as u8 {
            return Err(RestoreError::OtherTracker);
        }
        if saved_config != config {
            return Err(RestoreError::OtherConfig);
        }
        Ok(Self { bytes: body.get(HEAD..).unwrap_or_default() })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.bytes.split_first_chunk::<N>()?;
        self.bytes = rest;
        Some(*first)
    }

    pub(super) fn slice(&mut self, count: usize) -> Option<&'a [u8]> {
        let (first, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(first)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    #[inline(never)] // one copy in flash
    pub(super) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    #[inline(never)] // one copy in flash
    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.u32().map(u32::cast_signed)
    }

    #[inline(never)] // one copy in flash
    pub(super) fn i64(&mut self) -> Option<i64> {
        self.take().map(i64::from_le_bytes)
    }

    /// True if everything was read.
    pub(super) const fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}

/// Why a target was not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError {
    /// There is no target yet: lock first.
    NotLocked,
    /// There is no room for the target: [`Target::saved_size`](crate::Target::saved_size) bytes.
    /// [`Target::SAVED_SIZE`](crate::Target::SAVED_SIZE) are always enough.
    BufferTooSmall,
}

impl fmt::Display for SaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotLocked => "there is no target yet: lock first",
            Self::BufferTooSmall => "the buffer is too small for the target",
        })
    }
}

impl core::error::Error for SaveError {}

/// Why bytes are not a target to go on with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError {
    /// The bytes are not those of a saved target.
    NotSaved,
    /// They were written by another version of the crate.
    OtherVersion,
    /// They end too early.
    Truncated,
    /// Some of them have changed since they were written.
    Damaged,
    /// They are those of the other tracker's target.
    OtherTracker,
    /// They are those of a target with another configuration: answers would differ.
    OtherConfig,
    /// The template has more pixels, or the window more offsets, than there is room for here.
    TooLarge,
}

impl fmt::Display for RestoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotSaved => "these are not the bytes of a saved target",
            Self::OtherVersion => "the target was saved by another version",
            Self::Truncated => "the saved target ends too early",
            Self::Damaged => "the saved target is damaged: its checksum is wrong",
            Self::OtherTracker => "the target was saved by the other tracker",
            Self::OtherConfig => "the target was saved with another configuration",
            Self::TooLarge => "the saved target is too large for this tracker",
        })
    }
}

impl core::error::Error for RestoreError {}
