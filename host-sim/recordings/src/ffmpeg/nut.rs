//! Reads NUT, the container in which ffmpeg hands over its images: each packet with its stream and its length.
//!
//! Only what ffmpeg writes on a pipe is read: version 3, no checksums verified, no time stamps kept.

use std::io::{BufRead, Error, ErrorKind, Read, Result, copy, sink};

const ID: &[u8; 25] = b"nut/multimedia container\0";
const MAIN: u64 = 0x4E4D_7A56_1F5F_04AD;

/// Flags of a frame code.
const KNOWS_TIME: u64 = 1 << 3;
const KNOWS_STREAM: u64 = 1 << 4;
const KNOWS_SIZE: u64 = 1 << 5;
const HAS_CHECKSUM: u64 = 1 << 6;
const KNOWS_RESERVED: u64 = 1 << 7;
const HAS_SIDE_DATA: u64 = 1 << 8;
const KNOWS_HEADER: u64 = 1 << 10;
const KNOWS_MATCH_TIME: u64 = 1 << 11;
const CHANGES_FLAGS: u64 = 1 << 12;
const IS_INVALID: u64 = 1 << 13;

/// Largest header in bytes.
const MAX_HEADER: u64 = 1 << 20;

/// Headers longer than this, in bytes, have a checksum behind their length. Larger packets have no elided header.
const LONG: u64 = 4096;

/// Fields of a packet that its first byte, the frame code, implies.
#[derive(Clone, Copy, Default)]
struct Code {
    flags: u64,
    stream: u64,
    size_factor: u64,
    size: u64,
    reserved: u64,
    header: u64,
}

pub(super) struct Packet {
    pub stream: u64,
    /// Length in bytes.
    pub length: u64,
    /// `None` for a packet longer than the limit of [`Nut::packet`], which is skipped.
    pub bytes: Option<Vec<u8>>,
}

pub(super) struct Nut<R> {
    input: R,
    codes: Vec<Code>,
    /// First bytes of packets that are not repeated in the packets; number 0 is empty.
    elided: Vec<Vec<u8>>,
}

impl<R: BufRead> Nut<R> {
    pub fn new(input: R) -> Self {
        Self { input, codes: Vec::new(), elided: vec![Vec::new()] }
    }

    /// Reads the next packet; `None` at the end of the stream. A packet of more than `limit` bytes is skipped.
    /// Errors: The stream ends inside a packet, or is no NUT.
    pub fn packet(&mut self, limit: u64) -> Result<Option<Packet>> {
        loop {
            if self.input.fill_buf()?.is_empty() {
                return Ok(None);
            }
            match byte(&mut self.input)? {
                b'n' => self.file_id()?,
                b'N' => self.header()?,
                code => return self.body(code, limit).map(Some),
            }
        }
    }

    fn file_id(&mut self) -> Result<()> {
        let mut rest = [0; ID.len() - 1];
        self.input.read_exact(&mut rest)?;
        if rest == ID[1..] { Ok(()) } else { Err(invalid("no file id")) }
    }

    fn header(&mut self) -> Result<()> {
        let mut rest = [0; 7];
        self.input.read_exact(&mut rest)?;
        let start_code = rest.iter().fold(u64::from(b'N'), |code, byte| code << 8 | u64::from(*byte));
        let size = number(&mut self.input)?;
        if size > MAX_HEADER {
            return Err(invalid("a header is too long"));
        }
        if size > LONG {
            skip(&mut self.input, 4)?;
        }
        let mut header = (&mut self.input).take(size);
        if start_code == MAIN {
            (self.codes, self.elided) = main_header(&mut header)?;
        }
        let rest = header.limit();
        skip(&mut self.input, rest)
    }

    fn body(&mut self, code: u8, limit: u64) -> Result<Packet> {
        let code = *self.codes.get(usize::from(code)).ok_or_else(|| invalid("no main header"))?;
        let Code { mut flags, mut stream, size_factor, mut size, mut reserved, mut header } = code;
        let input = &mut self.input;
        if flags & CHANGES_FLAGS != 0 {
            flags ^= number(input)?;
        }
        if flags & (IS_INVALID | HAS_SIDE_DATA) != 0 {
            return Err(invalid("an unknown kind of packet"));
        }
        if flags & KNOWS_STREAM != 0 {
            stream = number(input)?;
        }
        if flags & KNOWS_TIME != 0 {
            number(input)?;
        }
        if flags & KNOWS_SIZE != 0 {
            let multiple = number(input)?.checked_mul(size_factor);
            size = multiple.and_then(|more| size.checked_add(more)).ok_or_else(|| invalid("a length overflows"))?;
        }
        if flags & KNOWS_MATCH_TIME != 0 {
            number(input)?;
        }
        if flags & KNOWS_HEADER != 0 {
            header = number(input)?;
        }
        if flags & KNOWS_RESERVED != 0 {
            reserved = number(input)?;
        }
        for _ in 0..reserved {
            number(input)?;
        }
        if flags & HAS_CHECKSUM != 0 {
            skip(input, 4)?;
        }
        let elided = if size > LONG { 0 } else { usize::try_from(header).unwrap_or(usize::MAX) };
        let elided = self.elided.get(elided).ok_or_else(|| invalid("an unknown elided header"))?;
        let rest = size.checked_sub(elided.len() as u64).ok_or_else(|| invalid("a packet is too short"))?;
        if size > limit {
            skip(input, rest)?;
            return Ok(Packet { stream, length: size, bytes: None });
        }
        let mut bytes = elided.clone();
        if input.take(rest).read_to_end(&mut bytes)? as u64 != rest {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(Packet { stream, length: size, bytes: Some(bytes) })
    }
}

/// Reads the 256 frame codes and the elided headers.
fn main_header(header: &mut impl Read) -> Result<(Vec<Code>, Vec<Vec<u8>>)> {
    if number(header)? != 3 {
        return Err(invalid("an unknown version"));
    }
    let _streams = number(header)?;
    let _max_distance = number(header)?;
    for _ in 0..number(header)? {
        let (_numerator, _denominator) = (number(header)?, number(header)?);
    }
    let mut codes = Vec::new();
    let mut code = Code { size_factor: 1, ..Code::default() };
    while codes.len() < 256 {
        (code.flags, code.size, code.reserved) = (number(header)?, 0, 0);
        let fields = number(header)?;
        let mut field = |at: u64, default: u64| if fields > at { number(header) } else { Ok(default) };
        let _time_delta = field(0, 0)?;
        code.size_factor = field(1, code.size_factor)?;
        code.stream = field(2, code.stream)?;
        code.size = field(3, 0)?;
        code.reserved = field(4, 0)?;
        let count = field(5, code.size_factor.saturating_sub(code.size))?;
        let _match_time = field(6, 0)?;
        code.header = field(7, code.header)?;
        for at in 8..fields {
            field(at, 0)?;
        }
        let mut added = 0;
        while added < count && codes.len() < 256 {
            // The code 'N' begins a header, so the table skips it.
            if codes.len() == usize::from(b'N') {
                codes.push(Code { flags: IS_INVALID, ..code });
                continue;
            }
            codes.push(Code { size: code.size.saturating_add(added), ..code });
            added += 1;
        }
    }
    let mut elided = vec![Vec::new()];
    for _ in 0..number(header)? {
        let mut bytes = Vec::new();
        let length = number(header)?;
        header.take(length).read_to_end(&mut bytes)?;
        elided.push(bytes);
    }
    Ok((codes, elided))
}

fn invalid(reason: &str) -> Error {
    Error::new(ErrorKind::InvalidData, format!("ffmpeg's stream of pictures is not understood: {reason}"))
}

fn byte(input: &mut impl Read) -> Result<u8> {
    let mut byte = [0];
    input.read_exact(&mut byte)?;
    Ok(byte[0])
}

/// Reads a number of any length: seven bits a byte, the most significant first; bit 7 is set in all but the last byte.
fn number(input: &mut impl Read) -> Result<u64> {
    let mut value = 0_u64;
    loop {
        let next = byte(input)?;
        if value >> 57 != 0 {
            return Err(invalid("a number is too large"));
        }
        value = value << 7 | u64::from(next & 127);
        if next < 128 {
            return Ok(value);
        }
    }
}

fn skip(input: &mut impl Read, length: u64) -> Result<()> {
    let skipped = copy(&mut input.take(length), &mut sink())?;
    if skipped == length { Ok(()) } else { Err(ErrorKind::UnexpectedEof.into()) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// File id and a main header whose frame codes all state stream and size.
    fn head() -> Vec<u8> {
        let mut codes = vec![3, 2, 0, 1, 1, 25];
        // Flags 0x30 (stream and size), then six fields; the last is the count of codes, 255, because one is 'N'.
        codes.extend([0x30, 6, 0, 1, 0, 0, 0, 0x81, 0x7F, 0, 0, 0, 0, 0]);
        let length = u8::try_from(codes.len()).unwrap();
        [&ID[..], &MAIN.to_be_bytes(), &[length], &codes].concat()
    }

    /// Two packets of stream 1: `ab` and 5000 bytes.
    fn example() -> Vec<u8> {
        [&head()[..], &[0, 1, 2, b'a', b'b'], &[0, 1, 0xA7, 8], &[7; 5000]].concat()
    }

    /// Gray images of 2x1 pixels, each with its row.
    pub fn images(count: usize) -> Vec<u8> {
        [head(), [0, 0, 2, b'a', b'b', 0, 1, 2, b'a', b'b'].repeat(count)].concat()
    }

    #[test]
    fn packets_have_their_stream_and_bytes() {
        let bytes = example();
        let mut nut = Nut::new(&bytes[..]);
        let first = nut.packet(100).unwrap().unwrap();
        assert_eq!((first.stream, first.length, first.bytes.as_deref()), (1, 2, Some(&b"ab"[..])));
        let second = nut.packet(100).unwrap().unwrap();
        assert_eq!((second.stream, second.length, second.bytes), (1, 5000, None));
        assert!(nut.packet(100).unwrap().is_none());
        for length in 0..bytes.len() {
            let mut nut = Nut::new(&bytes[..length]);
            while let Ok(Some(packet)) = nut.packet(10_000) {
                assert!(packet.length == 2, "a cut packet is an error");
            }
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(mut bytes in proptest::collection::vec(any::<u8>(), 0..400), whole in any::<bool>()) {
            if whole {
                let mut start = example();
                start.extend(&bytes);
                bytes = start;
            }
            let mut nut = Nut::new(&bytes[..]);
            while let Ok(Some(packet)) = nut.packet(1 << 16) {
                prop_assert!(packet.bytes.is_none_or(|read| read.len() as u64 == packet.length));
            }
        }
    }
}
