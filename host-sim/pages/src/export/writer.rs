//! Writes a recording as files for host-sim, other programs and firmware, or in the layout of a toolkit:
//!
//! | toolkit | frames | boxes | besides |
//! |---|---|---|---|
//! | VOT | `color/00000001.png` | `groundtruth.txt`; 0 where the target is not visible | `sequence`: what the recording is like |
//! | OTB | `img/0001.jpg` | `groundtruth_rect.txt`, the first pixel being 1; no area where it is not visible | |
//! | GOT-10k | `00000001.jpg` | `groundtruth.txt`; no area where it is not visible | `meta_info.ini`, and a number for each frame in `absence.label`, `cover.label` and `cut_by_image.label` |
//!
//! Without ground truth the file with boxes has one line, the start box, as in the test sets of GOT-10k.

use super::c_array;
use crate::encode::{jpeg, pgm, png};
use anyhow::{Context, Result};
use serde::Serialize;
use smr_files::messages::choice_name;
use smr_files::output::{Folder, Output};
use smr_recordings::boxes::Form;
use smr_recordings::{BoundingBox, GrayFrame};
use std::fs;
use std::path::{Path, PathBuf};

/// Frame rate in a toolkit's metadata, in frames a second: a fixed value, because the writer gets no frame times.
const RATE: u32 = 25;

/// Format of a written recording: one file with all frames, a folder of pictures, or the layout of a toolkit.
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
    /// True for a toolkit's layout, because toolkits cannot use a recording without boxes.
    pub const fn needs_boxes(self) -> bool {
        matches!(self, Self::Vot | Self::Otb | Self::Got10k)
    }

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
    /// Total size of all frames in bytes, including the headers of their format.
    pub bytes: u64,
    /// Names of the text files written beside the frames: boxes and, for a toolkit, its labels and metadata.
    pub boxes: Vec<&'static str>,
    /// File with a list of sequences, to which the recording was added.
    pub list: Option<PathBuf>,
    /// Configuration of a workspace of the VOT toolkit, if one was written.
    pub config: Option<PathBuf>,
}

const QUALITY: u8 = 100;

/// A recording being written under a temporary name, until [`Writer::finish`].
pub struct Writer {
    name: String,
    format: Format,
    start: Option<BoundingBox>,
    /// File of all frames; `None` if each frame is a picture.
    file: Option<Output>,
    /// Folder of the boxes and the frames; `None` if the recording is written as a single file.
    folder: Option<Folder>,
    written: Written,
}

impl Writer {
    /// Creates a recording `name`: one file if `out` has an extension of `format`, else a folder of frames and boxes.
    pub fn create(out: &Path, format: Format, name: &str, start: Option<BoundingBox>) -> Result<Self> {
        let mut writer =
            Self { name: name.to_owned(), format, start, file: None, folder: None, written: Written::default() };
        if Format::of_file(out) == Some(format) {
            writer.file = Some(Output::create(out)?);
            return Ok(writer);
        }
        let is_listed = matches!(format, Format::Vot | Format::Got10k);
        writer.written.list = is_listed.then(|| out.with_file_name("list.txt"));
        // The folder must be empty, because files in it would become part of the recording or be lost.
        let folder = Folder::create(out)?;
        if let Some((inner, _)) = image(format, 1).split_once('/') {
            folder.folder(inner)?;
        }
        if matches!(format, Format::Y4m | Format::Raw | Format::H) {
            writer.file = Some(folder.file(&format!("{name}.{}", choice_name(&format)))?);
        }
        Ok(Self { folder: Some(folder), ..writer })
    }

    pub fn frame(&mut self, frame: &GrayFrame) -> Result<()> {
        let GrayFrame { width, height, pixels } = frame;
        let bytes = match self.format {
            Format::Png | Format::Vot => png(frame)?,
            // The toolkits of OTB and GOT-10k read only files `*.jpg`.
            Format::Otb | Format::Got10k => jpeg(frame, QUALITY)?,
            Format::Pgm => pgm(frame),
            Format::Y4m => [b"FRAME\n", &pixels[..]].concat(),
            Format::Raw => pixels.clone(),
            Format::H => c_array::element(frame).into_bytes(),
        };
        if self.written.frames == 0 {
            (self.written.width, self.written.height) = (*width, *height);
            match self.format {
                Format::Y4m => self.write(format!("YUV4MPEG2 W{width} H{height} F25:1 Ip A1:1 Cmono\n").as_bytes())?,
                Format::H => self.write(c_array::head(&self.name, frame, self.start.as_ref()).as_bytes())?,
                _ => {}
            }
        }
        self.written.frames += 1;
        self.write(&bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.written.bytes += bytes.len() as u64;
        if let Some(file) = &mut self.file {
            return file.write(bytes);
        }
        let image = image(self.format, self.written.frames);
        self.folder.as_ref().map_or(Ok(()), |folder| folder.write(&image, bytes))
    }

    /// Ends the recording. A folder not for a toolkit gets the start box in `init.txt` and `truth` in `gt.txt`, both in
    /// TLD's format. A toolkit's files get `truth` if `truth` has an entry for each frame and a box in the first, else
    /// only the start box.
    pub fn finish(mut self, truth: Option<&[Option<BoundingBox>]>) -> Result<Written> {
        if self.format == Format::H && self.written.frames > 0 {
            let foot = c_array::foot(&self.name);
            self.write(foot.as_bytes())?;
        }
        let Self { name, format, start, file, folder, mut written } = self;
        file.map_or(Ok(()), Output::finish)?;
        let Some(folder) = folder else { return Ok(written) };
        let line = |entry: &Option<BoundingBox>| Form::Tld.line(entry.as_ref()) + "\n";
        let mut texts = Vec::new();
        if format.needs_boxes() {
            let given = [start];
            let boxes = truth.filter(|truth| is_whole(truth, written.frames)).unwrap_or(&given);
            // Only host-sim reads `init.txt`; the toolkits start from the ground truth.
            texts.extend((boxes[0] != start).then(|| ("init.txt", line(&start))));
            texts.extend(files(format, &name, &written, boxes));
        } else {
            texts.extend(start.map(|_| ("init.txt", line(&start))));
            texts.extend(truth.map(|truth| ("gt.txt", truth.iter().map(line).collect())));
        }
        for (file, text) in texts {
            folder.write(file, text.as_bytes())?;
            written.boxes.push(file);
        }
        let list = written.list.as_ref().map(|list| enlist(list, &name)).transpose()?.flatten();
        let config = written.list.as_ref().and_then(|list| configuration(format, list));
        let text = config.as_ref().map(|config| settled(config, WORKSPACE)).transpose()?;
        folder.finish()?;
        list.into_iter().chain(text).try_for_each(Output::finish)?;
        written.config = config;
        Ok(written)
    }
}

/// True if ground truth has an entry for each frame and a box in the first, as toolkits require.
pub fn is_whole(truth: &[Option<BoundingBox>], frames: usize) -> bool {
    truth.len() == frames && truth.first().is_some_and(Option::is_some)
}

fn image(format: Format, number: usize) -> String {
    match format {
        Format::Vot => format!("color/{number:08}.png"),
        Format::Otb => format!("img/{number:04}.jpg"),
        Format::Got10k => format!("{number:08}.jpg"),
        _ => format!("{number:05}.{}", choice_name(&format)),
    }
}

/// Returns (name, text) of a toolkit's text files, boxes first. Without ground truth `boxes` has only the start box.
fn files(
    format: Format,
    name: &str,
    &Written { frames, width, height, .. }: &Written,
    boxes: &[Option<BoundingBox>],
) -> Vec<(&'static str, String)> {
    let lines = |line: &dyn Fn(Option<&BoundingBox>) -> String| {
        boxes.iter().map(|entry| line(entry.as_ref()) + "\n").collect::<String>()
    };
    // For a frame without a box, OTB's and GOT-10k's toolkits need four values, none of them NaN; VOT's reads one 0.
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
        // The visible eighths of the target are unknown: 8 is written for a frame with a box, 0 without a box.
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

/// Configuration of a workspace of the VOT toolkit. It names no data set, so that the toolkit downloads nothing. Version
/// 0.9 of the toolkit runs the configured experiment.
const WORKSPACE: &str = "registry:\n- trackers.ini\nsequences: sequences\nstack:\n  title: Recordings of host-sim\n  experiments:\n    unsupervised:\n      type: unsupervised\n";

/// Returns the path of a workspace's configuration to write, if `format` is VOT, `list` is in a folder called
/// `sequences`, as in a workspace, and there is no configuration yet.
fn configuration(format: Format, list: &Path) -> Option<PathBuf> {
    let above = list.parent().filter(|above| above.ends_with("sequences") && format == Format::Vot);
    above.map(|above| above.with_file_name("config.yaml")).filter(|config| !config.exists())
}

/// Appends the sequence `name` to the file `list`, which is not finished yet; `None` if the sequence is listed.
fn enlist(list: &Path, name: &str) -> Result<Option<Output>> {
    let mut text = if list.is_file() {
        fs::read_to_string(list).with_context(|| format!("cannot read {}", list.display()))?
    } else {
        String::new()
    };
    if text.lines().any(|line| line.trim() == name) {
        return Ok(None);
    }
    if !text.is_empty() && !text.ends_with('\n') {
        text.push('\n');
    }
    settled(list, &(text + name + "\n")).map(Some)
}

/// Writes a file to the disk, which `finish` then only renames.
fn settled(file: &Path, text: &str) -> Result<Output> {
    let mut output = Output::create(file)?;
    output.write(text.as_bytes())?;
    output.settle()?;
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::{OpenOptions, synthetic};

    const FRAMES: usize = 5;

    fn truth() -> Vec<Option<BoundingBox>> {
        (0..FRAMES).map(|frame| synthetic::truth(frame).filter(|_| frame != 3)).collect()
    }

    fn written(out: &Path, format: Format, truth: Option<&[Option<BoundingBox>]>) -> Written {
        let mut writer = Writer::create(out, format, "clip", synthetic::truth(0)).unwrap();
        for frame in synthetic::frames().take(FRAMES) {
            writer.frame(&frame).unwrap();
            assert!(!out.exists());
        }
        writer.finish(truth).unwrap()
    }

    fn read(out: &Path, format: Format) -> smr_recordings::Sequence {
        let size = (format == Format::Raw).then_some((synthetic::WIDTH, synthetic::HEIGHT));
        smr_recordings::open(out, &OpenOptions { size, ..OpenOptions::default() }).unwrap()
    }

    #[test]
    fn a_folder_reads_back_with_its_boxes() {
        let own = ["init.txt", "gt.txt"];
        for (format, frames, boxes, most) in [
            (Format::Png, "00001.png", &own[..], 0),
            (Format::Pgm, "00001.pgm", &own, 0),
            (Format::Y4m, "clip.y4m", &own, 0),
            (Format::Raw, "clip.raw", &own, 0),
            (Format::Vot, "color/00000001.png", &["groundtruth.txt", "sequence"], 0),
            (Format::Otb, "img/0001.jpg", &["groundtruth_rect.txt"], 2),
            (
                Format::Got10k,
                "00000001.jpg",
                &["groundtruth.txt", "absence.label", "cover.label", "cut_by_image.label", "meta_info.ini"],
                2,
            ),
        ] {
            let above = tempfile::tempdir().unwrap();
            let out = above.path().join("clip");
            let written = written(&out, format, Some(&truth()));
            assert_eq!((written.frames, &written.boxes[..]), (FRAMES, boxes));
            assert!(boxes.iter().chain([&frames]).all(|name| out.join(name).is_file()), "{format:?}");
            assert_eq!(written.list.is_some(), matches!(format, Format::Vot | Format::Got10k));
            let read = read(&out, format);
            assert_eq!((read.init, read.truth), (truth()[0], Some(truth())), "{format:?}");
            let frames: Vec<GrayFrame> = read.frames.map(|frame| frame.unwrap().gray).collect();
            assert_eq!(frames.len(), FRAMES);
            for (read, frame) in frames.iter().zip(synthetic::frames()) {
                let differences = read.pixels.iter().zip(&frame.pixels).map(|(read, pixel)| read.abs_diff(*pixel));
                assert!(differences.max() <= Some(most), "{format:?}");
            }
        }
    }

    #[test]
    fn without_ground_truth_a_toolkit_gets_the_box_to_start_from() {
        let truth = truth();
        for truth in [None, Some(&truth[..2]), Some(&[None; FRAMES][..])] {
            for (format, name) in [
                (Format::Vot, "groundtruth.txt"),
                (Format::Otb, "groundtruth_rect.txt"),
                (Format::Got10k, "groundtruth.txt"),
            ] {
                let above = tempfile::tempdir().unwrap();
                let out = above.path().join("clip");
                let written = written(&out, format, truth);
                assert!(!written.boxes.contains(&"absence.label"));
                assert_eq!(fs::read_to_string(out.join(name)).unwrap().lines().count(), 1, "{format:?}");
                assert_eq!(read(&out, format).init, synthetic::truth(0));
            }
        }
    }

    #[test]
    fn a_folder_of_sequences_gets_a_list() {
        let above = tempfile::tempdir().unwrap();
        let (sequences, config) = (above.path().join("sequences"), above.path().join("config.yaml"));
        let list = sequences.join("list.txt");
        for (name, format) in [("b", Format::Vot), ("a", Format::Got10k), ("c", Format::Otb)] {
            let mut writer = Writer::create(&sequences.join(name), format, name, truth()[0]).unwrap();
            writer.frame(&synthetic::frames().next().unwrap()).unwrap();
            let written = writer.finish(None).unwrap();
            assert_eq!(written.list.is_some(), format != Format::Otb);
            assert_eq!(written.config.is_some(), format == Format::Vot);
        }
        assert_eq!(fs::read_to_string(&list).unwrap(), "b\na\n");
        assert!(fs::read_to_string(&config).unwrap().contains("\nsequences: sequences\n"));
        fs::write(&config, "the user's own").unwrap();
        fs::remove_dir_all(sequences.join("a")).unwrap();
        written(&sequences.join("a"), Format::Vot, None);
        assert_eq!(fs::read_to_string(&list).unwrap(), "b\na\nclip\n");
        assert_eq!(fs::read_to_string(&config).unwrap(), "the user's own");
        written(&above.path().join("others/a"), Format::Vot, None);
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 3, "another folder is not one of a workspace");
    }

    #[test]
    fn a_file_alone_reads_back() {
        let above = tempfile::tempdir().unwrap();
        for (name, format) in [("a.Y4M", Format::Y4m), ("b.gray", Format::Raw)] {
            let out = above.path().join(name);
            let written = written(&out, format, Some(&truth()));
            assert_eq!((written.bytes, written.boxes.len()), (fs::metadata(&out).unwrap().len(), 0));
            let frames = read(&out, format).frames.map(|frame| frame.unwrap().gray);
            assert!(frames.eq(synthetic::frames().take(FRAMES)), "{format:?}");
        }
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 2, "nothing else is written");
    }

    #[test]
    fn a_c_array_holds_the_pixels() {
        let above = tempfile::tempdir().unwrap();
        let out = above.path().join("clip.h");
        let written = written(&out, Format::H, None);
        let text = fs::read_to_string(&out).unwrap();
        assert_eq!(written.bytes, text.len() as u64);
        let (head, array) = text.split_once("= {\n").unwrap();
        assert!(head.contains(&format!("#define CLIP_WIDTH {}\n", synthetic::WIDTH)), "{head}");
        let rect = truth()[0].unwrap().to_rect().unwrap();
        assert!(head.contains(&format!("#define CLIP_X {}\n", rect.x)), "{head}");
        let (array, foot) = array.split_once("};\n").unwrap();
        assert!(foot.contains("#define CLIP_FRAMES (sizeof clip / sizeof clip[0])"), "{foot}");
        let numbers = array.split(['{', '}', ',', '\n']).filter(|text| !text.is_empty());
        let pixels: Vec<u8> = numbers.map(|number| number.parse().unwrap()).collect();
        let expected: Vec<u8> = synthetic::frames().take(FRAMES).flat_map(|frame| frame.pixels).collect();
        assert!(pixels == expected);
    }

    #[test]
    fn what_breaks_off_leaves_nothing() {
        let above = tempfile::tempdir().unwrap();
        for (name, format) in [("a.y4m", Format::Y4m), ("folder", Format::Pgm), ("other", Format::Raw)] {
            let mut writer = Writer::create(&above.path().join(name), format, "clip", None).unwrap();
            writer.frame(&synthetic::frames().next().unwrap()).unwrap();
        }
        assert_eq!(fs::read_dir(above.path()).unwrap().count(), 0);
    }
}
