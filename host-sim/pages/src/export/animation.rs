//! An animated GIF.

use super::draw::{INKS, Overlay};
use crate::report::Color;
use anyhow::{Error, Result};
use gif::{Encoder, EncodingError};
use smr_recordings::output::Output;
use std::borrow::Cow;

/// A file under way.
pub(super) struct Gif {
    /// The first frame, which tells the size, makes the encoder.
    output: Option<Output>,
    encoder: Option<Encoder<Output>>,
    /// The last frame, and the time from which on it is shown, in microseconds: the next one tells how long.
    waiting: Option<(gif::Frame<'static>, u64)>,
}

impl Gif {
    pub const fn new(output: Output) -> Self {
        Self { output: Some(output), encoder: None, waiting: None }
    }

    pub fn frame(&mut self, overlay: &Overlay, time: u64) -> Result<()> {
        if let Some(output) = self.output.take() {
            self.encoder = Some(gif_encoder(output, overlay).map_err(of_gif)?);
        }
        self.write_waiting(time)?;
        self.waiting = Some((gif_frame(overlay), time));
        Ok(())
    }

    fn write_waiting(&mut self, until: u64) -> Result<()> {
        let (Some((frame, since)), Some(encoder)) = (self.waiting.take(), &mut self.encoder) else { return Ok(()) };
        // In hundredths of a second, without drift; shorter than 2 is taken for 10 by browsers.
        let hundredths = |time: u64| (time + 5000) / 10_000;
        let delay = u16::try_from(hundredths(until) - hundredths(since)).unwrap_or(u16::MAX).max(2);
        encoder.write_frame(&gif::Frame { delay, ..frame }).map_err(of_gif)
    }

    /// Ends it; the last frame is shown for so many microseconds. The output has all bytes then, but not its name.
    pub fn finish(mut self, interval: u64) -> Result<Option<Output>> {
        let until = self.waiting.as_ref().map_or(0, |(_, since)| since + interval);
        self.write_waiting(until)?;
        // What is written last is the end of the file.
        match self.encoder {
            Some(encoder) => encoder.into_inner().map(Some).map_err(of_gif),
            None => Ok(self.output),
        }
    }
}

/// Gray levels of a GIF: so many that the inks fit in its 256 colors, too.
const LEVELS: usize = 256 - INKS.len();

fn gif_encoder(output: Output, overlay: &Overlay) -> Result<Encoder<Output>, EncodingError> {
    let (width, height) = gif_size(overlay);
    let levels = (0..LEVELS).map(|level| (level * 255 / (LEVELS - 1)).to_le_bytes()[0]);
    let palette: Vec<u8> = levels.map(|level| [level; 3]).chain(INKS).flatten().collect();
    let mut encoder = Encoder::new(output, width, height, &palette)?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(encoder)
}

/// A gray frame has the colors of the file, another one has its own.
fn gif_frame(overlay: &Overlay) -> gif::Frame<'static> {
    let (width, height) = gif_size(overlay);
    let indices: Option<Vec<u8>> = overlay.picture().pixels.iter().map(|&color| index(color)).collect();
    match indices {
        Some(indices) => gif::Frame { width, height, buffer: Cow::Owned(indices), ..gif::Frame::default() },
        None => gif::Frame::from_rgb_speed(width, height, overlay.rgb(), SPEED),
    }
}

/// How roughly the 256 colors of a frame are chosen, 1 to 30.
const SPEED: i32 = 10;

/// No frame has longer sides.
fn gif_size(overlay: &Overlay) -> (u16, u16) {
    let side = |length: u32| u16::try_from(length).unwrap_or(u16::MAX);
    (side(overlay.size().0), side(overlay.size().1))
}

/// Errors of the disk are passed on as they are.
fn of_gif(error: EncodingError) -> Error {
    match error {
        EncodingError::Io(error) => error.into(),
        other => other.into(),
    }
}

/// `None` of what is neither gray nor an ink.
fn index(color: Color) -> Option<u8> {
    let [red, green, blue] = color;
    let ink = INKS.iter().position(|ink| *ink == color).map(|ink| LEVELS + ink);
    let gray = (red == green && green == blue).then_some((usize::from(red) * (LEVELS - 1) + 127) / 255);
    Some(ink.or(gray)?.to_le_bytes()[0])
}
