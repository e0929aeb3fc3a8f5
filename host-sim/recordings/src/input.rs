//! Files that are read whole: none is longer than its kind can be, and one that never ends is not waited for.

use crate::messages;
use anyhow::{Result, anyhow, ensure};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

pub struct Kind {
    /// The words behind "expected".
    pub expected: &'static str,
    /// In MiB.
    pub most: u32,
}

/// A million frames of boxes, and of most polygons.
pub const BOXES: Kind = Kind { expected: "a text file with a box a line", most: 64 };
/// Any of 16384x16384 pixels, except in colour without compression.
pub const PICTURE: Kind = Kind { expected: "a PNG, JPEG, PGM, PPM or PAM picture", most: 512 };
pub const FORMER: Kind = Kind { expected: "what `host-sim eval --robustness --json` writes", most: 64 };

/// The time that a pipe or a device may be silent.
const PATIENCE: Duration = Duration::from_secs(5);

/// The file as text.
pub fn text(file: &Path, kind: &Kind) -> Result<String> {
    let text = String::from_utf8(bytes(file, kind)?);
    text.map_err(|_| anyhow!("it is not text in UTF-8: expected {}", kind.expected))
}

/// The file's bytes.
/// Errors: What is wrong with the file, without its name: it is not there, it cannot be read, it is too long, or it is
/// a pipe that says nothing.
pub fn bytes(file: &Path, kind: &Kind) -> Result<Vec<u8>> {
    let unreadable = |error: &io::Error| anyhow!("{}: expected {}", messages::of_io(error), kind.expected);
    let data = fs::metadata(file).map_err(|error| unreadable(&error))?;
    ensure!(!data.is_dir(), "it is a folder: expected {}", kind.expected);
    let most = u64::from(kind.most) << 20;
    let fits = |length: u64| {
        ensure!(length <= most, "it has more than {} MiB: expected {} of at most that", kind.most, kind.expected);
        Ok(())
    };
    if data.is_file() {
        fits(data.len())?;
        let mut bytes = Vec::new();
        // It may grow meanwhile.
        let read = File::open(file).and_then(|file| file.take(most + 1).read_to_end(&mut bytes));
        read.map_err(|error| unreadable(&error))?;
        fits(bytes.len() as u64)?;
        return Ok(bytes);
    }
    let name = file.to_owned();
    let (chunks, mut bytes) = (chunks(|| File::open(name)), Vec::new());
    loop {
        match chunks.recv_timeout(PATIENCE) {
            Ok(chunk) => bytes.extend(chunk.map_err(|error| unreadable(&error))?),
            Err(RecvTimeoutError::Disconnected) => return Ok(bytes),
            Err(RecvTimeoutError::Timeout) => {
                let (seconds, Kind { expected, most }) = (PATIENCE.as_secs(), kind);
                return Err(anyhow!(
                    "nothing comes out of it for {seconds} s: expected {expected} of at most {most} MiB"
                ));
            }
        }
        fits(bytes.len() as u64)?;
    }
}

/// Chunks from a pipe or a device; an empty one is the end. Opening a pipe waits for its writer: a thread does it, and nobody waits for
/// that.
pub fn chunks<R: Read>(open: impl FnOnce() -> io::Result<R> + Send + 'static) -> Receiver<io::Result<Vec<u8>>> {
    let (sender, receiver) = sync_channel(4);
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
    receiver
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
        assert_eq!(bytes(&file, &SMALL).unwrap().len(), 1 << 20);
        fs::write(&file, vec![7; (1 << 20) + 1]).unwrap();
        let error = bytes(&file, &SMALL).unwrap_err().to_string();
        assert_eq!(error, "it has more than 1 MiB: expected a small file of at most that");
        fs::write(&file, b"\xFF").unwrap();
        assert_eq!(text(&file, &SMALL).unwrap_err().to_string(), "it is not text in UTF-8: expected a small file");
        let error = bytes(folder.path(), &SMALL).unwrap_err().to_string();
        assert_eq!(error, "it is a folder: expected a small file");
        let error = bytes(&folder.path().join("missing"), &SMALL).unwrap_err().to_string();
        assert_eq!(error, "there is no such file: expected a small file");
    }
}
