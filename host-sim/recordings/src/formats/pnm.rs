//! Decodes PGM, PPM and PAM images: P2, P3, P5, P6 and P7 with 8 or 16 bits per value.

use crate::checked_frames::damaged;
use crate::formats::to_gray::{EXPECTED, Samples, check_size, several};
use anyhow::{Error, Result, ensure};

pub(crate) fn decode(bytes: &[u8]) -> Result<Samples> {
    let mut reader = Reader(bytes);
    let samples = reader.image()?;
    ensure!(reader.next(bytes).is_none(), several());
    Ok(samples)
}

/// Returns the byte offset of the second image in a file; `None` without one.
pub(crate) fn next(bytes: &[u8]) -> Option<usize> {
    let mut reader = Reader(bytes);
    reader.image().ok()?;
    reader.next(bytes)
}

/// True if the bytes begin as a PGM, PPM or PAM image, or as a PBM bitmap, which is not supported.
pub(crate) fn is_pnm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7', space, ..] if space.is_ascii_whitespace() || *space == b'#')
}

struct Header {
    /// True if values are decimal text, false if they are bytes.
    is_text: bool,
    width: u32,
    height: u32,
    channels: u32,
    largest: u32,
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn next(&self, bytes: &[u8]) -> Option<usize> {
        let rest = self.0.trim_ascii_start();
        is_pnm(rest).then_some(bytes.len() - rest.len())
    }

    fn image(&mut self) -> Result<Samples> {
        let Header { is_text, width, height, channels, largest } = self.header()?;
        // Values with another maximum would have to be scaled: unscaled, those of 10 bits would be almost black.
        ensure!(matches!(largest, 255 | 65535), "its largest value is {largest}: expected 255 or 65535");
        check_size(width, height)?;
        ensure!((1..=4).contains(&channels), "it has {channels} values a pixel: expected 1 to 4");
        let count = width as usize * height as usize * channels as usize;
        let is_wide = largest == 65535;
        let cut = || damaged(format!("{EXPECTED}: it is cut short"), None);
        let samples = if is_text {
            let mut samples = Vec::new();
            // The header may state a larger size than the file has, so memory grows with the values read.
            for _ in 0..count {
                let value = self.number().and_then(|value| u16::try_from(value).ok());
                let [high, low] = value.filter(|&value| u32::from(value) <= largest).ok_or_else(cut)?.to_be_bytes();
                samples.extend(is_wide.then_some(high).into_iter().chain([low]));
            }
            samples
        } else {
            let length = if is_wide { 2 * count } else { count };
            let (samples, rest) = self.0.split_at_checked(length).ok_or_else(cut)?;
            self.0 = rest;
            samples.to_vec()
        };
        Ok(Samples { is_wide, ..Samples::new(width, height, channels as usize, samples)? })
    }

    fn header(&mut self) -> Result<Header> {
        let magic = self.word().unwrap_or_default();
        let (is_text, channels) = match magic.as_str() {
            "P2" => (true, 1),
            "P3" => (true, 3),
            "P5" => (false, 1),
            "P6" => (false, 3),
            "P7" => return self.pam(),
            _ => return Err(damaged(format!("{EXPECTED}: it begins like none of these formats"), None)),
        };
        let mut number = || self.number().ok_or_else(|| no_header("width, height and largest value"));
        let (width, height, largest) = (number()?, number()?, number()?);
        Ok(Header { is_text, width, height, channels, largest })
    }

    /// Reads the header of a P7 image: a field name and its value on each line.
    fn pam(&mut self) -> Result<Header> {
        let mut header = Header { is_text: false, width: 0, height: 0, channels: 0, largest: 0 };
        loop {
            let name = self.word().ok_or_else(|| no_header("ENDHDR"))?;
            let field = match name.as_str() {
                "ENDHDR" => return Ok(header),
                "WIDTH" => &mut header.width,
                "HEIGHT" => &mut header.height,
                "DEPTH" => &mut header.channels,
                "MAXVAL" => &mut header.largest,
                // Skips other fields, such as TUPLTYPE: DEPTH already states how many values a pixel has.
                _ => {
                    let end = self.0.iter().position(|&byte| byte == b'\n').unwrap_or(self.0.len());
                    self.0 = &self.0[end..];
                    continue;
                }
            };
            *field = self.number().ok_or_else(|| no_header(&name))?;
        }
    }

    fn number(&mut self) -> Option<u32> {
        self.word()?.parse().ok()
    }

    /// Returns the next word; skips comments before it and one whitespace byte after it.
    fn word(&mut self) -> Option<String> {
        loop {
            self.0 = self.0.trim_ascii_start();
            if self.0.first() != Some(&b'#') {
                break;
            }
            let line = self.0.iter().position(|&byte| byte == b'\n')?;
            self.0 = &self.0[line..];
        }
        let length = self.0.iter().position(u8::is_ascii_whitespace).unwrap_or(self.0.len());
        let (word, rest) = self.0.split_at_checked(length.clamp(1, LONGEST))?;
        self.0 = rest.get(1..).unwrap_or_default();
        String::from_utf8(word.to_vec()).ok()
    }
}

const LONGEST: usize = 20;

fn no_header(missing: &str) -> Error {
    damaged(format!("{EXPECTED}: its header has no {missing}"), None)
}
