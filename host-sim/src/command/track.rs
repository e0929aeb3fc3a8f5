//! `host-sim track`: prints the target's box in every frame.

mod lines;
mod pass;

use self::lines::Lines;
use self::pass::Pass;
use super::Outcome;
use super::events::Events;
use super::paths::{Places, Taken, listed};
use super::progress::{self, Bar};
use super::recording_options::RecordingOptions;
use super::session::Kept;
use super::tracker_options::TrackerOptions;
use super::video::{AnswersVideo, Look, Mark};
use anyhow::{Context, Error, Result, bail, ensure};
use smr_evaluation::{Follower, MethodKind, Variant};
use smr_files::messages::choice_name;
use smr_files::output::{Output, complain};
use smr_files::signals;
use smr_pages::export::boxes::{About, Format, Printer};
use smr_pages::export::{FILM_ENDINGS, PixelsPerMetre, Plan};
use smr_recordings::{BoundingBox, Sequence, Target, misfit};
use std::io::{IsTerminal, stderr, stdout};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Track {
    /// The recording, or a live source: `-` (Y4M from standard input, each frame answered at once), an address for ffmpeg (rtsp://...), or
    /// /dev/video0 on Linux; Ctrl-C ends it
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// The tracker, or a simpler method for comparison [default: that of --config, else robust]
    #[arg(long, value_enum)]
    method: Option<MethodKind>,
    /// The format of the printed boxes [default: tld; csv for several targets or with --pixels-per-metre]
    ///
    /// Formats for several targets: csv, json, mot, coco, cvat. coco and cvat files are valid only after the last frame.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Print one JSON object for each frame: --format json
    ///
    /// Its keys: version, method, options (only those given), target (if it has a name), frame (as the recording counts), state, box (whole
    /// pixels), fine (with fractions), confidence, ratio, runner_up_ratio, alpha, identity, scale, found_again, work and quality. A value that the
    /// method does not compute is null, and so are both boxes while the target is lost.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// Write to FILE instead of standard output; an error leaves no file
    ///
    /// Without --format the extension selects the format: .csv, .json, .jsonl or .xml (cvat). Files that end in .txt or have no extension
    /// accept every format. -o boxes.mp4 is the same as --video boxes.mp4: the boxes are then printed.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Also draw the boxes over the frames: .mp4, .mov, .mkv or .webm (they need ffmpeg), or a new folder for PNG pictures
    ///
    /// Each target's box has the target's color in `view`, and is dashed while the target is uncertain, leaving or, at its last position,
    /// lost. Ground truth is green. The text in the picture is the frame number and, of a single target, the state and the confidence in
    /// hundredths; names and states of several targets stand at their boxes; □ stands for letters that are not Latin, Greek, Cyrillic, Armenian or Georgian. The video keeps the recording's colors and, if the recording is a video,
    /// frame times and sound. On a terminal host-sim prints only when a target is lost or found. If the reader of the printed boxes ends
    /// (`| head`), host-sim still finishes the video.
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
    /// camera as what was measured. Like --init, it is in pixels of the original size if --resize is given.
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

    pub fn run(self) -> Result<Outcome> {
        let (boxes, films) = self.outputs();
        let places = Places::of([&self.sequence]).writes("--out", boxes, Some(BOXES));
        films.iter().fold(places, |places, (option, film)| places.writes(option, Some(film), Some(FILM))).check()?;
        let method = self.method.or_else(|| self.tracker.method());
        let variant = self.tracker.variant(method.unwrap_or(MethodKind::Robust))?;
        let kept = self.recording.kept(&self.sequence)?;
        let variant = self.of_session(kept.as_ref())?.unwrap_or(variant);
        let (mut sequence, targets) = self.recording.open_with_targets(&self.sequence, true, kept.as_ref())?;
        let cropped = self.cropped(&targets)?;
        let targets = Follower::all(targets, &variant).with_context(|| sequence.name.clone())?;
        let format = self.format(targets.len())?;
        let about = About {
            name: sequence.name.clone(),
            origin: variant.origin(),
            targets: targets.iter().map(|target| target.name.clone()).collect(),
            images: sequence.source.image_names(),
            pixels_per_metre: self.pixels_per_metre.map(|metre| metre.resized(sequence.scale)),
        };
        let printer = Printer::new(format, about);
        ensure!(films.len() < 2, "--out and --video both name a video: expected one of them");
        let film = films.first().map(|&(_, film)| film);
        ensure!(
            film.is_some() || (self.draw.is_empty() && self.crop.is_none()),
            "--draw and --crop are of a video: expected --video FILE, too"
        );
        ensure!(
            self.draw.len() < 2 || !self.draw.contains(&Mark::Nothing),
            "--draw nothing stands alone: expected no other mark"
        );
        // With a video, a terminal shows only events, because lines of numbers would hide the events.
        let events = (film.is_some() && boxes.is_none() && stdout().is_terminal()).then(|| Events::new(targets.len()));
        let mut lines = match boxes {
            _ if events.is_some() => Lines::Unread,
            None => Lines::Printed { goes_on: film.is_some() },
            Some(file) => Lines::File(Output::create(file)?),
        };
        let live = sequence.source.live();
        if live.is_some() {
            // Ctrl-C is the usual end of a live source, so it must not lose the results.
            signals::stop_first();
        }
        let bar = self.bar(&sequence, film, events.is_some() || boxes.is_some() || !stdout().is_terminal());
        let (length, truth) = (sequence.length, sequence.truth.as_ref().map(Vec::len));
        let misfit = |frames| truth.and_then(|boxes| misfit(frames, boxes));
        if let Some(misfit) = length.and_then(misfit) {
            complain(&format!("warning: {}: {misfit}", sequence.name));
        }
        let film =
            film.map(|out| Ok::<_, Error>((out.clone(), self.film(out, &mut sequence, cropped)?))).transpose()?;
        let sequence = if film.is_some() { sequence.in_color(self.recording.ffmpeg_patience()) } else { sequence };
        lines.write(&printer.head())?;
        let last = sequence.first - 1;
        let boxes_of = kept.map_or_else(|| "--init".to_owned(), |kept| kept.file);
        let mut pass = Pass {
            name: sequence.name,
            boxes_of,
            targets,
            printer,
            lines,
            events,
            film,
            bar,
            live,
            drops: false,
            last,
        };
        for frame in sequence.frames {
            pass.frame(frame?)?;
        }
        if let Some(misfit) = misfit(pass.last + 1 - sequence.first).filter(|_| length.is_none()) {
            pass.warn(&misfit);
        }
        pass.finish(sequence.first)?;
        Ok(Outcome::Holds)
    }

    /// Method and options of the session, if the command line has neither.
    fn of_session(&self, kept: Option<&Kept>) -> Result<Option<Variant>> {
        let is_given = self.method.is_some() || !self.tracker.says_nothing();
        let Some(kept) = kept.filter(|_| !is_given) else { return Ok(None) };
        let variant = kept.variant()?;
        if let Some(note) = kept.note_of_method() {
            complain(&note);
        }
        Ok(Some(variant))
    }

    /// Errors: The format cannot name several targets, or the extension of the output file belongs to another format.
    fn format(&self, targets: usize) -> Result<Format> {
        let usual = if targets > 1 || self.pixels_per_metre.is_some() { Format::Csv } else { Format::Tld };
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
        ensure!(
            targets <= 1 || format.has_names(),
            "--format {}: this format cannot name {targets} targets: expected csv, json, mot, coco or cvat",
            choice_name(&format)
        );
        Ok(format)
    }

    /// Creates the progress bar. `is_shown` is false if printed lines on the same terminal show the progress.
    fn bar(&self, sequence: &Sequence, film: Option<&PathBuf>, is_shown: bool) -> Bar {
        if !is_shown || !stderr().is_terminal() {
            return Bar::hidden();
        }
        let whole = || sequence.source.length(self.recording.ffmpeg_patience());
        let part = |length| self.recording.frames().map_or(length, |part| part.length_of(length));
        let name = film.map_or_else(|| sequence.name.clone(), |film| film.display().to_string());
        progress::bar(&name, sequence.length.or_else(|| whole().map(part)))
    }

    /// Returns the index and the first box of the target that the video is cropped to, if it is. Errors: there is no such target.
    fn cropped(&self, targets: &[Target]) -> Result<Option<(usize, BoundingBox)>> {
        let Some(wanted) = &self.crop else { return Ok(None) };
        let is_it = |target: &Target| wanted.is_none() || target.name == *wanted;
        let Some(at) = targets.iter().position(is_it) else {
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
