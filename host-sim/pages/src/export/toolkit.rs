//! Whole recordings in the layouts that the toolkits of VOT, OTB and GOT-10k read.
//!
//! | toolkit | frames | boxes | besides |
//! |---|---|---|---|
//! | VOT | `color/00000001.png` | `groundtruth.txt`; 0 where the target is not visible | `sequence`: what the recording is like |
//! | OTB | `img/0001.jpg` | `groundtruth_rect.txt`, the first pixel being 1; no area where it is not visible | |
//! | GOT-10k | `00000001.jpg` | `groundtruth.txt`; no area where it is not visible | `meta_info.ini`, and a number for each frame in `absence.label`, `cover.label` and `cut_by_image.label` |
//!
//! Without ground truth the file with boxes has one line, the box to start from, as in the test sets of GOT-10k.

use super::Format;
use crate::encode;
use anyhow::{Context, Result};
use smr_recordings::boxes::Form;
use smr_recordings::messages::choice_name;
use smr_recordings::{BoundingBox, GrayFrame, output};
use std::fs;
use std::path::{Path, PathBuf};

/// Frames a second: a recording does not say how many it has.
const RATE: u32 = 25;

/// The best that JPEG has.
const QUALITY: u8 = 100;

/// What is known of a recording when all its frames are written.
pub(super) struct About<'a> {
    pub name: &'a str,
    pub frames: usize,
    pub width: u16,
    pub height: u16,
    /// One entry a frame; without ground truth the box to start from alone.
    pub boxes: &'a [Option<BoundingBox>],
}

/// The folder of the pictures in that of the recording, if they have one of their own.
pub(super) const fn inner(format: Format) -> Option<&'static str> {
    match format {
        Format::Vot => Some("color"),
        Format::Otb => Some("img"),
        _ => None,
    }
}

/// The name of the frame with this number; the first is 1.
pub(super) fn picture(format: Format, number: usize) -> String {
    match format {
        Format::Vot => format!("color/{number:08}.png"),
        Format::Otb => format!("img/{number:04}.jpg"),
        Format::Got10k => format!("{number:08}.jpg"),
        _ => format!("{number:05}.{}", choice_name(&format)),
    }
}

/// The toolkits of OTB and GOT-10k look for files *.jpg alone.
pub(super) fn jpeg(frame: &GrayFrame) -> Result<Vec<u8>> {
    encode::jpeg(frame, QUALITY)
}

/// The files beside the pictures: those with boxes first, the one with all boxes before all others.
pub(super) fn files(format: Format, about: &About<'_>) -> Vec<(&'static str, String)> {
    // Their toolkits read four numbers in each line, and take NaN for a box. VOT's knows a number alone.
    let hidden = |form: Form| if format == Format::Vot { form.line(None) } else { "0,0,0,0".to_owned() };
    let lines = |form: Form| {
        let line = |entry: &Option<BoundingBox>| entry.map_or_else(|| hidden(form), |of| form.line(Some(&of)));
        about.boxes.iter().map(|entry| line(entry) + "\n").collect::<String>()
    };
    let mark = |of: &dyn Fn(&Option<BoundingBox>) -> u8| {
        about.boxes.iter().map(|entry| format!("{}\n", of(entry))).collect::<String>()
    };
    match format {
        Format::Otb => return vec![("groundtruth_rect.txt", lines(Form::Otb))],
        Format::Vot => return vec![("groundtruth.txt", lines(Form::Vot)), ("sequence", vot_sequence(about))],
        _ => {}
    }
    let mut files = vec![("groundtruth.txt", lines(Form::Vot))];
    if about.boxes.len() == about.frames {
        let (width, height) = (about.width.into(), about.height.into());
        let is_cut =
            |of: &BoundingBox| of.x < 0.0 || of.y < 0.0 || of.x + of.width > width || of.y + of.height > height;
        files.push(("absence.label", mark(&|entry| entry.is_none().into())));
        // How much of the target is covered is not known: 8 of 8 parts are visible, or none.
        files.push(("cover.label", mark(&|entry| if entry.is_some() { 8 } else { 0 })));
        files.push(("cut_by_image.label", mark(&|entry| entry.as_ref().is_some_and(is_cut).into())));
    }
    files.push(("meta_info.ini", got10k_meta(about)));
    files
}

/// The list of sequences in the folder that has this one and others, if the toolkit reads one.
pub(super) fn list(format: Format, out: &Path) -> Option<PathBuf> {
    matches!(format, Format::Vot | Format::Got10k).then(|| out.with_file_name("list.txt"))
}

/// Writes the configuration of a workspace of the VOT toolkit, if `list` lies in a folder called `sequences`, where
/// workspaces have theirs, and there is none yet. Returns the file.
///
/// Its stack names no data set, so the toolkit downloads nothing. The experiment is the one that version 0.9 can run.
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

fn vot_sequence(About { name, width, height, .. }: &About<'_>) -> String {
    format!(
        "channel.default=color\nchannels.color=color/%08d.png\nformat=default\nfps={RATE}\nheight={height}\nname={name}\nwidth={width}\n"
    )
}

fn got10k_meta(About { frames, width, height, .. }: &About<'_>) -> String {
    let seconds = (*frames as u64).div_ceil(RATE.into());
    let end = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    let unknown = ["object_class", "motion_class", "major_class", "root_class", "motion_adverb"];
    let unknown: String = unknown.map(|key| format!("{key}: unknown\n")).concat();
    format!(
        "[METAINFO]\nurl: unknown\nbegin: 00:00:00\nend: {end}\nanno_fps: {RATE}Hz\n{unknown}resolution: ({width}, {height})\n"
    )
}
