//! A raw dump as a recording: 8-bit gray pixels, row after row, frame after frame, as cameras and scripts write them.

use crate::checked_frames::damaged;
use crate::formats::names::has_extension;
use crate::frame::Frame;
use crate::raster::{GrayFrame, MAX_PIXELS};
use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

pub(crate) fn is_raw(file: &Path) -> bool {
    has_extension(file, &["raw", "gray", "bin", "y8"])
}

/// Opens a raw dump. Returns its frames, and the count of whole ones (`None` for a pipe).
pub(crate) fn open(
    file: &Path,
    size: (u16, u16),
) -> Result<(impl Iterator<Item = Result<Frame>> + Send + use<>, Option<usize>)> {
    let (width, height) = size;
    ensure!(width > 0 && height > 0, "--size {width}x{height}: expected at least 1x1");
    let cannot_open = || format!("cannot open {}", file.display());
    let frame = u64::from(width) * u64::from(height);
    ensure!(frame <= MAX_PIXELS, "--size {width}x{height}: a frame has {frame} bytes: expected at most {MAX_PIXELS}");
    let dump = File::open(file).with_context(cannot_open)?;
    let data = dump.metadata().with_context(cannot_open)?;
    let length = data.is_file().then(|| usize::try_from(data.len() / frame).ok()).flatten();
    let (mut dump, name) = (BufReader::new(dump), file.display().to_string());
    let frames = (1..).map_while(move |number| {
        let read = read(&mut dump, size).with_context(|| format!("{name}, frame {number}")).transpose()?;
        Some(read.map(|gray| Frame::new(number, None, gray)))
    });
    Ok((frames, length))
}

fn read(dump: &mut impl Read, (width, height): (u16, u16)) -> Result<Option<GrayFrame>> {
    let expected = usize::from(width) * usize::from(height);
    // Memory grows with the bytes read, so that a mistyped `--size` does not allocate a whole frame of that size.
    let mut pixels = Vec::new();
    let found = dump.take(expected as u64).read_to_end(&mut pixels)?;
    if found != 0 && found != expected {
        let why = format!("or its frames are not {width}x{height}: expected {expected} bytes, found {found}");
        return Err(damaged(format!("it is cut short, {why}"), None));
    }
    Ok((found > 0).then_some(GrayFrame { width, height, pixels }))
}
