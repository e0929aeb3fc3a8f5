//! A saved target: bytes with a version and a checksum, the same on every platform.
//!
//! | bytes | content |
//! |---|---|
//! | 0 to 2 | `SMR` |
//! | 3 | the tracker: `P`, `R`, or `S` for `R` of the small size |
//! | 4, 5 | version of this format |
//! | 6 to 9 | checksum of the table of similarities |
//! | 10 to 13 | length of all bytes |
//! | then 2 each | the other numbers of the configuration: 26 of `P`, 13 of `R` and `S`, in the order of their settings |
//! | then | the state of the tracker |
//! | last 4 | checksum of all bytes before |
//!
//! Numbers are little-endian; checksums are CRC-32 (the one of Ethernet and zip). A target continues only with the
//! settings with which it was saved: an error names the first one that differs. Of the table only a checksum is saved.

use super::checksum::Crc;
use super::error::{RestoreError, SaveError};
use super::settings::{Kind, Settings};
use crate::similarity::Table;

const MAGIC: [u8; 3] = *b"SMR";
const VERSION: u16 = 6;
const HEAD: usize = 14;

/// The size in bytes of a saved target without its state: head, `numbers` values of the configuration, and checksum.
pub(super) const fn around(numbers: usize) -> usize {
    HEAD + 2 * numbers + 4
}

/// The part of a configuration that a saved target contains.
pub(super) struct Saved<'a> {
    kind: Kind,
    table: &'static Table,
    numbers: &'a [u16],
}

impl<'a> Saved<'a> {
    pub(super) fn of<C: Settings>(kind: Kind, config: &C, numbers: &'a C::Array) -> Self {
        Self { kind, table: config.table(), numbers: numbers.as_ref() }
    }

    fn table_sum(&self) -> u32 {
        let mut sum = Crc::new();
        self.table.entries().iter().for_each(|entry| sum.update(&entry.to_le_bytes()));
        sum.finish()
    }
}

pub(super) struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    /// Begins a saved target of `size` bytes in all. Writes nothing if `bytes` is too small.
    pub(super) fn new(bytes: &'a mut [u8], size: usize, config: &Saved<'_>) -> Result<Self, SaveError> {
        let bytes = bytes.get_mut(..size).ok_or(SaveError::BufferTooSmall)?;
        let mut writer = Self { bytes, at: 0 };
        writer.put(&MAGIC);
        writer.put(&[config.kind as u8]);
        writer.u16(VERSION);
        writer.u32(config.table_sum());
        writer.u32(u32::try_from(size).unwrap_or(u32::MAX));
        config.numbers.iter().for_each(|&number| writer.u16(number));
        Ok(writer)
    }

    #[inline(never)]
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

    /// Appends the checksum and returns the total number of bytes.
    pub(super) fn finish(mut self) -> usize {
        let sum = Crc::of(self.bytes.get(..self.at).unwrap_or_default());
        self.u32(sum);
        self.at
    }
}

/// Reads bytes value by value. Each read returns `None` at the end of the bytes.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks head, configuration and checksum of a saved target, and returns a reader of its state.
    pub(super) fn new(bytes: &'a [u8], config: &Saved<'_>) -> Result<Self, Refusal> {
        let mut head = Reader { bytes };
        if head.take::<3>() != Some(MAGIC) {
            return Err(RestoreError::NotSaved.into());
        }
        let tracker = head.u8().ok_or(RestoreError::Truncated)?;
        if head.u16().ok_or(RestoreError::Truncated)? != VERSION {
            return Err(RestoreError::OtherVersion.into());
        }
        let (table, length) = (head.u32(), head.u32());
        let (Some(table), Some(length)) = (table, length) else { return Err(RestoreError::Truncated.into()) };
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if length < around(0) {
            return Err(RestoreError::Damaged.into());
        }
        let all = bytes.get(..length).ok_or(RestoreError::Truncated)?;
        let (body, sum) = all.split_at_checked(length - 4).ok_or(RestoreError::Truncated)?;
        if (Reader { bytes: sum }).u32() != Some(Crc::of(body)) {
            return Err(RestoreError::Damaged.into());
        }
        if tracker != config.kind as u8 {
            return Err(RestoreError::OtherTracker.into());
        }
        if table != config.table_sum() {
            return Err(RestoreError::OtherConfig("table").into());
        }
        let mut state = Self { bytes: body.get(HEAD..).unwrap_or_default() };
        for (place, &number) in config.numbers.iter().enumerate() {
            if state.u16().ok_or(RestoreError::Damaged)? != number {
                return Err(Refusal::Setting(place));
            }
        }
        Ok(state)
    }

    pub(super) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
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

    #[inline(never)]
    pub(super) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    #[inline(never)]
    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.u32().map(u32::cast_signed)
    }

    #[inline(never)]
    pub(super) fn i64(&mut self) -> Option<i64> {
        self.take().map(i64::from_le_bytes)
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}

/// The reason why a target was not restored. Stores an index, not a name, so a program need not contain all names.
pub(super) enum Refusal {
    Error(RestoreError),
    /// Index of the first value of the configuration that differs.
    Setting(usize),
}

impl From<RestoreError> for Refusal {
    fn from(error: RestoreError) -> Self {
        Self::Error(error)
    }
}

impl Refusal {
    #[inline(always)]
    pub(super) fn named<C: Settings>(self) -> RestoreError {
        match self {
            Self::Error(error) => error,
            Self::Setting(place) => RestoreError::OtherConfig(C::NAMES.get(place).copied().unwrap_or_default()),
        }
    }
}
