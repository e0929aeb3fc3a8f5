//! Opens a recording by its path: folders of images, Y4M, video, raw dumps, cameras and built-in scenes.

use crate::annotations::boxes;
use crate::bounding_box::BoundingBox;
use crate::built_in::{BUILT_IN, built_in, synthetic};
use crate::ffmpeg::{self, Live, is_live};
use crate::folder::{INNER, check_file, files_in, folder_name, images_in, is_recording, only_recording};
use crate::formats::images::{self, ImageFile};
use crate::formats::names::has_extension;
use crate::formats::to_gray::Levels;
use crate::formats::{raw, y4m};
use crate::sequence::Sequence;
use crate::source::Source;
use anyhow::{Context, Result, bail, ensure};
use smr_files::messages;
use std::fs;
use std::io::{BufReader, stdin};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

#[derive(Clone, Debug, Default)]
pub struct OpenOptions {
    /// Frame width and height of a raw dump. If given, any file but an image, video or Y4M is read as a raw dump.
    pub size: Option<(u16, u16)>,
    /// Range of 16-bit values to stretch to 0..255; an error if the recording is not of 16-bit images.
    pub levels: Option<Levels>,
    /// Start box, in place of the one in files beside the recording.
    pub init: Option<BoundingBox>,
    /// Time without output after which ffmpeg counts as hanging; one minute if `None`.
    pub ffmpeg_patience: Option<Duration>,
    /// True if a live source (a camera or a network address) is allowed.
    pub takes_live: bool,
}

impl OpenOptions {
    pub(crate) fn patience(&self) -> Duration {
        self.ffmpeg_patience.unwrap_or(ffmpeg::PATIENCE)
    }
}

/// Opens the recording at `path`: a folder of images (also one level down, in `img/` or `color/`), a folder with one
/// video, Y4M file or raw dump, or such a file itself. A name in [`BUILT_IN`] is a built-in recording, even if a folder
/// has that name (`./synthetic` is the folder), and `-` is Y4M from standard input.
///
/// The folder also holds the start box (`init.txt`, else the first of the ground truth) and the ground truth (`gt.txt`
/// in TLD form, else `groundtruth_rect.txt` in OTB form, else `groundtruth.txt` in VOT or GOT-10k form).
pub fn open(path: &Path, options: &OpenOptions) -> Result<Sequence> {
    let mut sequence = if path == Path::new(STANDARD_INPUT) {
        of_standard_input(options)?
    } else if is_live(path) {
        of_live(path, options)?
    } else if let Some(built_in) = built_in(path) {
        ensure!(options.size.is_none(), "--size is for raw dumps: {} is a built-in recording", path.display());
        built_in
    } else {
        of_files(path, options)?
    };
    let has_levels = matches!(sequence.source, Source::Images(_));
    ensure!(options.levels.is_none() || has_levels, "--levels is for 16-bit pictures: {} is none", sequence.name);
    sequence.init = options.init.or(sequence.init);
    // Tables have one line for each recording, so the name must be one line.
    sequence.name = messages::line(&sequence.name);
    Ok(sequence)
}

fn of_standard_input(options: &OpenOptions) -> Result<Sequence> {
    ensure!(options.size.is_none(), "--size is for raw dumps: standard input is read as Y4M");
    let name = "standard input".to_owned();
    let frames = y4m::Frames::new(BufReader::new(stdin()), name.clone())?;
    Ok(Sequence::streamed(name, frames, Source::Once))
}

fn of_live(address: &Path, options: &OpenOptions) -> Result<Sequence> {
    ensure!(options.size.is_none(), "--size is for raw dumps: a live source says its size");
    let (name, _) = ffmpeg::without_secrets(address);
    ensure!(options.takes_live, "{name} is a live source, for `track` and `view` alone: expected a recording");
    let live = Live::open(address, options.patience())?;
    let (name, source) = (live.name.clone(), Source::Live(Arc::clone(&live.arrivals)));
    Ok(Sequence::streamed(name, live.map(Ok), source))
}

/// Opens a folder or a file, with the boxes beside its frames.
fn of_files(path: &Path, options: &OpenOptions) -> Result<Sequence> {
    ensure!(!path.to_string_lossy().starts_with("/dev/video"), "there is no camera {}: {LIVE}", path.display());
    let kind = fs::metadata(path).with_context(|| {
        let known = BUILT_IN.join(", ");
        format!("cannot open {}: expected a folder, a file, or one of {known}", path.display())
    })?;
    let (folder, sequence) = if kind.is_dir() {
        (path, source_in(path, options)?)
    } else {
        let is_image = images::is_image(path) && options.size.is_none();
        let sequence =
            if is_image { images(ImageFile::all_in(path), path, options) } else { source_of(path, options)? };
        (path.parent().unwrap_or(Path::new("")), sequence)
    };
    let (truth, init) = boxes_in(folder)?;
    Ok(Sequence { name: name_of(path), init, truth, ..sequence })
}

/// Returns the name of the recording at `path`, in one line: that of its folder, or of its file without the extension.
pub fn name_of(path: &Path) -> String {
    let file = || path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    messages::line(&if path.is_dir() { folder_name(path) } else { file() })
}

const LIVE: &str = "let ffmpeg read it, and pipe its Y4M into `host-sim track -` (host-sim/README.md, A live camera)";

/// Path that stands for Y4M from standard input, which has no files of boxes beside it.
const STANDARD_INPUT: &str = "-";

/// True if `path` may be a recording that [`open`] reads: a built-in name, `-`, a live source, any file, or a folder
/// that holds recording files, judged by their names. False for a folder with a subfolder for each recording.
pub(crate) fn is_sequence(path: &Path) -> bool {
    let is_seeded = || path.to_str().and_then(synthetic::seeded).is_some();
    let is_named = BUILT_IN.iter().chain([&STANDARD_INPUT]).any(|name| path == Path::new(name));
    if is_named || path.is_file() || is_live(path) || is_seeded() {
        return true;
    }
    let holds =
        |folder: &Path, is: fn(&Path) -> bool| files_in(folder).is_ok_and(|files| files.iter().any(|file| is(file)));
    // Unsupported images beside boxes count as a recording, so that `open` reports why it cannot read them.
    let has_boxes = holds(path, boxes::is_known);
    let has_images = |folder: &Path| holds(folder, images::is_image) || has_boxes && holds(folder, images::is_foreign);
    holds(path, is_recording) || has_images(path) || INNER.iter().any(|inner| has_images(&path.join(inner)))
}

type Truth = Vec<Option<BoundingBox>>;

fn boxes_in(folder: &Path) -> Result<(Option<Truth>, Option<BoundingBox>)> {
    let truth = boxes::find_truth(folder)?;
    let first = truth.as_ref().and_then(|truth| *truth.first()?);
    let init = boxes::find_init(folder)?.or(first);
    Ok((truth, init))
}

/// Returns the start box from the annotation files beside `file`, for callers that read its frames without [`open`].
pub fn start_beside(file: &Path) -> Result<Option<BoundingBox>> {
    Ok(boxes_in(file.parent().unwrap_or(Path::new("")))?.1)
}

fn images(mut images: Vec<ImageFile>, at: &Path, options: &OpenOptions) -> Sequence {
    let length = Some(images.len());
    images.iter_mut().for_each(|image| image.levels = options.levels);
    let notes = images::levels_note(&images).into_iter().collect();
    let frames = images::frames(&images, 1);
    Sequence { length, notes, ..Sequence::streamed(at.display().to_string(), frames, Source::Images(images)) }
}

fn source_in(folder: &Path, options: &OpenOptions) -> Result<Sequence> {
    let files = files_in(folder)?;
    let images = images_in(folder, &files)?;
    if images.is_empty() {
        return source_of(only_recording(folder, &files)?, options);
    }
    let (count, at) = (images.len(), folder.display());
    ensure!(options.size.is_none(), "--size is for raw dumps: {at} holds pictures");
    if let Some(recording) = files.iter().find(|file| is_recording(file)) {
        let (image, recording) = (images[0].display(), recording.display());
        let pictures = if count == 1 { "picture" } else { "pictures" };
        bail!(
            "{at} holds {recording} and {count} {pictures}, {image} first: expected one or the other; name the file meant"
        );
    }
    images::check_kind(&images[0])?;
    // A skipped image would shift the boxes of all later frames, so a path that is no file (broken link) is an error.
    for (number, image) in (1..).zip(&images) {
        check_file(image, &format!("{} (frame {number})", image.display()))?;
    }
    Ok(self::images(images.into_iter().map(ImageFile::from).collect(), folder, options))
}

fn source_of(file: &Path, options: &OpenOptions) -> Result<Sequence> {
    let name = file.display().to_string();
    // ffmpeg would read an unsupported image as a video of one frame. A GIF may be an animation, so ffmpeg reads it.
    if !has_extension(file, &["gif"]) {
        images::check_kind(file)?;
    }
    let data = fs::metadata(file).with_context(|| format!("cannot open {name}"))?;
    // A pipe has length 0, but can be read.
    ensure!(!data.is_file() || data.len() > 0, "{name} is empty: expected a recording");
    let is_other = ffmpeg::is_video(file) || y4m::is_y4m(file) || images::is_image(file);
    ensure!(options.size.is_none() || !is_other, "--size is for raw dumps: {name} is none");
    if options.size.is_some() || raw::is_raw(file) {
        let size = options
            .size
            .with_context(|| format!("{name} is a raw dump: the size of its frames is needed (--size WIDTHxHEIGHT)"))?;
        let (frames, length) = raw::open(file, size)?;
        return Ok(Sequence { length, ..Sequence::streamed(name, frames, Source::Once) });
    }
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_char_device(&data.file_type()) {
        bail!("{name} is a device, and host-sim reads files: {LIVE}");
    }
    let source = if data.is_file() { Source::Video(file.to_owned()) } else { Source::Once };
    if y4m::is_y4m(file) {
        return Ok(Sequence::streamed(name, y4m::open(file)?, source));
    }
    // ffmpeg would render a text file as a video of a terminal.
    ensure!(!has_extension(file, &["txt"]), "{name} is a text file: expected a recording (a video, Y4M or pictures)");
    if data.is_file() {
        fs::File::open(file).with_context(|| format!("cannot open {name}"))?;
    }
    let reading = ffmpeg::open("ffmpeg", file, ffmpeg::Use::Gray, options.patience())?;
    let notes = reading.note.clone().into_iter().collect();
    let frames = (1..).zip(reading).map(|(number, image)| Ok(image?.gray(number)));
    Ok(Sequence { notes, ..Sequence::streamed(name, frames, source) })
}

#[cfg(test)]
mod tests;
