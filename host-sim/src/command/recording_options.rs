//! Options for opening a recording, shared by all commands that read one.

use super::session::Kept;
use super::tracker_options::Pair;
use super::whole;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use smr_files::output::complain;
use smr_recordings::{
    self, FFMPEG_PATIENCE, FrameNumber, FrameRange, Levels, OpenOptions, Resize, Sequence, Start, Target, is_live,
    recordings,
};
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Recording")]
pub struct RecordingOptions {
    /// The initial box in pixels: left, top, width, height [default: the box beside the recording]
    ///
    /// `X,Y,W,H@FRAME` is a box in a later frame. `track` and `report` take several targets, each with a name (--init car=150,100,40,48
    /// --init man=20,80,15,40@120), and further boxes of a target, at which the tracker locks again (--init car=170,90,40,48@300). From
    /// `gone@FRAME` on a target has no answers, up to its next box (--init car=gone@200).
    ///
    /// Without --init, `track` and the page of `report` follow the targets that `view` keeps beside the recording (SEQ.smr.json), with their
    /// names, and say so. Between two boxes that `view` joins by a line, `track` prints the boxes on it, and none where the target is hidden.
    #[arg(long, value_name = "[NAME=]X,Y,W,H[@FRAME]", allow_hyphen_values = true)]
    init: Vec<Start>,
    /// Treat the initial boxes, except those of a session, as including their right and bottom edges: one pixel wider and higher
    #[arg(long)]
    inclusive: bool,
    /// The frame size of a raw dump
    #[arg(long, value_name = "WxH")]
    size: Option<Pair>,
    /// Resize all frames to this size or fraction; boxes stay in pixels of the original size
    #[arg(long, value_name = "WxH|1/2")]
    resize: Option<Resize>,
    /// Use only these frames, for example 20..80, 20.. or ..80; the first is 1
    ///
    /// Frames keep their numbers. Damage in a recording is an error (a picture that is cut off, a dump that ends within a frame, any
    /// complaint of ffmpeg), except after the last of these frames. The initial box is the true box in the first of these frames.
    #[arg(long, value_name = "A..B")]
    frames: Option<FrameRange>,
    /// The frame of the first line of the ground truth; host-sim skips earlier frames
    #[arg(long, value_name = "FRAME")]
    truth_from: Option<FrameNumber>,
    /// Map these values of 16-bit pictures to black and white, for example 7600..8366 [default: 0..65535, the high byte]
    #[arg(long, value_name = "A..B")]
    levels: Option<Levels>,
    /// Stop with an error if ffmpeg reads or writes nothing for this many seconds [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = whole::<NonZeroU16>(1..=65535))]
    ffmpeg_timeout: Option<NonZeroU16>,
}

impl RecordingOptions {
    /// Frames to read; `None` for all.
    pub fn frames(&self) -> Option<FrameRange> {
        let Some(first) = self.truth_from else { return self.frames };
        Some(self.frames.map_or_else(|| FrameRange::from(first), |frames| frames.begun_at(first)))
    }

    /// Range of `--frames`, renumbered so that the first ground-truth box is in frame 1, as in other trackers' results.
    pub fn frames_of_truth(&self) -> Option<FrameRange> {
        self.frames.map(|frames| frames.counted_from(self.truth_from.map_or(1, FrameNumber::get)))
    }

    /// Timeout for an ffmpeg that neither reads nor writes.
    pub fn ffmpeg_patience(&self) -> Duration {
        self.ffmpeg_timeout.map_or(FFMPEG_PATIENCE, |seconds| Duration::from_secs(seconds.get().into()))
    }

    /// Opens the recording at `path`, for a command that tracks one target from the first frame on.
    pub fn open(&self, path: &Path) -> Result<Sequence> {
        let first = self.frames().map_or(1, |part| part.first());
        let one = self.init.len() <= 1 && self.init.iter().all(|start| start.frame.is_none_or(|frame| frame == first));
        ensure!(
            one,
            "--init: several targets and boxes in later frames are for `track` and the page of `report`: expected one box X,Y,W,H"
        );
        self.open_all(path, false, None).map(|(sequence, _)| sequence)
    }

    /// Errors: The boxes of `--init` contradict each other, or are before the first frame that is read.
    pub fn check_init(&self) -> Result<()> {
        Target::all(&self.init, self.frames().map_or(1, |part| part.first())).map(drop)
    }

    /// Returns the session of `view` whose boxes are followed: the one beside the recording, unless `--init` gives boxes.
    pub fn kept(&self, path: &Path) -> Result<Option<Kept>> {
        if self.init.is_empty() { Kept::beside(path) } else { Ok(None) }
    }

    /// Opens a recording, a live one only with `takes_live`. Returns the targets of `--init` or of the session; without
    /// either, the recording's own target.
    pub fn open_with_targets(
        &self,
        path: &Path,
        takes_live: bool,
        kept: Option<&Kept>,
    ) -> Result<(Sequence, Vec<Target>)> {
        let (sequence, targets) = self.open_all(path, takes_live, kept)?;
        if let Some(resize) = self.resize {
            let mut boxes =
                targets.iter().flat_map(|target| &target.starts).filter_map(|(_, bbox)| *bbox).chain(sequence.init);
            ensure!(
                boxes.all(|bbox| bbox.width.min(bbox.height) >= 0.5),
                "--resize {resize} makes an initial box smaller than a pixel: expected larger frames"
            );
        }
        if !targets.is_empty() {
            return Ok((sequence, targets));
        }
        // If the recording has no initial box, this fails with an error that explains how to give one.
        sequence.start()?;
        let starts = vec![(sequence.first, sequence.init)];
        Ok((sequence, vec![Target::new(None, starts)]))
    }

    /// Opens the recording. Returns it with the targets of `--init` or of the session only.
    fn open_all(&self, path: &Path, takes_live: bool, kept: Option<&Kept>) -> Result<(Sequence, Vec<Target>)> {
        let options = OpenOptions {
            size: self.size.map(|Pair(width, height)| (width, height)),
            levels: self.levels,
            init: None,
            ffmpeg_patience: Some(self.ffmpeg_patience()),
            takes_live,
        };
        ensure!(
            !takes_live || !is_live(path) || self.frames().is_none(),
            "--frames is for recordings: a live source is followed until Ctrl-C"
        );
        let mut sequence = smr_recordings::open(path, &options)?;
        sequence.notes.iter().for_each(|note| complain(&format!("note: {}: {note}", sequence.name)));
        let mut truth_from = 1;
        if let Some(first) = self.truth_from.map(FrameNumber::get) {
            let name = &sequence.name;
            let has_truth = sequence.truth.is_some();
            ensure!(has_truth, "{name}: --truth-from {first}: there is no ground truth beside the recording");
            let is_later = |part: FrameRange| part.first() >= first && part.last().is_none_or(|last| last >= first);
            let fits = self.frames().is_none_or(is_later);
            ensure!(fits, "{name}: --frames reaches before the ground truth: expected frame {first} or later");
            truth_from = first;
        } else if let Some((part, boxes)) = self.frames.zip(sequence.truth.as_ref().map(Vec::len))
            // If the range starts at frame 1, the ground truth needs no shift, so the slow count of frames is skipped.
            && part.first() != 1
            && part.length_of(usize::MAX) >= boxes
            && let length = self.length(path, &options, &sequence)
            && length != Some(boxes)
            && part.length_of(length.or(part.last()).unwrap_or(0)) == boxes
        {
            let (name, first, last) = (&sequence.name, part.first(), part.first() + boxes - 1);
            complain(&format!(
                "note: {name}: the {boxes} boxes of the ground truth are taken for frames {first} to {last}"
            ));
            truth_from = first;
        }
        if let Some(part) = self.frames() {
            let option = self.frames.map_or("--truth-from".to_owned(), |frames| format!("--frames {frames}"));
            if let Some(length) = sequence.length.filter(|&length| part.first() > length) {
                bail!("{}: there is no frame {} ({option}): expected 1 to {length}", sequence.name, part.first());
            }
            sequence = sequence.part(part, truth_from, &option);
        }
        let mut targets = self.targets(&sequence, kept)?;
        if let Some(target) = targets.first() {
            sequence.init = target.starts[0].1;
        }
        // Boxes of a session are drawn to the pixel.
        if self.inclusive && kept.is_none() {
            for bbox in targets.iter_mut().flat_map(Target::boxes_mut).chain(&mut sequence.init) {
                (bbox.width, bbox.height) = (bbox.width + 1.0, bbox.height + 1.0);
            }
        }
        if let Some(resize) = self.resize {
            sequence = sequence.resized(resize)?;
            for bbox in targets.iter_mut().flat_map(Target::boxes_mut) {
                *bbox = bbox.scaled(sequence.scale);
            }
        }
        Ok((sequence, targets))
    }

    /// Targets of `--init`, or else of the session.
    fn targets(&self, sequence: &Sequence, kept: Option<&Kept>) -> Result<Vec<Target>> {
        let Sequence { name, first, length, .. } = sequence;
        let targets = match kept {
            None => Target::all(&self.init, *first)?,
            Some(kept) => {
                let last = self.frames().and_then(|part| part.last()).unwrap_or(usize::MAX);
                kept.targets(*first, last).with_context(|| name.clone())?
            }
        };
        let option = kept.map_or("--init", |kept| &kept.file);
        Target::check_frames(&targets, *first, *length, option).with_context(|| name.clone())?;
        Ok(targets)
    }

    /// Number of frames; `None` if unknown. For a video, the function may have to count packets or else decoded frames.
    fn length(&self, path: &Path, options: &OpenOptions, sequence: &Sequence) -> Option<usize> {
        let packets = || sequence.source.length(self.ffmpeg_patience());
        let decoded =
            || Some(smr_recordings::open(sequence.source.video().map(|_| path)?, options).ok()?.frames.count());
        sequence.length.or_else(packets).or_else(decoded)
    }

    /// True if no option changes the initial box or the frames.
    pub fn says_nothing_of_start(&self) -> bool {
        !self.changes_start() && self.frames().is_none() && self.resize.is_none()
    }

    pub fn changes_start(&self) -> bool {
        !self.init.is_empty() || self.inclusive
    }

    /// Finds the recordings at and in `paths`. Errors: There is none, or `--init` is given for several recordings.
    pub fn find(&self, paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
        let found = recordings(paths)?;
        self.check_for(found.len())?;
        Ok(found)
    }

    /// Errors: `--init` is given for several recordings.
    pub fn check_for(&self, recordings: usize) -> Result<()> {
        ensure!(
            self.init.is_empty() || recordings <= 1,
            "--init is the box of one recording, and there are {recordings}: expected one recording with it"
        );
        Ok(())
    }
}
