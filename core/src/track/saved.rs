//! A saved target: bytes with a version and a checksum, the same on every platform.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 2 | `SMR` |
//! | 3 | the tracker: `P` or `R` |
//! | 4, 5 | version of this format |
//! | 6 to 9 | checksum of the configuration |
//! | 10 to 13 | length of all bytes |
//! | then | the state of the tracker |
//! | last 4 | checksum of all bytes before |
//!
//! Numbers are little-endian; checksums are CRC-32 (the one of Ethernet and zip). The configuration itself is not saved: it refers to a
//! table by its address, and firmware has its configuration anyway.

use super::checksum::Crc;
use core::fmt;

const MAGIC: [u8; 3] = *b"SMR";
const VERSION: u16 = 2;
const HEAD: usize = 14;
/// Bytes other than the state of the tracker.
pub(super) const AROUND: usize = HEAD + 4;

/// The tracker that wrote the bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Kind {
    Paper = b'P',
    Robust = b'R',
}

/// The checksum of the numbers of a configuration that answers depend on.
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

/// Writes a saved target, number by number.
pub(super) struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    /// For a target of `size` bytes in all. Writes nothing if `bytes` is too small.
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

    /// Writes the checksum and returns the number of bytes in all.
    pub(super) fn finish(mut self) -> usize {
        let sum = Crc::of(self.bytes.get(..self.at).unwrap_or_default());
        self.u32(sum);
        self.at
    }
}

/// The length of the saved target at the beginning of `bytes`, if it is whole: of whatever tracker and configuration.
pub(super) fn whole_length(bytes: &[u8]) -> Option<usize> {
    let mut head = Reader { bytes };
    let (magic, _tracker, version) = (head.take::<3>()?, head.u8()?, head.u16()?);
    let (_config, length) = (head.u32()?, head.u32()?);
    let length = usize::try_from(length).ok()?;
    let body = bytes.get(..length.checked_sub(4)?)?;
    let sum = Reader { bytes: bytes.get(length - 4..)? }.u32()?;
    (magic == MAGIC && version == VERSION && length >= AROUND && sum == Crc::of(body)).then_some(length)
}

/// Reads a saved target, number by number; `None` at the end of the bytes.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// A reader of the state of a tracker of this `kind`, if everything around the state is valid.
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

    /// True if all bytes were read.
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
    /// The buffer is smaller than [`Target::saved_size`](crate::Target::saved_size).
    /// [`Target::SAVED_SIZE`](crate::Target::SAVED_SIZE) bytes are always enough.
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

/// Why a target was not restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError {
    /// The bytes are not those of a saved target.
    NotSaved,
    /// Another version of the crate wrote the bytes.
    OtherVersion,
    /// The bytes end too early.
    Truncated,
    /// The bytes have changed since they were written.
    Damaged,
    /// The other tracker saved the target.
    OtherTracker,
    /// The target was saved with another configuration, so answers would differ.
    OtherConfig,
    /// The template has more pixels, or the window more offsets, than this tracker has room for.
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
