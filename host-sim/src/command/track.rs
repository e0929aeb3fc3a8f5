//! `host-sim track`: prints the target's box in every frame.

mod follow;
mod lines;
mod opened;
mod pass;
mod plan;
mod run;
mod several;

use super::paths::{Taken, listed};
use super::recording_options::RecordingOptions;
use super::shell;
use super::tracker_options::TrackerOptions;
use super::video::{AnswersVideo, Look, Mark};
use anyhow::{Result, bail, ensure};
use smr_evaluation::{MethodKind, Variant};
use smr_files::messages::choice_name;
use smr_pages::export::boxes::Format;
use smr_pages::export::{FILM_ENDINGS, PixelsPerMetre, Plan};
use smr_recordings::{BUILT_IN, BoundingBox, Sequence, Target, is_live};
use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Track {
    /// The recordings, or folders of recordings; or one live source: `-` (Y4M from standard input, each frame answered at once), an address
    /// for ffmpeg (rtsp://...), or /dev/video0 on Linux; Ctrl-C ends it
    ///
    /// Several recordings make one table, in which `recording` and `target` begin each line (csv, json). In each of them host-sim follows the
    /// boxes of --init (the same in all), else the targets that `view` keeps beside it (SEQ.smr.json), else the box beside it. If a recording
    /// cannot be read to its end, the table has the others, and the exit code is 2. Of two recordings of one name the second is called `a (2)`.
    #[arg(value_name = "SEQ", required = true)]
    sequences: Vec<PathBuf>,
    /// The tracker, or a simpler method for comparison [default: that of --config, else that of the session of `view`, else robust]
    ///
    /// A session also has options of its method. They count only without --method and without any tracker option on the command line.
    #[arg(long, value_enum)]
    method: Option<MethodKind>,
    /// The format of the printed boxes [default: tld; csv for several targets or recordings, or with --pixels-per-metre]
    ///
    /// Formats for several recordings in one file: csv, json. Formats for several targets: csv, json, mot, coco, cvat. coco and cvat files are valid only after the last frame.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Print one JSON object for each frame: --format json
    ///
    /// Its keys: recording (of several), version, method, options (only those given), target (if it has a name), frame (as the recording counts), state, box (whole
    /// pixels), fine (with fractions), confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again, work and quality. A value that the
    /// method does not compute is null, and so are both boxes while the target is lost.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// Write to FILE instead of standard output; an error leaves no file
    ///
    /// Without --format the extension selects the format: .csv, .json, .jsonl or .xml (cvat). Files that end in .txt or have no extension
    /// accept every format. -o boxes.mp4 is the same as --video boxes.mp4: the boxes are then printed.
    ///
    /// Of several recordings, FILE has those that were followed to their end. DIR, a folder that is there or a name without an extension, gets
    /// a file for each recording, with its name.
    #[arg(long, short, value_name = "FILE|DIR")]
    out: Option<PathBuf>,
    /// Also draw the boxes over the frames: .mp4, .mov, .mkv or .webm (they need ffmpeg), or a new folder for PNG pictures
    ///
    /// Each target's box has the target's color in `view`, and is dashed while the target is uncertain, leaving or, at its last position,
    /// lost. Ground truth is green. The text in the picture is the frame number and, of a single target, the state and the confidence in
    /// hundredths; names and states of several targets stand at their boxes; □ stands for letters that are not Latin, Greek, Cyrillic, Armenian or Georgian. The video keeps the recording's colors and, if the recording is a video,
    /// frame times and sound. On a terminal host-sim prints only when a target is lost or found. If the reader of the printed boxes ends
    /// (`| head`), host-sim still finishes the video.
    ///
    /// Of several recordings, DIR gets a video (.mp4) for each, with its name.
    #[arg(long, value_name = "FILE|DIR")]
    video: Option<PathBuf>,
    /// The parts drawn in the video, separated by commas [default: box,name]
    #[arg(long, value_enum, value_name = "MARK", value_delimiter = ',')]
    draw: Vec<Mark>,
    /// Cut the video to a part around the target; of several targets, around the first, or around NAME
    ///
    /// The part is a square with three times the longer side of the first box, or as much of it as fits into the frame, and is enlarged by a whole
    /// number until it has 480 pixels. The target is in its middle, except near the border of the frame. So that the picture does not tremble with
    /// the tracker, the target may be off the middle by a fiftieth of the longer side. While the target is lost, the part stays; within 10 frames it
    /// moves to where the target is found again.
    #[arg(long, value_name = "NAME", num_args = 0..=1, require_equals = true)]
    crop: Option<Option<String>>,
    /// The ids of the targets in the viewer of `view`, which orders the video: they select the colors
    #[arg(long, hide = true, value_delimiter = ',')]
    ids: Vec<usize>,
    /// Also print the centre and its speed in metres, in CSV: N pixels of the recording are a metre [default format then: csv]
    ///
    /// The columns centre_x_m, centre_y_m and speed_m_s follow the column speed. N holds for what moves across the picture, as far from the
    /// camera as what was measured. Like --init, it is in pixels of the original size if --resize is given. Without the option, the length counts
    /// that was drawn in `view`, if its session gives the boxes; the columns of a recording without a length are empty.
    #[arg(long, value_name = "N")]
    pixels_per_metre: Option<PixelsPerMetre>,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

const FILM: Taken = Taken { endings: [&FILM_ENDINGS, &[]], is_folder: true };
const BOXES: Taken = Taken { endings: [&Format::ENDINGS, &FILM_ENDINGS], is_folder: false };

impl Track {
    /// Output file of the boxes, and the options that name a video, with their paths.
    fn outputs(&self) -> (Option<&PathBuf>, Vec<(&'static str, &PathBuf)>) {
        let is_film = |out: &&PathBuf| {
            out.extension().is_some_and(|ending| FILM_ENDINGS.iter().any(|film| ending.eq_ignore_ascii_case(film)))
        };
        let film = self.out.as_ref().filter(is_film).map(|out| ("--out", out));
        let films = film.into_iter().chain(self.video.as_ref().map(|film| ("--video", film))).collect();
        (self.out.as_ref().filter(|out| !is_film(out)), films)
    }

    /// Errors: Options contradict each other, or one is out of range.
    fn check(&self) -> Result<()> {
        let (_, films) = self.outputs();
        ensure!(films.len() < 2, "--out and --video both name a video: expected one of them");
        ensure!(
            !films.is_empty() || (self.draw.is_empty() && self.crop.is_none()),
            "--draw and --crop are of a video: expected --video FILE, too"
        );
        ensure!(
            self.draw.len() < 2 || !self.draw.contains(&Mark::Nothing),
            "--draw nothing stands alone: expected no other mark"
        );
        let is_name = |path: &&PathBuf| {
            let is_word = path.extension().is_none() && path.components().count() == 1 && *path != Path::new("-");
            is_word && !path.exists() && !BUILT_IN.iter().any(|name| *path == Path::new(name)) && !is_live(path)
        };
        if self.crop == Some(None)
            && self.sequences.len() > 1
            && let Some(name) = self.sequences.iter().find(is_name)
        {
            let word = shell::word(name.as_os_str());
            bail!("{}: there is no such recording; did you mean --crop={word}?", name.display());
        }
        // An invalid option is reported once here, not for each recording.
        self.recording.check_init()?;
        self.given_variant().map(drop)
    }

    /// Method and options of the command line, `robust` without any.
    fn given_variant(&self) -> Result<Variant> {
        let method = self.method.or_else(|| self.tracker.method());
        self.tracker.variant(method.unwrap_or(MethodKind::Robust))
    }

    /// True if the command line has a method, or an option of one. Those of the session do not count then.
    fn has_method(&self) -> bool {
        self.method.is_some() || !self.tracker.says_nothing()
    }

    /// Returns the format of the boxes, `usual` if no option selects it. Errors: The extension of the output file belongs
    /// to another format.
    fn format(&self, usual: Format) -> Result<Format> {
        let of_file = self.out.as_ref().and_then(|out| Format::of_file(out));
        let format = if self.json { Format::Json } else { self.format.or(of_file).unwrap_or(usual) };
        if let Some(out) = self.out.as_ref().filter(|out| of_file.is_some() && !format.is_called(out)) {
            let endings = listed(&[format.endings(), &["txt"]].concat());
            let (name, out) = (choice_name(&format), out.display());
            bail!("--format {name} into {out}: expected a file that ends in {endings}, or has no ending");
        }
        ensure!(
            self.pixels_per_metre.is_none() || format == Format::Csv,
            "--pixels-per-metre with --format {}: expected csv, which has columns in metres",
            choice_name(&format)
        );
        Ok(format)
    }

    /// Number of frames to be read, if known; `None` also if no progress is shown.
    fn length(&self, sequence: &Sequence) -> Option<usize> {
        if !stderr().is_terminal() {
            return None;
        }
        let whole = || sequence.source.length(self.recording.ffmpeg_patience());
        let part = |length| self.recording.frames().map_or(length, |part| part.length_of(length));
        sequence.length.or_else(|| whole().map(part))
    }

    /// Returns the index and the first box of the target that the video is cropped to, if it is. Errors: there is no such target.
    fn cropped(&self, targets: &[Target]) -> Result<Option<(usize, BoundingBox)>> {
        let Some(wanted) = &self.crop else { return Ok(None) };
        let is_it = |target: &Target| wanted.is_none() || target.name == *wanted;
        // The page of `view` writes a name without spaces.
        let in_page = |name: &Option<String>| name.as_ref().map(|name| name.replace([' ', '.'], "_"));
        let is_alike = |target: &Target| in_page(&target.name) == in_page(wanted);
        let found = targets.iter().position(is_it).or_else(|| targets.iter().position(is_alike));
        let Some(at) = found else {
            let names: Vec<_> = targets.iter().filter_map(|target| target.name.as_deref()).collect();
            let expected =
                if names.is_empty() { "--crop alone, as no target has a name".to_owned() } else { names.join(", ") };
            bail!("--crop={}: there is no such target: expected {expected}", wanted.as_deref().unwrap_or_default());
        };
        Ok(targets[at].starts.first().and_then(|start| Some((at, start.1?))))
    }

    fn film(&self, out: &Path, sequence: &mut Sequence, cropped: Option<(usize, BoundingBox)>) -> Result<AnswersVideo> {
        let (patience, number) = (self.recording.ffmpeg_patience(), sequence.first);
        let sound = sequence.source.video().map(Path::to_owned);
        let is_cut = self.recording.frames().is_some_and(|part| part.last().is_some());
        let plan = Plan { sound, is_cut, number, patience };
        let marks = if self.draw.is_empty() { vec![Mark::Box, Mark::Name] } else { self.draw.clone() };
        let look = Look { marks, cropped };
        AnswersVideo::create(out, plan, sequence.truth.take().unwrap_or_default(), &self.ids, look)
    }
}

/// Errors: The format cannot name several targets.
fn check_names(format: Format, targets: usize) -> Result<()> {
    ensure!(
        targets <= 1 || format.has_names(),
        "--format {}: this format cannot name {targets} targets: expected csv, json, mot, coco or cvat",
        choice_name(&format)
    );
    Ok(())
}
