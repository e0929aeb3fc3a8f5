//! The entries of a flight record, one after the other, from bytes or from a printed log; what cannot be read is said, not guessed.

use anyhow::{Context, Result, ensure};
use smr_core::record::{AROUND, HEAD, Tag};
use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Read};

/// More than any entry has: two windows of the largest frame are not kept in one.
const MOST: usize = 256 << 20;

/// How much may lie between two entries, in MiB: what goes on longer than that is no record.
const MOST_BETWEEN: u32 = 64;

/// What stands before the bytes in a line of a log.
const LOGGED: &[u8] = b"smr-record [";

/// How far into a file a log's first line of a record is looked for.
const FIRST: usize = 1 << 20;

/// An entry whose checksum is right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    pub tag: Tag,
    pub number: u32,
    /// Where it begins in the record, in bytes.
    pub at: u64,
    pub holds: Vec<u8>,
}

/// What comes next in a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next {
    Entry(Entry),
    /// Bytes that are no entry.
    Skipped {
        at: u64,
        bytes: u64,
    },
    End,
}

/// A record as it is read: no more of it is in memory than an entry.
pub struct Entries<R> {
    source: R,
    held: Vec<u8>,
    /// How much of what is held is done with.
    done: usize,
    /// Where what is held begins.
    start: u64,
}

impl<R: Read> Entries<R> {
    pub const fn new(source: R) -> Self {
        Self { source, held: Vec::new(), done: 0, start: 0 }
    }

    pub fn read(&mut self) -> Result<Next> {
        let at = self.start + self.done as u64;
        if let Some(entry) = self.whole()? {
            return Ok(Next::Entry(entry));
        }
        if !self.has(1)? {
            return Ok(Next::End);
        }
        let mut bytes = 0;
        loop {
            // The next byte that may begin an entry.
            let rest = &self.held[self.done..];
            let step = rest.iter().skip(1).position(|&byte| byte == b'S').map_or(rest.len(), |place| place + 1);
            self.done += step;
            bytes += step as u64;
            ensure!(bytes <= u64::from(MOST_BETWEEN) << 20, "{}", nothing_in(at));
            if !self.has(1)? || (self.has(HEAD)? && self.peek_whole()?) {
                return Ok(Next::Skipped { at, bytes });
            }
        }
    }

    /// The entry that begins here, if one does.
    fn whole(&mut self) -> Result<Option<Entry>> {
        let at = self.start + self.done as u64;
        let Some((tag, number, length)) = self.head()? else { return Ok(None) };
        if !self.peek_whole()? {
            return Ok(None);
        }
        let holds = self.held[self.done + HEAD..][..length].to_vec();
        self.done += AROUND + length;
        Ok(Some(Entry { tag, number, at, holds }))
    }

    fn head(&mut self) -> Result<Option<(Tag, u32, usize)>> {
        if !self.has(HEAD)? {
            return Ok(None);
        }
        let head = &self.held[self.done..];
        let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let tag = Tag::ALL.into_iter().find(|tag| head[..4] == tag.bytes());
        let length = word(8) as usize;
        Ok(tag.filter(|_| length <= MOST).map(|tag| (tag, word(4), length)))
    }

    fn peek_whole(&mut self) -> Result<bool> {
        let Some((_, _, length)) = self.head()? else { return Ok(false) };
        if !self.has(AROUND + length)? {
            return Ok(false);
        }
        let (entry, sum) = self.held[self.done..][..AROUND + length].split_at(HEAD + length);
        Ok(crc32fast::hash(entry).to_le_bytes() == sum)
    }

    /// True if so many bytes can be held.
    fn has(&mut self, bytes: usize) -> Result<bool> {
        let held = self.held.len() - self.done;
        if held >= bytes {
            return Ok(true);
        }
        if self.done > 0 {
            self.held.drain(..self.done);
            self.start += self.done as u64;
            self.done = 0;
        }
        let missing = (bytes - held).max(1 << 16) as u64;
        let read = self.source.by_ref().take(missing).read_to_end(&mut self.held);
        read.context("cannot read the record")?;
        Ok(self.held.len() >= bytes)
    }
}

fn nothing_in(at: u64) -> String {
    format!("no entry in {MOST_BETWEEN} MiB after byte {at}: expected less than that between two of them")
}

/// The bytes of a record, whether `source` holds them as they are or as lines of a log.
pub fn bytes_of(mut source: impl Read + 'static) -> Result<Box<dyn Read>> {
    let mut first = Vec::new();
    source.by_ref().take(FIRST as u64).read_to_end(&mut first).context("cannot read the record")?;
    let binary = Tag::ALL.into_iter().any(|tag| first.starts_with(&tag.bytes()));
    let logged = !binary && first.windows(LOGGED.len()).any(|part| part == LOGGED);
    let source = Cursor::new(first).chain(source);
    Ok(if logged {
        Box::new(Log { source: BufReader::new(source), bytes: Vec::new(), done: 0, between: 0, at: 0 })
    } else {
        Box::new(source)
    })
}

/// The bytes in lines like `smr-record [53, 4d]`, wherever in a line that stands.
struct Log<R> {
    source: R,
    bytes: Vec<u8>,
    done: usize,
    /// How much of the log was read since a line of the record.
    between: u64,
    at: u64,
}

impl<R: BufRead> Read for Log<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.done == self.bytes.len() {
            let mut line = Vec::new();
            // A line that never ends is no log.
            let length = self.source.by_ref().take(MOST as u64).read_until(b'\n', &mut line)? as u64;
            if length == 0 {
                return Ok(0);
            }
            (self.bytes, self.done) = (logged(&line), 0);
            self.at += length;
            self.between = if self.bytes.is_empty() { self.between + length } else { 0 };
            if self.between > u64::from(MOST_BETWEEN) << 20 {
                return Err(io::Error::new(ErrorKind::InvalidData, nothing_in(self.at - self.between)));
            }
        }
        let count = buffer.len().min(self.bytes.len() - self.done);
        buffer[..count].copy_from_slice(&self.bytes[self.done..][..count]);
        self.done += count;
        Ok(count)
    }
}

/// The bytes of a line, up to the first that is none: a log can be cut off in a line.
fn logged(line: &[u8]) -> Vec<u8> {
    let Some(start) = line.windows(LOGGED.len()).position(|part| part == LOGGED) else { return Vec::new() };
    let text = String::from_utf8_lossy(&line[start + LOGGED.len()..]).into_owned();
    let numbers = text.split(']').next().unwrap_or_default().split(", ");
    numbers.map_while(|number| (number.len() == 2).then(|| u8::from_str_radix(number, 16).ok())?).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(tag: Tag, number: u32, holds: &[u8]) -> Vec<u8> {
        let mut bytes = tag.bytes().to_vec();
        bytes.extend(number.to_le_bytes());
        bytes.extend(u32::try_from(holds.len()).unwrap().to_le_bytes());
        bytes.extend(holds);
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    fn all(bytes: &[u8]) -> Vec<Next> {
        let mut entries = Entries::new(bytes);
        let mut all = Vec::new();
        loop {
            match entries.read().unwrap() {
                Next::End => return all,
                next => all.push(next),
            }
        }
    }

    fn whole(tag: Tag, number: u32, at: u64, holds: &[u8]) -> Next {
        Next::Entry(Entry { tag, number, at, holds: holds.to_vec() })
    }

    #[test]
    fn entries_and_what_lies_between_them() {
        let (first, second) = (entry(Tag::Begin, 0, b"SMRB is no entry"), entry(Tag::Moved, 1, b"12345678"));
        let expected = [whole(Tag::Begin, 0, 0, b"SMRB is no entry"), whole(Tag::Moved, 1, 32, b"12345678")];
        assert_eq!(all(&[first.clone(), second.clone()].concat()), expected);
        let between = [first.clone(), b"SMR, S and SMRW".to_vec(), second.clone()].concat();
        let skipped = Next::Skipped { at: 32, bytes: 15 };
        assert_eq!(all(&between)[1..], [skipped, whole(Tag::Moved, 1, 47, b"12345678")]);
        for cut in 1..second.len() {
            let cut_off = [first.clone(), second[..cut].to_vec()].concat();
            assert_eq!(all(&cut_off)[1..], [Next::Skipped { at: 32, bytes: cut as u64 }], "{cut}");
            let began_again = [second[..cut].to_vec(), first.clone()].concat();
            let again =
                [Next::Skipped { at: 0, bytes: cut as u64 }, whole(Tag::Begin, 0, cut as u64, b"SMRB is no entry")];
            assert_eq!(all(&began_again), again, "{cut}");
        }
        for at in 0..first.len() {
            let mut damaged = [first.clone(), second.clone()].concat();
            damaged[at] ^= 1;
            let rest = [Next::Skipped { at: 0, bytes: 32 }, whole(Tag::Moved, 1, 32, b"12345678")];
            assert_eq!(all(&damaged), rest, "{at}");
        }
    }

    #[test]
    fn a_log_holds_the_same() {
        let bytes = entry(Tag::Begin, 0, b"as it is");
        let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(", ");
        let (first, rest) = bytes.split_at(5);
        let log = format!(
            "INFO  boot\n      smr-record [{}]\nINFO  frame [1, 2]\n 3.2 smr-record [{}] at x\nsmr-record [0a, 0",
            hex(first),
            hex(rest)
        );
        let mut read = Vec::new();
        bytes_of(Cursor::new(log)).unwrap().read_to_end(&mut read).unwrap();
        assert_eq!(read, [bytes.as_slice(), &[10]].concat());
        let mut read = Vec::new();
        bytes_of(Cursor::new(bytes.clone())).unwrap().read_to_end(&mut read).unwrap();
        assert_eq!(read, bytes);
    }
}
