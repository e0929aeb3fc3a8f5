//! Opens recordings by one call, [`open`]: folders of pictures, Y4M, video, raw dumps, cameras and built-in scenes.
//!
//! A [`Sequence`] streams frames with the boxes known about them. [`fault`] and [`cover`] change frames on their way to
//! a tracker.

pub mod annotations;
mod built_in;
mod damage;
mod disturb;
mod ffmpeg;
mod folders;
mod formats;
mod frame_number;
mod frame_range;
#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;
mod resize;
mod source;

pub use annotations::boxes::{self, BoundingBox};
pub use annotations::start::{Start, Target, check_gone, checked_name};
pub use built_in::{street, synthetic};
pub use damage::Damaged;
pub use disturb::{away, cover, fault, slow};
pub use ffmpeg::{Arrivals, Live, Moment, PATIENCE as FFMPEG_PATIENCE, input as ffmpeg_input, is_live, silent};
pub use folders::recordings;
pub use formats::images::{Picture, decode_colors, decode_picture};
pub use formats::to_gray::{Levels, luma};
pub use formats::y4m::Planes;
pub use frame_number::FrameNumber;
pub use frame_range::{FrameRange, misfit};
pub use resize::{Resize, Scalable, resized};
pub use source::{Seekable, Source, is_seekable};

use anyhow::{Context, Result, anyhow, bail, ensure};
use built_in::{border, noise, periodic, tiles};
use formats::{images, names, raw, y4m};
use smr_files::messages;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufReader, stdin};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// A frame; its pixels are stored row by row, without gaps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster<P> {
    pub width: u16,
    pub height: u16,
    pub pixels: Vec<P>,
}

pub type GrayFrame = Raster<u8>;

pub type ColorFrame = Raster<[u8; 3]>;

#[derive(Clone, Debug)]
pub struct Frame {
    /// Number in the recording, from 1; a live source also counts the frames that it dropped.
    pub number: usize,
    pub seconds: Option<f64>,
    pub gray: GrayFrame,
    /// The frame in color, if requested by [`Sequence::in_color`].
    pub color: Option<ColorFrame>,
    /// Presentation time and pixel aspect, for a video written from the color frames.
    pub moment: Option<Moment>,
    /// Luma and chroma planes of the frame, kept only for a live source, because it cannot be read a second time.
    pub planes: Option<Planes>,
}

impl Frame {
    pub fn new(number: usize, seconds: Option<f64>, gray: GrayFrame) -> Self {
        Self { number, seconds, gray, color: None, moment: None, planes: None }
    }
}

/// Largest number of pixels in a frame, 16384x16384. A larger frame is refused before memory is allocated for it.
const MAX_PIXELS: u64 = 1 << 28;

impl GrayFrame {
    /// Draws a frame row by row; `level` returns the gray level of the pixel (x, y).
    pub fn drawn(width: u16, height: u16, mut level: impl FnMut(i32, i32) -> u8) -> Self {
        let places = (0..i32::from(height)).flat_map(|y| (0..i32::from(width)).map(move |x| (x, y)));
        Self { width, height, pixels: places.map(|(x, y)| level(x, y)).collect() }
    }

    pub fn frame(&self) -> smr_core::Frame<'_> {
        smr_core::Frame::whole(self.image())
    }

    pub fn image(&self) -> smr_core::Image<'_> {
        let image = smr_core::Image::new(&self.pixels, self.width, self.height);
        image.expect("a GrayFrame is made with as many pixels as its size says, and at least one")
    }

    /// Returns the gray level of a pixel; 0 outside the frame, as in the zero padding of the trackers.
    pub fn level(&self, x: i32, y: i32) -> u8 {
        let (Ok(x), Ok(y)) = (u16::try_from(x), u16::try_from(y)) else { return 0 };
        let inside = x < self.width && y < self.height;
        if inside { self.pixels[usize::from(y) * usize::from(self.width) + usize::from(x)] } else { 0 }
    }
}

pub type Frames = Box<dyn Iterator<Item = Result<Frame>> + Send>;

impl From<smr_core::Image<'_>> for GrayFrame {
    fn from(image: smr_core::Image<'_>) -> Self {
        Self { width: image.width(), height: image.height(), pixels: image.rows().flatten().copied().collect() }
    }
}

/// A recording: its frames in order, and its start box and ground truth, if known.
pub struct Sequence {
    /// Name of the folder, or of the file without its extension.
    pub name: String,
    /// Frames in order, all of the size of the first. A frame of another size is an error; no frame follows an error.
    pub frames: Frames,
    /// Count of frames, if known before they are read.
    pub length: Option<usize>,
    /// Number of the first frame: 1, or more after [`Sequence::part`].
    pub first: usize,
    /// Box on which trackers lock in the first frame.
    pub init: Option<BoundingBox>,
    /// Ground truth, one entry per frame; `None` where the target is not visible.
    pub truth: Option<Vec<Option<BoundingBox>>>,
    pub source: Source,
    pub notes: Vec<String>,
}

impl Sequence {
    /// Creates a sequence of generated frames. Trackers start from the first frame's box in `truth`.
    pub fn made(
        name: &str,
        frames: impl ExactSizeIterator<Item = GrayFrame> + Send + 'static,
        truth: Vec<Option<BoundingBox>>,
    ) -> Self {
        let (length, init) = (Some(frames.len()), truth.first().copied().flatten());
        Self { length, init, truth: Some(truth), ..Self::endless(name.to_owned(), frames) }
    }

    fn endless(name: String, frames: impl Iterator<Item = GrayFrame> + Send + 'static) -> Self {
        let frames = (1..).zip(frames).map(|(number, gray)| Ok(Frame::new(number, None, gray)));
        Self::streamed(name, frames, Source::Once)
    }

    fn streamed(name: String, frames: impl Iterator<Item = Result<Frame>> + Send + 'static, source: Source) -> Self {
        // A pipe may not keep to the frame rate in its Y4M header, so times computed from that rate are dropped.
        let has_times = !matches!(source, Source::Once);
        let timed = move |frame: Frame| Frame { seconds: frame.seconds.filter(|_| has_times), ..frame };
        let frames = damage::frames(frames.map(move |frame| frame.map(timed)), name.clone());
        Self { name, frames, length: None, first: 1, init: None, truth: None, source, notes: Vec::new() }
    }

    /// Returns the start box in whole pixels. Errors: There is no box, it has no pixels, or a `Rect` cannot hold it.
    pub fn start(&self) -> Result<smr_core::Rect> {
        let (name, first) = (&self.name, self.first);
        let init = self.init.with_context(|| match first {
            1 => format!("{name}: no initial box: give --init X,Y,W,H (drag it in `host-sim view`), or init.txt beside the recording"),
            _ => format!("{name}: no initial box for frame {first}: give --init X,Y,W,H (init.txt has that of frame 1)"),
        })?;
        init.pixels().map_err(|what| anyhow!("{name}: the initial box {what}"))
    }
}

#[derive(Clone, Debug, Default)]
pub struct OpenOptions {
    /// Frame width and height of a raw dump. If given, any file but a picture, video or Y4M is read as a raw dump.
    pub size: Option<(u16, u16)>,
    /// Range of 16-bit values to stretch to 0..255; an error if the recording is not of 16-bit pictures.
    pub levels: Option<Levels>,
    /// Start box, in place of the one in files beside the recording.
    pub init: Option<BoundingBox>,
    /// Time without output after which ffmpeg counts as hanging; one minute if `None`.
    pub ffmpeg_patience: Option<Duration>,
    /// True if a live source (a camera or a network address) is allowed.
    pub takes_live: bool,
}

impl OpenOptions {
    fn patience(&self) -> Duration {
        self.ffmpeg_patience.unwrap_or(FFMPEG_PATIENCE)
    }
}

/// Folder beside a recording that holds result files of other trackers.
pub const RESULTS: &str = "trackers";

/// Subfolders that hold a recording's pictures: `img` in the layout of OTB, `color` in that of VOT.
pub const INNER: [&str; 2] = ["img", "color"];

/// Opens the recording at `path`: a folder of pictures (also one level down, in `img/` or `color/`), a folder with one
/// video, Y4M file or raw dump, or such a file itself. A name in [`BUILT_IN`] is a built-in recording, even if a folder
/// has that name (`./synthetic` is the folder), and `-` is Y4M from standard input.
///
/// The folder also holds the start box (`init.txt`, else the first of the ground truth) and the ground truth (`gt.txt`
/// in TLD form, else `groundtruth_rect.txt` in OTB form, else `groundtruth.txt` in VOT or GOT-10k form).
pub fn open(path: &Path, options: &OpenOptions) -> Result<Sequence> {
    let mut sequence = if path == Path::new(STANDARD_INPUT) {
        ensure!(options.size.is_none(), "--size is for raw dumps: standard input is read as Y4M");
        let name = "standard input".to_owned();
        let frames = y4m::Frames::new(BufReader::new(stdin()), name.clone())?;
        Sequence::streamed(name, frames, Source::Once)
    } else if is_live(path) {
        ensure!(options.size.is_none(), "--size is for raw dumps: a live source says its size");
        let (name, _) = ffmpeg::without_secrets(path);
        ensure!(options.takes_live, "{name} is a live source, for `track` and `view` alone: expected a recording");
        let live = Live::open(path, options.patience())?;
        let (name, source) = (live.name.clone(), Source::Live(Arc::clone(&live.arrivals)));
        Sequence::streamed(name, live.map(Ok), source)
    } else if let Some(built_in) = built_in(path) {
        ensure!(options.size.is_none(), "--size is for raw dumps: {} is a built-in recording", path.display());
        built_in
    } else {
        ensure!(!path.to_string_lossy().starts_with("/dev/video"), "there is no camera {}: {LIVE}", path.display());
        let kind = fs::metadata(path).with_context(|| {
            let known = BUILT_IN.join(", ");
            format!("cannot open {}: expected a folder, a file, or one of {known}", path.display())
        })?;
        let (name, folder, sequence) = if kind.is_dir() {
            (folder_name(path), path, source_in(path, options)?)
        } else {
            let is_picture = images::is_picture(path) && options.size.is_none();
            let sequence =
                if is_picture { pictures(Picture::all_in(path), path, options) } else { source_of(path, options)? };
            let name =
                path.file_stem().map_or_else(|| path.as_os_str().to_string_lossy(), |stem| stem.to_string_lossy());
            (name.into_owned(), path.parent().unwrap_or(Path::new("")), sequence)
        };
        let (truth, init) = boxes_in(folder)?;
        Sequence { name, init, truth, ..sequence }
    };
    let has_levels = matches!(sequence.source, Source::Pictures(_));
    ensure!(options.levels.is_none() || has_levels, "--levels is for 16-bit pictures: {} is none", sequence.name);
    sequence.init = options.init.or(sequence.init);
    // Tables have one line for each recording, so the name must be one line.
    sequence.name = messages::line(&sequence.name);
    Ok(sequence)
}

const LIVE: &str = "let ffmpeg read it, and pipe its Y4M into `host-sim track -` (host-sim/README.md, A live camera)";

/// Path that stands for Y4M from standard input, which has no files of boxes beside it.
const STANDARD_INPUT: &str = "-";

pub const BUILT_IN: [&str; 6] = [street::NAME, synthetic::NAME, periodic::NAME, border::NAME, noise::NAME, tiles::NAME];

/// Names of the built-in recordings that test smr-core, without `noise`, which has no target and is only for timing.
pub const CHECKED: [&str; 3] = [synthetic::NAME, periodic::NAME, border::NAME];

fn built_in(path: &Path) -> Option<Sequence> {
    let made =
        [street::sequence, synthetic::sequence, periodic::sequence, border::sequence, noise::sequence, tiles::sequence];
    let exact = BUILT_IN.iter().zip(made).find(|(name, _)| path == Path::new(name)).map(|(_, made)| made());
    exact.or_else(|| synthetic::seeded(path.to_str()?))
}

/// True if `path` may be a recording that [`open`] reads: a built-in name, `-`, a live source, any file, or a folder
/// that holds recording files, judged by their names. False for a folder with a subfolder for each recording.
pub fn is_sequence(path: &Path) -> bool {
    if BUILT_IN.iter().chain([&STANDARD_INPUT]).any(|name| path == Path::new(name)) || path.is_file() || is_live(path) {
        return true;
    }
    let holds =
        |folder: &Path, is: fn(&Path) -> bool| files_in(folder).is_ok_and(|files| files.iter().any(|file| is(file)));
    // Unsupported pictures beside boxes count as a recording, so that `open` reports why it cannot read them.
    let has_boxes = holds(path, boxes::is_known);
    let has_pictures =
        |folder: &Path| holds(folder, images::is_picture) || has_boxes && holds(folder, images::is_foreign);
    holds(path, is_recording) || has_pictures(path) || INNER.iter().any(|inner| has_pictures(&path.join(inner)))
}

fn check_pictures(folder: &Path) -> Result<()> {
    pictures_in(folder, &files_in(folder)?)?.first().map_or(Ok(()), |first| images::check_kind(first))
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

/// Returns the name of a folder, also of `.` and `..`.
fn folder_name(folder: &Path) -> String {
    let absolute = fs::canonicalize(folder).unwrap_or_default();
    let name = folder.file_name().or(absolute.file_name());
    name.map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn pictures(mut pictures: Vec<Picture>, at: &Path, options: &OpenOptions) -> Sequence {
    let length = Some(pictures.len());
    pictures.iter_mut().for_each(|picture| picture.levels = options.levels);
    let notes = images::levels_note(&pictures).into_iter().collect();
    let frames = images::frames(&pictures, 1);
    Sequence { length, notes, ..Sequence::streamed(at.display().to_string(), frames, Source::Pictures(pictures)) }
}

fn source_in(folder: &Path, options: &OpenOptions) -> Result<Sequence> {
    let files = files_in(folder)?;
    let pictures = pictures_in(folder, &files)?;
    if pictures.is_empty() {
        return source_of(only_recording(folder, &files)?, options);
    }
    let (count, at) = (pictures.len(), folder.display());
    ensure!(options.size.is_none(), "--size is for raw dumps: {at} holds pictures");
    if let Some(recording) = files.iter().find(|file| is_recording(file)) {
        let (picture, recording) = (pictures[0].display(), recording.display());
        bail!(
            "{at} holds {recording} and {count} pictures, {picture} first: expected one or the other; name the file meant"
        );
    }
    images::check_kind(&pictures[0])?;
    // A skipped picture would shift the boxes of all later frames, so a path that is no file (broken link) is an error.
    for (number, picture) in (1..).zip(&pictures) {
        check_file(picture, &format!("{} (frame {number})", picture.display()))?;
    }
    Ok(self::pictures(pictures.into_iter().map(Picture::from).collect(), folder, options))
}

/// Returns the pictures in a folder and its subfolders `INNER`, sorted by name. Errors: The pictures have several
/// formats or lie in several of these folders, or two pictures have the same number.
fn pictures_in(folder: &Path, files: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let inner = INNER.map(|inner| folder.join(inner)).into_iter().filter(|inner| inner.is_dir());
    let mut kinds: Vec<Vec<PathBuf>> = Vec::new();
    for place in [Ok(files.to_owned())].into_iter().chain(inner.map(|inner| files_in(&inner))) {
        let mut of_kind = BTreeMap::<String, Vec<PathBuf>>::new();
        for (kind, file) in place?.into_iter().filter_map(|file| Some((images::kind(&file)?, file))) {
            of_kind.entry(kind).or_default().push(file);
        }
        kinds.extend(of_kind.into_values());
    }
    let at = folder.display();
    kinds.iter_mut().for_each(|files| names::sort(files));
    if let [one, other, ..] = &kinds[..] {
        let (count, others) = (one.len(), other.len());
        let [one, other] = [one, other].map(|files| files[0].display());
        bail!(
            "{at} holds pictures with two kinds of names, {count} like {one} and {others} like {other}: expected one kind; move the others away"
        );
    }
    let pictures = kinds.pop().unwrap_or_default();
    if let Some([one, other]) = names::twins(&pictures).map(|both| both.map(Path::display)) {
        bail!(
            "{at} holds {one} and {other}, two pictures with the same number: expected one for each frame; move the others away"
        );
    }
    Ok(pictures)
}

fn only_recording<'a>(folder: &Path, files: &'a [PathBuf]) -> Result<&'a Path> {
    let mut recordings = files.iter().filter(|file| is_recording(file));
    let Some(recording) = recordings.next() else {
        bail!("{} holds no recording: expected pictures (PNG, JPEG, PGM, PPM, PAM) or one video", folder.display());
    };
    if let Some(second) = recordings.next() {
        let (first, second) = (recording.display(), second.display());
        bail!("{} holds several recordings, among them {first} and {second}: name the one meant", folder.display());
    }
    check_file(recording, &recording.display().to_string())?;
    Ok(recording)
}

/// Returns an error if `file`, called `name` in messages, is a broken link, a pipe or a device.
fn check_file(file: &Path, name: &str) -> Result<()> {
    ensure!(file.exists(), "{name} is a link to a file that is not there");
    ensure!(file.is_file(), "{name} is a pipe or a device: expected a file, or nothing of that name in the folder");
    Ok(())
}

fn is_recording(file: &Path) -> bool {
    y4m::is_y4m(file) || raw::is_raw(file) || ffmpeg::is_video(file)
}

fn source_of(file: &Path, options: &OpenOptions) -> Result<Sequence> {
    let name = file.display().to_string();
    // ffmpeg would read an unsupported picture as a video of one frame. A GIF may be an animation, so ffmpeg reads it.
    if !has_extension(file, &["gif"]) {
        images::check_kind(file)?;
    }
    let data = fs::metadata(file).with_context(|| format!("cannot open {name}"))?;
    // A pipe has length 0, but can be read.
    ensure!(!data.is_file() || data.len() > 0, "{name} is empty: expected a recording");
    let is_other = ffmpeg::is_video(file) || y4m::is_y4m(file) || images::is_picture(file);
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
    let frames = (1..).zip(reading).map(|(number, picture)| Ok(picture?.gray(number)));
    Ok(Sequence { notes, ..Sequence::streamed(name, frames, source) })
}

/// True if the extension is that of a picture, video, Y4M file or raw dump.
pub fn is_of_frames(file: &Path) -> bool {
    images::is_picture(file) || is_recording(file)
}

/// True if the file has the name of an annotation file, or lies in the folder of other trackers' results.
pub fn is_of_boxes(file: &Path) -> bool {
    boxes::is_known(file) || file.parent().is_some_and(|folder| folder.ends_with(RESULTS))
}

/// Returns the entries of a folder except subfolders: files, broken links, pipes and devices.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = folders::entries(folder).with_context(|| format!("cannot list the folder {}", folder.display()))?;
    files.retain(|path| !path.is_dir());
    files.sort();
    Ok(files)
}

fn has_extension(file: &Path, extensions: &[&str]) -> bool {
    let extension = file.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| extensions.iter().any(|known| known.eq_ignore_ascii_case(extension)))
}

#[cfg(test)]
type Paper = smr_core::Paper<65536, 4096>;

/// FNV-1a hash, by which tests notice a changed pixel.
#[cfg(test)]
fn fnv(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

#[cfg(test)]
mod tests;
