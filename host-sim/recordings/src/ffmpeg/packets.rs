//! Packets of a file, as ffmpeg's `framecrc` prints them: no packet is decoded.

use super::process::{Ffmpeg, Input, Line};
use anyhow::Result;

/// Flag of a packet at which decoding can start.
pub(super) const KEY: u32 = 1;
/// Flag of a packet that the container marks as damaged.
pub(super) const CORRUPT: u32 = 2;
/// Flag of packets that are decoded but not shown, because an edit list cuts them.
pub(super) const DISCARDED: u32 = 4;

/// A line `stream, DTS, PTS, duration, size, sum[, F=flags]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Packet {
    pub stream: usize,
    /// Decoding time in units of the stream; `None` if unknown.
    pub sent: Option<i64>,
    /// Presentation time in units of the stream; `None` if unknown.
    pub shown: Option<i64>,
    /// Length in bytes.
    pub size: u64,
    pub flags: u32,
}

impl Packet {
    fn parse(row: &str) -> Option<Self> {
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        // ffmpeg prints `i64::MIN` for an unknown time.
        let time = |at: usize| fields.get(at)?.parse().ok().filter(|&time: &i64| time != i64::MIN);
        let flags = fields.iter().find_map(|field| u32::from_str_radix(field.strip_prefix("F=0x")?, 16).ok());
        let (stream, size) = (fields.first()?.parse().ok()?, fields.get(4)?.parse().ok()?);
        Some(Self { stream, sent: time(1), shown: time(2), size, flags: flags.unwrap_or(KEY) })
    }
}

/// A video stream, as the head of `framecrc` states it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    pub codec: String,
    /// Unit of times in seconds, as a fraction.
    pub base: Option<(u32, u32)>,
    pub size: (u32, u32),
    /// Length and checksum of what a decoder needs in front of the packets.
    pub extradata: String,
    /// Width and height of a pixel, as a ratio.
    pub aspect: (u32, u32),
}

impl Stream {
    const UNKNOWN: Self =
        Self { codec: String::new(), base: None, size: (0, 0), extradata: String::new(), aspect: (1, 1) };
}

/// A running ffmpeg that prints the packets of a file.
pub(super) struct Packets {
    pub ffmpeg: Ffmpeg,
    /// Streams stated so far; all of them once the first packet has been read.
    pub streams: Vec<Stream>,
}

impl Packets {
    /// Starts to read the packets of the streams that `map` selects. `options` are those of ffmpeg's input.
    pub fn of(input: &Input, options: &[&str], map: &[&str]) -> Result<Self> {
        let mut command = input.command(options);
        command.args(map).args(["-c", "copy", "-copyinkf"]);
        // The lines stand on standard error, in order with the complaints.
        command.args(["-copypriorss", "1", "-max_interleave_delta", "1", "-flush_packets", "1"]);
        command.args(["-f", "framecrc", "pipe:2"]);
        Ok(Self { ffmpeg: input.run(&mut command)?, streams: Vec::new() })
    }

    /// Waits for the next packet; `None` at the end.
    pub fn next(&mut self) -> Result<Option<Packet>> {
        while let Some(line) = self.ffmpeg.line()? {
            let Line::Row(row) = line else { continue };
            match row.strip_prefix('#') {
                Some(head) => drop(self.state(head)),
                None => {
                    if let Some(packet) = Packet::parse(&row) {
                        return Ok(Some(packet));
                    }
                }
            }
        }
        Ok(None)
    }

    /// Reads a line of the head: `tb 0: 1/12800`.
    fn state(&mut self, head: &str) -> Option<()> {
        let (name, rest) = head.split_once(' ')?;
        let (stream, value) = rest.split_once(':')?;
        let (stream, value): (usize, _) = (stream.trim().parse().ok()?, value.trim());
        if stream > self.streams.len() {
            return None;
        }
        if stream == self.streams.len() {
            self.streams.push(Stream::UNKNOWN);
        }
        let stated = &mut self.streams[stream];
        match name {
            "tb" => stated.base = fraction(value),
            "extradata" => value.clone_into(&mut stated.extradata),
            "sar" => stated.aspect = fraction(value)?,
            "codec_id" => value.clone_into(&mut stated.codec),
            "dimensions" => {
                let (width, height) = value.split_once('x')?;
                stated.size = (width.parse().ok()?, height.parse().ok()?);
            }
            _ => {}
        }
        Some(())
    }
}

/// Parses a fraction such as `1/15360`; `None` if a part is 0.
fn fraction(text: &str) -> Option<(u32, u32)> {
    let (numerator, denominator) = text.split_once('/')?;
    let number = |text: &str| text.parse().ok().filter(|&number: &u32| number > 0);
    number(numerator).zip(number(denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_packets_state_times_size_and_flags() {
        let packet = |sent, shown, size, flags| Some(Packet { stream: 0, sent, shown, size, flags });
        for (row, expected) in [
            ("0,      -1024,          0,      512,     3407, 0xd26b2b2c", packet(Some(-1024), Some(0), 3407, KEY)),
            ("0, 3, 4, 1, 5, 0xc0d8350b, F=0x2, S=1,        1", packet(Some(3), Some(4), 5, CORRUPT)),
            ("0, 3, -9223372036854775808, 1, 0, 0xc0d8350b, F=0x0", packet(Some(3), None, 0, 0)),
            ("0, 3", None),
            ("", None),
        ] {
            assert_eq!(Packet::parse(row), expected, "{row}");
        }
        assert_eq!(fraction("1001/30000"), Some((1001, 30000)));
        assert_eq!((fraction("0/1"), fraction("1/"), fraction("x")), (None, None, None));
    }
}
