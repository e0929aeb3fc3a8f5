//! `host-sim frame`: a page on which boxes are dragged, as one file.

use super::number::from;
use super::paths::{Bare, Places, Taken};
use super::recording_options::RecordingOptions;
use super::{BUDGET, Outcome, progress, say, shell};
use anyhow::{Context, Result};
use serde::Serialize;
use smr_pages::report::{self, Choosing, SIDE, Shots};
use smr_recordings::output::{Output, complain};
use smr_recordings::{BoundingBox, ColorFrame, Colors, Sequence, messages};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;

const TAKEN: Taken = Taken { endings: &["html"], bare: Bare::Refused };

#[derive(Debug, clap::Args)]
pub struct Frame {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// Which frame of the recording [default: the first, or the first of --frames]
    #[arg(value_name = "N", value_parser = from::<NonZeroUsize>(1))]
    number: Option<NonZeroUsize>,
    /// The page to write (.html)
    ///
    /// It has the frames of the recording to go through, and shows the command line with the box. It needs no other file and no network.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// The most megabytes for the page: beyond it it has fewer frames, evenly spaced
    #[arg(long, value_name = "MB", default_value_t = BUDGET, value_parser = from::<NonZeroUsize>(1))]
    budget: NonZeroUsize,
    /// Print a JSON object instead of lines
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

#[derive(Serialize)]
struct Written {
    file: PathBuf,
    bytes: usize,
    sequence: String,
    frame: usize,
    width: u16,
    height: u16,
    /// The frames in the page.
    pictures: usize,
    /// The box that is drawn; null where there is none.
    #[serde(rename = "box")]
    bbox: Option<BoundingBox>,
    /// Whether `track` takes it: all of it must lie in the frame. Null where there is no box.
    inside: Option<bool>,
}

impl Frame {
    pub fn places(&self) -> Places<'_> {
        Places::of([&self.sequence]).writes_as("--out", Some(&self.out), TAKEN)
    }

    pub fn run(self) -> Result<Outcome> {
        let written = self.page()?;
        let text = if self.json { serde_json::to_string_pretty(&written)? + "\n" } else { lines(&written) };
        say(|out| out.write_all(text.as_bytes()))?;
        Ok(Outcome::Holds)
    }

    /// The number in the recording of the first frame that is read.
    fn first(&self) -> usize {
        self.recording.frames().map_or(1, |part| part.first())
    }

    fn number(&self) -> usize {
        self.number.map_or(self.first(), NonZeroUsize::get)
    }

    /// The box to draw: the one that lies beside a recording is that of its first frame.
    fn target(&self, init: Option<BoundingBox>) -> Option<BoundingBox> {
        init.filter(|_| self.number() == self.first() || self.recording.gives_init())
    }

    fn page(&self) -> Result<Written> {
        let output = Output::create(&self.out)?;
        let Sequence { name, mut frames, init, length, first, colors, .. } =
            self.recording.in_own_size().open(&self.sequence)?;
        // The first frame tells the size.
        let gray = frames.next().with_context(|| format!("{name} holds no frame"))??;
        let size = (gray.width, gray.height);
        let bbox = self.target(init);
        let choosing = Choosing {
            name,
            first: self.first(),
            shown: self.number(),
            target: bbox,
            options: shlex::try_join(self.recording.words().iter().map(String::as_str))?,
            recording: shell::word(shell::file(&self.sequence).as_os_str()),
            file: shell::word(shell::file(&self.out).as_os_str()),
        };
        let bar = progress::bar(&choosing.name, length);
        let least = self.recording.least_box(size.0, size.1);
        let budget = self.budget.get().saturating_mul(1_000_000);
        let patience = self.recording.ffmpeg_patience();
        let count = self.recording.frames().and_then(|part| part.last()).map_or(usize::MAX, |last| last + 1 - first);
        let mut damage = None;
        let in_color: Box<dyn Iterator<Item = ColorFrame>> = match colors {
            // A second ffmpeg makes them small, which is quick.
            Colors::Video(..) => Box::new(colors.clone().within(first, SIDE, patience).take(count)),
            // They end where the gray ones do.
            ref colors => {
                let mut colors = colors.clone().open(first, patience);
                let sound = frames.map_while(|frame| frame.map_err(|error| damage = Some(error)).ok());
                Box::new(std::iter::once(gray).chain(sound).map(move |gray| colors.next(&gray).0))
            }
        };
        let shots = Shots {
            frames: in_color.inspect(|_| bar.inc()),
            size,
            shown: colors.within(self.number(), u16::MAX, patience).next(),
        };
        let picked = report::pick(shots, &choosing, least, budget);
        bar.clear();
        if let Some(damage) = damage {
            complain(&format!("note: the page ends before damage: {}", messages::of(&damage)));
        }
        let picked = picked?;
        output.end(picked.page.as_bytes())?;
        Ok(self.written(choosing.name, picked.page.len(), picked.size, picked.pictures, bbox))
    }

    fn written(
        &self,
        sequence: String,
        bytes: usize,
        (width, height): (u16, u16),
        pictures: usize,
        bbox: Option<BoundingBox>,
    ) -> Written {
        Written {
            file: self.out.clone(),
            bytes,
            sequence,
            frame: self.number(),
            width,
            height,
            pictures,
            bbox,
            inside: bbox.map(|bbox| is_inside(&bbox, width, height)),
        }
    }
}

/// Whether a tracker can be locked on the box.
fn is_inside(bbox: &BoundingBox, width: u16, height: u16) -> bool {
    let whole = smr_core::Rect::new(0, 0, width, height);
    bbox.to_rect().is_some_and(|rect| whole.contains(rect))
}

fn lines(written: &Written) -> String {
    let Written { file, sequence, frame, width, height, pictures, .. } = written;
    let first = format!("{}: frame {frame} of {sequence}, {width}x{height} pixels\n", file.display());
    format!("{first}{pictures} frames to go through: open it in a browser, and drag a box\n")
}
