//! `host-sim frame`: one frame with its coordinates, to choose the box to start from.

use super::number::from;
use super::places::Places;
use super::recording_options::RecordingOptions;
use super::{Outcome, progress, say};
use crate::sequence::{BoundingBox, GrayFrame, Sequence};
use crate::{output, report};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Frame {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// Which frame; the first is 1
    #[arg(value_name = "N", default_value = "1", value_parser = from::<NonZeroUsize>(1))]
    number: NonZeroUsize,
    /// The picture to write, a PNG
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Print a JSON object instead of lines
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

/// What was written.
#[derive(Serialize)]
struct Written {
    file: PathBuf,
    bytes: usize,
    sequence: String,
    frame: usize,
    width: u16,
    height: u16,
    /// The box that was drawn; null where there is none.
    #[serde(rename = "box")]
    bbox: Option<BoundingBox>,
    /// Whether `track` takes it: all of it must lie in the frame. Null where there is no box.
    inside: Option<bool>,
}

impl Frame {
    /// What is read and written.
    pub fn places(&self) -> Places<'_> {
        Places::of([&self.sequence]).writes("--out", Some(&self.out))
    }

    pub fn run(self) -> Result<Outcome> {
        let Sequence { name, frames, init, .. } = self.recording.open(&self.sequence)?;
        let number = self.number.get();
        // A late frame of a long video takes a while.
        let bar = progress::bar(&name, Some(number));
        let frame = nth(frames.inspect(|_| bar.inc(1)), number).with_context(|| name.clone())?;
        bar.finish_and_clear();
        // The box that lies beside a recording is that of its first frame.
        let bbox = init.filter(|_| number == 1 || self.recording.gives_init());
        let bytes = report::coordinates(&frame, number, bbox.as_ref())?;
        output::write(&self.out, &bytes)?;
        let written = Written {
            file: self.out,
            bytes: bytes.len(),
            sequence: name,
            frame: number,
            width: frame.width,
            height: frame.height,
            bbox,
            inside: bbox.map(|bbox| is_inside(&bbox, &frame)),
        };
        let text = if self.json { serde_json::to_string_pretty(&written)? + "\n" } else { lines(&written) };
        say(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }
}

fn nth(frames: impl Iterator<Item = Result<GrayFrame>>, number: usize) -> Result<GrayFrame> {
    let mut length = 0;
    for frame in frames {
        let frame = frame?;
        length += 1;
        if length == number {
            return Ok(frame);
        }
    }
    bail!("there is no frame {number}: expected 1 to {length}")
}

/// Whether a tracker can be locked on the box.
fn is_inside(bbox: &BoundingBox, frame: &GrayFrame) -> bool {
    let whole = smr_core::Rect::new(0, 0, frame.width, frame.height);
    bbox.to_rect().is_some_and(|rect| whole.contains(rect))
}

fn lines(written: &Written) -> String {
    let Written { file, sequence, frame, width, height, bbox, inside, .. } = written;
    let first = format!("{}: frame {frame} of {sequence}, {width}x{height} pixels\n", file.display());
    let Some(bbox) = bbox else {
        return first + "no box: give --init X,Y,W,H to see one\n";
    };
    let refused =
        if *inside == Some(true) { "" } else { "; not all of it lies in the frame, so `track` would refuse it" };
    format!("{first}box: {bbox} (x,y,width,height){refused}\n")
}
