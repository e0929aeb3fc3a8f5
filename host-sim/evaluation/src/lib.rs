//! Evaluation tells how well a tracker does: methods are run over recordings and scored against ground truth.
//!
//! Methods are the trackers of smr-core and the baselines beside them ([`MethodKind`]); a [`Variant`] is one with its settings. A [`Follower`]
//! follows a target frame by frame; a [`Run`] is the record of that, and all figures are made from it: [`evaluate`] scores by the protocols of
//! the paper, OTB and VOT, also what other trackers answered; [`robustness`] starts anywhere; [`faults`] and [`covered`] put something
//! between. Results are [`Tables`] for programs, and text for people.

mod baseline;
mod configs;
pub mod covered;
pub mod faults;
mod layout;
mod means;
mod method;
mod otb;
pub mod published;
mod refused;
mod result_file;
mod results;
pub mod robustness;
mod run;
mod score;
mod tables;
mod trackers;
mod vot;

pub use configs::{Configs, Origin, Variant};
pub use layout::Layout;
pub use layout::aligned;
pub use layout::{NOTHING, cell, header};
pub use method::{CoreKind, Evidence, Method, MethodKind, Report, name_of};
pub use otb::{Curves, FARTHEST, NEAR, Otb, STEPS, centre_errors};
pub use refused::Refused;
pub use result_file::{ResultFile, result_files};
pub use results::Results;
pub use run::{Follower, Run, lock};
pub use score::{CORRECT, Score, Trajectory, overlaps};
pub use tables::{TableName, Tables};
pub use vot::Vot;

use anyhow::{Context, Error, Result, anyhow, ensure};
use smr_recordings::{Frame, Sequence, cleanup, misfit};
use std::path::PathBuf;

/// The most pixels of a template: as many as the 32 bits of a score can sum, for example 256x256.
pub const MOST_PIXELS: usize = 65536;

/// The most offsets of a window on an axis: the whole of a frame of up to about 4000x4000 pixels.
pub const MOST_OFFSETS: usize = 4096;

/// A target of the paper's tracker as it is followed here, as large as it can be.
pub type Paper = smr_core::Paper<MOST_PIXELS, MOST_OFFSETS>;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contestant {
    /// As it stands in tables and in JSON.
    pub name: String,
    /// What a method was run with here; `None` of another tracker's result file.
    pub origin: Option<Origin>,
}

impl Contestant {
    pub fn of(variant: &Variant) -> Self {
        Self { name: variant.name.clone(), origin: Some(variant.origin()) }
    }

    pub const fn file(name: String) -> Self {
        Self { name, origin: None }
    }
}

/// One sequence, and how well everyone did on it.
pub struct Evaluation {
    pub sequence: String,
    /// Frames in which the target is visible.
    pub visible: usize,
    pub scores: Vec<(Contestant, Score)>,
    /// Why some have no score.
    pub failures: Vec<Error>,
    pub notes: Vec<String>,
}

/// Runs `variants` over the sequence, and scores `files`, other trackers' results on it, too.
///
/// One thread; each frame is decoded once and dropped when all methods have seen it. `progress` is called after each.
/// Errors: No ground truth or one of another length, no box to start from, or a frame that cannot be read. What fails for one
/// contestant only is one of [`Evaluation::failures`].
pub fn evaluate(
    sequence: Sequence,
    variants: &[Variant],
    files: &[PathBuf],
    progress: impl Fn(),
) -> Result<Evaluation> {
    let start = sequence.start();
    let Sequence { name, frames, truth, .. } = sequence;
    let truth = truth_of(&name, truth)?;
    let start = start?;
    let follower = |variant: &Variant| Ok(Follower::new(variant.build()?, vec![(1, variant.start(start))]));
    let followers: Result<Vec<_>> = variants.iter().map(follower).collect();
    let mut count = 0;
    let runs = follow(frames.inspect(|_| count += 1), followers?, progress)?;
    let boxes = truth.len();
    misfit(count, boxes).map_or(Ok(()), |misfit| Err(anyhow!("{name}: {misfit}")))?;

    let visible = truth.iter().flatten().count();
    let mut evaluation =
        Evaluation { sequence: name.clone(), visible, scores: vec![], failures: vec![], notes: vec![] };
    for (variant, run) in variants.iter().zip(runs) {
        let score = run.and_then(|run| Score::of(&run.reports, &truth));
        let score = score.with_context(|| format!("{name}: {}", variant.name));
        evaluation.add(Contestant::of(variant), score);
    }
    for path in files {
        let score = ResultFile::read(path, None, boxes).and_then(|file| {
            evaluation.notes.extend(file.note.clone());
            file.score(&truth)
        });
        evaluation.add(Contestant::file(result_file::name(path)), score);
    }
    Ok(evaluation)
}

/// The ground truth of the sequence called `name`, without which nothing can be measured.
pub fn truth_of<T>(name: &str, truth: Option<T>) -> Result<T> {
    truth.with_context(|| format!("{name}: no ground truth beside it: expected gt.txt, groundtruth_rect.txt or groundtruth.txt (`track` needs none)"))
}

impl Evaluation {
    fn add(&mut self, contestant: Contestant, score: Result<Score>) {
        match score {
            Ok(score) => self.scores.push((contestant, score)),
            Err(error) => self.failures.push(error),
        }
    }
}

/// The record of each run. One that fails is not asked again; the others go on.
fn follow(
    frames: impl Iterator<Item = Result<Frame>>,
    followers: Vec<Follower>,
    progress: impl Fn(),
) -> Result<Vec<Result<Run>>> {
    let mut runs: Vec<_> = followers.into_iter().map(|follower| (follower, Ok(Run::default()))).collect();
    for (place, frame) in frames.enumerate() {
        let frame = frame?;
        ensure!(!cleanup::is_stopped(), "it was stopped");
        for (follower, run) in &mut runs {
            if let Ok(record) = run
                && let Err(error) = record.add(follower, place, &frame.gray)
            {
                *run = Err(error);
            }
        }
        progress();
    }
    Ok(runs.into_iter().map(|(_, run)| run).collect())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use anyhow::bail;
    use smr_core::paper::Config;
    use smr_recordings::{BoundingBox, GrayFrame};
    use std::cell::Cell;
    use std::fs;

    const METHODS: [MethodKind; 2] = [MethodKind::Sad, MethodKind::Smr];

    /// Four frames of a target that moves by two pixels a frame, and nothing beside them.
    pub fn sequence() -> Sequence {
        let frame = |left: usize| {
            let texture = |x: usize, y: usize| u8::try_from(100 + (x * 31 + y * 17) % 97).unwrap();
            let inside = |x: usize, y: usize| (left..left + 5).contains(&x) && (6..10).contains(&y);
            let pixel = |x: usize, y: usize| if inside(x, y) { texture(x - left, y) } else { 10 };
            let pixels = (0..20).flat_map(|y| (0..24).map(move |x| pixel(x, y))).collect();
            GrayFrame { width: 24, height: 20, pixels }
        };
        let at = |x: f64| BoundingBox { x, y: 6.0, width: 5.0, height: 4.0 };
        let truth = [4.0, 6.0, 8.0, 10.0].map(|x| Some(at(x))).to_vec();
        Sequence::made("moving", [4, 6, 8, 10].map(frame).into_iter(), truth)
    }

    fn variants() -> [Variant; 2] {
        METHODS.map(|kind| Variant::new(kind, &Config::paper().into()))
    }

    fn evaluated(sequence: Sequence, files: &[PathBuf]) -> Result<Evaluation> {
        evaluate(sequence, &variants(), files, || ())
    }

    #[test]
    fn all_methods_see_all_frames() {
        let frames = Cell::new(0);
        let progress = || frames.set(frames.get() + 1);
        let evaluation = evaluate(sequence(), &variants(), &[], progress).unwrap();
        assert_eq!(frames.get(), 4);
        assert_eq!(evaluation.visible, 4);
        assert!(evaluation.failures.is_empty());
        let correct = |(who, score): &(Contestant, Score)| (who.clone(), score.correct, score.correct_50);
        let methods = variants().map(|variant| (Contestant::of(&variant), 4, 4));
        assert_eq!(evaluation.scores.iter().map(correct).collect::<Vec<_>>(), methods);
    }

    #[test]
    fn what_is_missing_is_named() {
        let error = |sequence| format!("{:#}", evaluated(sequence, &[]).err().unwrap());
        assert!(error(Sequence { truth: None, ..sequence() }).contains("moving: no ground truth"));
        let short = sequence().truth.map(|truth| truth[..3].to_vec());
        let lengths = "moving: there are 4 frames, but the ground truth has 3 boxes for them: say which";
        assert!(error(Sequence { truth: short, ..sequence() }).starts_with(lengths));
        assert!(error(Sequence { init: None, ..sequence() }).contains("no box to start from"));
        let tiny = BoundingBox { x: 1.0, y: 1.0, width: 0.3, height: 5.0 };
        assert!(error(Sequence { init: Some(tiny), ..sequence() }).contains("no pixels: 1,1,0.3,5"));
        let frames = sequence().frames.take(2).chain(std::iter::once_with(|| bail!("frame 3 is bad")));
        assert_eq!(error(Sequence { frames: Box::new(frames), ..sequence() }), "frame 3 is bad");
    }

    #[test]
    fn one_contestant_fails_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bad.txt");
        fs::write(&file, "1,2,three,4\n").unwrap();
        let evaluation = evaluated(sequence(), &[file]).unwrap();
        assert_eq!(evaluation.scores.len(), METHODS.len());
        assert_eq!(evaluation.failures.len(), 1);
        assert!(format!("{:#}", evaluation.failures[0]).contains("bad.txt: line 1"));

        let mut frames: Vec<_> = sequence().frames.collect();
        frames[2].as_mut().unwrap().gray = GrayFrame { width: 24, height: 19, pixels: vec![0; 24 * 19] };
        let evaluation = evaluated(Sequence { frames: Box::new(frames.into_iter()), ..sequence() }, &[]).unwrap();
        let failures: Vec<String> = evaluation.failures.iter().map(|error| format!("{error:#}")).collect();
        let reason = smr_core::UpdateError::FrameSizeChanged;
        assert_eq!(failures, ["sad", "smr"].map(|name| format!("moving: {name}: frame 3: {reason}")));
    }

    #[test]
    fn result_files_of_others() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(result_files(folder.path()).unwrap(), Vec::<PathBuf>::new());
        let trackers = folder.path().join("trackers");
        fs::create_dir(&trackers).unwrap();
        let (early, late) = (trackers.join("t2.txt"), trackers.join("t10.txt"));
        fs::write(&early, "4,6,9,10\nNaN,NaN,NaN,NaN\n8,6,13,10\n").unwrap();
        fs::write(&late, "4,6,9,10\n6,6,11,10\n8,6,13,10\n0,0,5,4\n0,0,5,4\n").unwrap();
        fs::write(trackers.join("notes.md"), "no result").unwrap();

        let files = result_files(folder.path()).unwrap();
        assert_eq!(files, [early, late]);
        assert_eq!(result_files(&folder.path().join("frames.y4m")).unwrap(), files);
        let evaluation = evaluate(sequence(), &[], &files, || ()).unwrap();
        let figures = |(who, score): &(Contestant, Score)| (who.name.clone(), score.answered, score.correct);
        let expected = [("t2".to_owned(), 2, 2), ("t10".to_owned(), 4, 3)];
        assert_eq!(evaluation.scores.iter().map(figures).collect::<Vec<_>>(), expected);
        assert_eq!(evaluation.notes.len(), 2);
        assert!(evaluation.notes[1].starts_with("5 boxes for 4 frames"));
    }
}
