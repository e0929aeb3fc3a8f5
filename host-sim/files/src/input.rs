//! Reads files whole, up to a size limit. A pipe or device without data for five seconds is an error.

use crate::{messages, wait};
use anyhow::{Context, Result, anyhow, ensure};
use std::fs::{self, File};
use std::io::{self, BufRead, ErrorKind, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

/// A kind of file: its description in errors, and its size limit.
pub struct Kind {
    pub expected: &'static str,
    /// Size limit in MiB.
    pub most: u32,
}

/// Longest time without data from a pipe or a device.
const PATIENCE: Duration = Duration::from_secs(5);

/// Reads a text file. Errors: as [`bytes()`] and [`decoded`].
pub fn text(file: &Path, kind: &Kind) -> Result<String> {
    decoded(&bytes(file, kind)?, kind)
}

/// Decodes UTF-8, or UTF-16 with a byte order mark. Returns the text without the mark; all lines end with LF.
pub fn decoded(bytes: &[u8], kind: &Kind) -> Result<String> {
    let expected = || format!("expected {} in UTF-8", kind.expected);
    let units = |of: &[u8], unit: fn([u8; 2]) -> u16| {
        let (pairs, rest) = of.as_chunks();
        let units: Vec<u16> = pairs.iter().copied().map(unit).collect();
        String::from_utf16(&units)
            .ok()
            .filter(|_| rest.is_empty())
            .with_context(|| format!("it begins as UTF-16, but is damaged: {}", expected()))
    };
    let text = match bytes {
        [0xFF, 0xFE, rest @ ..] => units(rest, u16::from_le_bytes)?,
        [0xFE, 0xFF, rest @ ..] => units(rest, u16::from_be_bytes)?,
        _ => str::from_utf8(bytes).map(str::to_owned).map_err(|error| {
            let line = bytes[..error.valid_up_to()].split(|&byte| byte == b'\n').count();
            anyhow!("line {line}: it is not text in UTF-8: {}", expected())
        })?,
    };
    ensure!(!text.contains('\0'), "it has NUL characters, as UTF-16 without its mark has: {}", expected());
    Ok(text.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n"))
}

/// Reads a file. Errors: The file is missing, unreadable, a folder, too long, or a silent pipe or device. The error
/// message does not name the file.
pub fn bytes(file: &Path, kind: &Kind) -> Result<Vec<u8>> {
    let Kind { expected, most } = kind;
    let unreadable = |error: io::Error| match error.kind() {
        ErrorKind::TimedOut => {
            let seconds = PATIENCE.as_secs();
            anyhow!("no data came for {seconds} s: expected {expected} of at most {most} MiB")
        }
        _ => anyhow!("{}: expected {expected}", messages::of_io(&error)),
    };
    let data = fs::metadata(file).map_err(unreadable)?;
    ensure!(!data.is_dir(), "it is a folder: expected {expected}");
    let limit = u64::from(*most) << 20;
    let fits = |length: u64| {
        ensure!(length <= limit, "it has more than {most} MiB: expected {expected} of at most that");
        Ok(())
    };
    let (mut bytes, name) = (Vec::new(), file.to_owned());
    let stream: Box<dyn Read> = if data.is_file() {
        fits(data.len())?;
        Box::new(File::open(name).map_err(unreadable)?)
    } else {
        Box::new(Patient::new(|| File::open(name), PATIENCE, |_| ErrorKind::TimedOut.into()))
    };
    // The file may have grown since its length was read.
    stream.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    fits(bytes.len() as u64)?;
    Ok(bytes)
}

/// A stream whose reads fail after `patience` without data. A thread opens and reads it, because either may block.
pub struct Patient {
    /// Chunks of the stream; an empty chunk marks the end.
    chunks: Receiver<io::Result<Vec<u8>>>,
    chunk: Vec<u8>,
    read: usize,
    patience: Duration,
    silent: fn(Duration) -> io::Error,
}

impl Patient {
    pub fn new<R: Read>(
        open: impl FnOnce() -> io::Result<R> + Send + 'static,
        patience: Duration,
        silent: fn(Duration) -> io::Error,
    ) -> Self {
        let (sender, chunks) = sync_channel(4);
        thread::spawn(move || {
            let mut stream = match open() {
                Ok(stream) => stream,
                Err(error) => return drop(sender.send(Err(error))),
            };
            loop {
                let mut chunk = vec![0; 1 << 16];
                let read = stream.read(&mut chunk).map(|length| {
                    chunk.truncate(length);
                    chunk
                });
                let over = read.as_ref().map_or(true, Vec::is_empty);
                if sender.send(read).is_err() || over {
                    return;
                }
            }
        });
        Self { chunks, chunk: Vec::new(), read: 0, patience, silent }
    }
}

impl BufRead for Patient {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.read == self.chunk.len() {
            (self.chunk, self.read) = match wait::receive(&self.chunks, self.patience) {
                Ok(chunk) => (chunk?, 0),
                Err(RecvTimeoutError::Disconnected) => (Vec::new(), 0),
                Err(RecvTimeoutError::Timeout) => return Err((self.silent)(self.patience)),
            };
        }
        Ok(&self.chunk[self.read..])
    }

    fn consume(&mut self, amount: usize) {
        self.read += amount;
    }
}

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.fill_buf()?.read(buffer)?;
        self.consume(length);
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Kind = Kind { expected: "a small file", most: 1 };

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, vec![7; 1 << 20]).unwrap();
        let fails = |file: &Path, why: &str| assert_eq!(text(file, &SMALL).unwrap_err().to_string(), why);
        assert_eq!(bytes(&file, &SMALL).unwrap().len(), 1 << 20);
        fs::write(&file, vec![7; (1 << 20) + 1]).unwrap();
        fails(&file, "it has more than 1 MiB: expected a small file of at most that");
        fs::write(&file, b"a\nb\xFF").unwrap();
        fails(&file, "line 2: it is not text in UTF-8: expected a small file in UTF-8");
        fails(folder.path(), "it is a folder: expected a small file");
        fails(&folder.path().join("missing"), "there is no such file: expected a small file");
    }
    #[test]
    fn text_of_every_system_is_decoded() {
        let read = |bytes: &[u8]| decoded(bytes, &SMALL).map_err(|error| error.to_string());
        let utf16 = |text: &str, unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let (marked, plain) = ("\u{feff}ü\r\n😀\rb\n", Ok("ü\n😀\nb\n".to_owned()));
        assert_eq!(read(marked.as_bytes()), plain);
        assert_eq!(
            [read(&utf16(marked, u16::to_le_bytes)), read(&utf16(marked, u16::to_be_bytes))],
            [(); 2].map(|()| plain.clone())
        );
        let damaged = "it begins as UTF-16, but is damaged: expected a small file in UTF-8";
        assert_eq!([read(b"\xFF\xFEa"), read(b"\xFF\xFE\0\xD8")], [(); 2].map(|()| Err(damaged.to_owned())));
        let nul = "it has NUL characters, as UTF-16 without its mark has: expected a small file in UTF-8";
        assert_eq!(read(&utf16("<a/>", u16::to_le_bytes)), Err(nul.to_owned()));
    }
}
