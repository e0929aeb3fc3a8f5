//! Recordings that tests make, and what is read of them.

use crate::ffmpeg::input;
use crate::formats::images;
use crate::missing;
use crate::open::{OpenOptions, open};
use crate::raster::GrayFrame;
use crate::sequence::Sequence;
use anyhow::Result;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

pub type Paper = smr_core::Paper<65536, 4096>;

/// Creates a folder from a text of names separated by spaces: `NAME=TEXT` with `|` for line ends, `LINK->TARGET`, or
/// the bare name of an image of 4x3 pixels, whose gray level is the number in its name.
pub fn folder(files: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files.split(' ').filter(|file| !file.is_empty()) {
        #[cfg(unix)]
        if let Some((link, target)) = file.split_once("->") {
            std::os::unix::fs::symlink(target, folder.path().join(link)).unwrap();
            continue;
        }
        let (name, text) = file.split_once('=').unwrap_or((file, ""));
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let level: String = name.chars().filter(char::is_ascii_digit).collect();
        let is_image = text.is_empty() && images::kind(&path).is_some();
        let image = || format!("P2 4 3 255{}", format!(" {level}").repeat(12));
        fs::write(path, if is_image { image() } else { text.replace('|', "\n") }).unwrap();
    }
    folder
}

pub fn open_plain(path: &Path) -> Result<Sequence> {
    open(path, &OpenOptions::default())
}

pub fn message<T>(result: Result<T>) -> String {
    format!("{:#}", result.err().expect("an error"))
}

/// Returns the frames before the first error, and the error with `@` in place of the folder.
pub fn read(path: &Path, options: &OpenOptions) -> (Vec<GrayFrame>, String) {
    let (mut good, mut error) = (Vec::new(), String::new());
    let opened = open(path, options).map(|sequence| sequence.frames);
    for frame in opened.unwrap_or_else(|error| Box::new(std::iter::once(Err(error)))) {
        assert!(error.is_empty(), "nothing follows an error");
        match frame {
            Ok(frame) => good.push(frame.gray),
            Err(found) => error = format!("{found:#}"),
        }
    }
    let at = if path.is_dir() { path } else { path.parent().unwrap() };
    (good, error.replace(&at.display().to_string(), "@"))
}

pub fn levels(frames: &[GrayFrame]) -> Vec<u8> {
    frames.iter().map(|frame| frame.pixels[0]).collect()
}

/// Asserts that a file of `bytes` has frames whose first pixels are `expected`, then `error`, where `...` is any text.
#[track_caller]
pub fn reads(name: &str, size: Option<(u16, u16)>, bytes: &[u8], expected: &[u8], error: &str) {
    let folder = folder("");
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    let (frames, found) = read(&file, &OpenOptions { size, ..OpenOptions::default() });
    assert_eq!(levels(&frames), expected, "{name}: {found}");
    fits(&found, error, name);
}

#[track_caller]
pub fn fits(found: &str, expected: &str, of: &str) {
    let parts: Vec<&str> = expected.split("...").collect();
    let is_whole = parts.len() > 1 || found == expected;
    let holds = found.starts_with(parts[0]) && found.ends_with(parts[parts.len() - 1]);
    let fits = is_whole && holds && parts.iter().all(|part| found.contains(part));
    assert!(fits, "{of}: {found}, expected {expected}");
}

/// Runs ffmpeg to write the file `out`; false if this ffmpeg cannot write such a file.
pub fn ffmpeg(arguments: &str, out: &Path) -> bool {
    let mut ffmpeg = std::process::Command::new("ffmpeg");
    missing::runs(ffmpeg.args("-nostdin -v error".split(' ')).args(arguments.split_whitespace()).arg(input(out)))
}

/// FNV-1a hash, by which tests notice a changed pixel.
pub fn fnv(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}
