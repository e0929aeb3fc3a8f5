//! PGM, PPM and PAM pictures: P2, P3, P5, P6 and P7 with 8 or 16 bits a value.

use super::samples::{EXPECTED, Samples, check_size, damaged};
use anyhow::{Error, Result, ensure};

/// One picture as the bytes of its file.
pub(super) fn decode(bytes: &[u8]) -> Result<Samples> {
    let mut reader = Reader(bytes);
    let Header { is_text, width, height, channels, largest } = reader.header()?;
    // With another largest value the pixels would have to be scaled. Unscaled they would be almost black.
    ensure!(matches!(largest, 255 | 65535), "its largest value is {largest}: expected 255 or 65535");
    check_size(width, height)?;
    ensure!((1..=4).contains(&channels), "it has {channels} values a pixel: expected 1 to 4");
    let count = width as usize * height as usize * channels as usize;
    let cut = || damaged(format!("{EXPECTED}: it is cut short"));
    let samples = if is_text {
        // A file may state a larger size than it has, so memory is taken as numbers come.
        (0..count).map(|_| reader.sample(largest)).collect::<Option<Vec<u8>>>().ok_or_else(cut)?
    } else if largest == 255 {
        reader.0.get(..count).ok_or_else(cut)?.to_vec()
    } else {
        // The high byte is first.
        reader.0.get(..2 * count).ok_or_else(cut)?.iter().step_by(2).copied().collect()
    };
    Samples::new(width, height, channels as usize, samples)
}

struct Header {
    /// The values are decimal numbers.
    is_text: bool,
    width: u32,
    height: u32,
    /// Values a pixel.
    channels: u32,
    largest: u32,
}

/// The bytes that are not read yet.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn header(&mut self) -> Result<Header> {
        let magic = self.word().unwrap_or_default();
        let (is_text, channels) = match magic.as_str() {
            "P2" => (true, 1),
            "P3" => (true, 3),
            "P5" => (false, 1),
            "P6" => (false, 3),
            "P7" => return self.pam(),
            _ => return Err(damaged(format!("{EXPECTED}: it begins like none of them"))),
        };
        let mut number = || self.number().ok_or_else(|| no_header("width, height and largest value"));
        let (width, height, largest) = (number()?, number()?, number()?);
        Ok(Header { is_text, width, height, channels, largest })
    }

    /// The header of a P7: a name and its value on each line.
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
                // TUPLTYPE and comments are not needed: DEPTH says how many values a pixel has.
                _ => {
                    let end = self.0.iter().position(|&byte| byte == b'\n').unwrap_or(self.0.len());
                    self.0 = &self.0[end..];
                    continue;
                }
            };
            *field = self.number().ok_or_else(|| no_header(&name))?;
        }
    }

    /// One value of a text picture, its high byte.
    fn sample(&mut self, largest: u32) -> Option<u8> {
        let value = self.number().filter(|&value| value <= largest)?;
        u8::try_from(if largest == 255 { value } else { value >> 8 }).ok()
    }

    fn number(&mut self) -> Option<u32> {
        self.word()?.parse().ok()
    }

    /// The next word. Skips comments before it and one white space after it.
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

/// No word of a header is longer.
const LONGEST: usize = 20;

fn no_header(missing: &str) -> Error {
    damaged(format!("{EXPECTED}: its header has no {missing}"))
}
