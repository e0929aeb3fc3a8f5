//! Formats of recordings: their extensions, and the files beside the frames that the toolkits of VOT, OTB and GOT-10k read.
//!
//! | toolkit | frames | boxes | besides |
//! |---|---|---|---|
//! | VOT | `color/00000001.png` | `groundtruth.txt`; 0 where the target is not visible | `sequence`: what the recording is like |
//! | OTB | `img/0001.jpg` | `groundtruth_rect.txt`, the first pixel being 1; no area where it is not visible | |
//! | GOT-10k | `00000001.jpg` | `groundtruth.txt`; no area where it is not visible | `meta_info.ini`, and a number for each frame in `absence.label`, `cover.label` and `cut_by_image.label` |
//!
//! Without ground truth the file with boxes has one line, the box to start from, as in the test sets of GOT-10k.

use anyhow::{Context, Result};
use serde::Serialize;
use smr_recordings::boxes::Form;
use smr_recordings::messages::choice_name;
use smr_recordings::{BoundingBox, output};
use std::fs;
use std::path::{Path, PathBuf};

/// Frames a second: a recording does not say how many it has.
const RATE: u32 = 25;

/// A file, a folder of pictures, or the layout of a toolkit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// A folder of PNG pictures, 00001.png ...
    Png,
    /// A folder of PGM pictures, 00001.pgm ...
    Pgm,
    /// One Y4M file, gray, 25 frames a second
    Y4m,
    /// One raw dump: 8-bit gray, row after row, frame after frame
    Raw,
    /// One C header with an array of frames
    H,
    /// A sequence for the VOT toolkit: color/00000001.png ..., groundtruth.txt, sequence; the frames as they are
    Vot,
    /// A sequence for OTB's tools: img/0001.jpg ..., groundtruth_rect.txt; they read JPEG, so pixels differ a little
    Otb,
    /// A sequence for the GOT-10k toolkit: 00000001.jpg ..., groundtruth.txt, labels, meta_info.ini; JPEG, too
    Got10k,
}

impl Format {
    /// True for the layouts of toolkits, which are of no use without boxes.
    pub const fn needs_boxes(self) -> bool {
        matches!(self, Self::Vot | Self::Otb | Self::Got10k)
    }

    /// The extensions of files that hold all frames.
    pub const OF_FILES: [&str; 6] = ["y4m", "raw", "gray", "bin", "y8", "h"];

    pub fn of_file(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "y4m" => Some(Self::Y4m),
            "raw" | "gray" | "bin" | "y8" => Some(Self::Raw),
            "h" => Some(Self::H),
            _ => None,
        }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Written {
    pub frames: usize,
    /// Width of a frame in pixels; 0 before the first frame.
    pub width: u16,
    pub height: u16,
    /// Bytes of all frames, with the headers of their format.
    pub bytes: u64,
    /// The other files: boxes, and the texts that a toolkit reads.
    pub boxes: Vec<&'static str>,
    /// List of sequences that the recording was added to.
    pub list: Option<PathBuf>,
    /// Configuration of a workspace of the VOT toolkit, if one was written.
    pub config: Option<PathBuf>,
}

pub(super) fn picture(format: Format, number: usize) -> String {
    match format {
        Format::Vot => format!("color/{number:08}.png"),
        Format::Otb => format!("img/{number:04}.jpg"),
        Format::Got10k => format!("{number:08}.jpg"),
        _ => format!("{number:05}.{}", choice_name(&format)),
    }
}

/// Returns the files of a toolkit beside the pictures; the first holds all boxes. `boxes` has one entry for each frame;
/// without ground truth it is the box to start from alone.
pub(super) fn files(
    format: Format,
    name: &str,
    &Written { frames, width, height, .. }: &Written,
    boxes: &[Option<BoundingBox>],
) -> Vec<(&'static str, String)> {
    let lines = |line: &dyn Fn(Option<&BoundingBox>) -> String| {
        boxes.iter().map(|entry| line(entry.as_ref()) + "\n").collect::<String>()
    };
    // OTB's and GOT-10k's toolkits need four numbers a line and take NaN for a box. VOT's reads a single number.
    let shown = |form: Form| lines(&|entry| entry.map_or_else(|| "0,0,0,0".to_owned(), |seen| form.line(Some(seen))));
    if format == Format::Otb {
        return vec![("groundtruth_rect.txt", shown(Form::Otb))];
    }
    if format == Format::Vot {
        let sequence = format!(
            "channel.default=color\nchannels.color=color/%08d.png\nformat=default\nfps={RATE}\nheight={height}\nname={name}\nwidth={width}\n"
        );
        return vec![("groundtruth.txt", lines(&|entry| Form::Vot.line(entry))), ("sequence", sequence)];
    }
    let mut files = vec![("groundtruth.txt", shown(Form::Vot))];
    if boxes.len() == frames {
        let (right, bottom) = (width.into(), height.into());
        let is_cut =
            |of: &BoundingBox| of.x < 0.0 || of.y < 0.0 || of.x + of.width > right || of.y + of.height > bottom;
        files.push(("absence.label", lines(&|entry| u8::from(entry.is_none()).to_string())));
        // The covered part of a target is unknown: 8 of 8 parts count as visible, or none.
        files.push(("cover.label", lines(&|entry| if entry.is_some() { "8" } else { "0" }.to_owned())));
        files.push(("cut_by_image.label", lines(&|entry| u8::from(entry.is_some_and(is_cut)).to_string())));
    }
    let seconds = (frames as u64).div_ceil(RATE.into());
    let end = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    let unknown = ["object_class", "motion_class", "major_class", "root_class", "motion_adverb"];
    let unknown: String = unknown.map(|key| format!("{key}: unknown\n")).concat();
    let meta = format!(
        "[METAINFO]\nurl: unknown\nbegin: 00:00:00\nend: {end}\nanno_fps: {RATE}Hz\n{unknown}resolution: ({width}, {height})\n"
    );
    files.push(("meta_info.ini", meta));
    files
}

/// Returns the list of sequences beside the folder `out`, if the toolkit reads one.
pub(super) fn list(format: Format, out: &Path) -> Option<PathBuf> {
    matches!(format, Format::Vot | Format::Got10k).then(|| out.with_file_name("list.txt"))
}

/// Writes the configuration of a workspace of the VOT toolkit and returns its path, if `list` lies in a folder called
/// `sequences`, as in a workspace, and there is no configuration yet.
///
/// The stack names no data set, so the toolkit downloads nothing. Version 0.9 can run this one experiment.
pub(super) fn configure(format: Format, list: &Path) -> Result<Option<PathBuf>> {
    const WORKSPACE: &str = "registry:\n- trackers.ini\nsequences: sequences\nstack:\n  title: Recordings of host-sim\n  experiments:\n    unsupervised:\n      type: unsupervised\n";
    let above = list.parent().filter(|above| above.ends_with("sequences") && format == Format::Vot);
    let config = above.map(|above| above.with_file_name("config.yaml")).filter(|config| !config.exists());
    config.map(|config| output::write(&config, WORKSPACE.as_bytes()).map(|()| config)).transpose()
}

/// Adds the sequence `name` to `list`, if it is not in it.
pub(super) fn enlist(list: &Path, name: &str) -> Result<()> {
    let mut text = if list.is_file() {
        fs::read_to_string(list).with_context(|| format!("cannot read {}", list.display()))?
    } else {
        String::new()
    };
    if text.lines().any(|line| line.trim() == name) {
        return Ok(());
    }
    if !text.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    output::write(list, (text + name + "\n").as_bytes())
}
