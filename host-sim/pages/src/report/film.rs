//! Runs tracking methods through a recording. The result, a film, has their answers in every frame and some images.

use super::observation::{self, Observation, ObservedTracker};
use super::player_frames::Images;
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use smr_core::{Rect, State};
use smr_evaluation::{
    CORRECT, Contestant, Evaluation, Follower, MethodAnswer, MethodKind, Refused, ResultFile, Score, Variant, lock,
    overlaps,
};
use smr_recordings::{BoundingBox, FFMPEG_PATIENCE, Frame, FrameRange, GrayFrame, Sequence, Target};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Minimum number of wrong frames in a row after which a method counts as having left the target.
const MIN_FAILURE_FRAMES: usize = 10;

pub struct FilmedRecording {
    pub name: String,
    /// Methods that ran. With several targets there is one entry per target and method, named after both.
    pub methods: Vec<Variant>,
    /// For each entry of `methods`, the index of its target in `targets`.
    pub(super) method_targets: Vec<usize>,
    pub(super) size: (u16, u16),
    pub(super) targets: Vec<Locked>,
    pub(super) padding: u16,
    pub moments: Vec<Moment>,
    /// Times of a video's frames in seconds, as far as they are known.
    pub(super) times: Vec<Option<f64>>,
    pub(super) stills: Vec<Still>,
    pub(super) truth: Option<Vec<Option<BoundingBox>>>,
    pub(super) images: Option<Images>,
    pub(super) files: Vec<ResultFile>,
    /// For each entry of `files`, the index of its name among the page's distinct file names. It selects the color.
    pub(super) file_name_indices: Vec<usize>,
    pub(super) first: usize,
    /// Remarks for the reader: methods that were left out, and why.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Locked {
    /// Name of the target; `None` for a single target without a name.
    pub name: Option<String>,
    /// (frame index, box to lock on) in order. With `None`, the target is gone from this frame on, until its next box.
    pub starts: Vec<(usize, Option<Rect>)>,
}

impl Locked {
    fn new(target: Target, first: usize) -> Result<Self> {
        let starts = target.rects()?.into_iter().map(|(frame, rect)| (frame - first, rect)).collect();
        Ok(Self { name: target.name, starts })
    }

    pub fn start(&self) -> Rect {
        self.starts[0].1.unwrap_or_default()
    }

    /// Returns false before the target's first box, and while the target is gone.
    pub fn is_there(&self, index: usize) -> bool {
        self.starts.iter().rfind(|(at, _)| *at <= index).is_some_and(|(_, bbox)| bbox.is_some())
    }
}

struct Pair {
    follower: Follower<ObservedTracker>,
    variant: Variant,
    target: usize,
}

/// Reaction to a method, other than the first, that refuses the start box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    Fails,
    /// The method is left out of the film, with a note for the reader.
    LeftOut,
}

pub struct Moment {
    /// One report for each method. A report is *lost* before its target's first box, and while its target is gone.
    pub reports: Vec<MethodAnswer>,
    /// Box to draw for each method. If the target is lost: the last accepted box, or one found but not confirmed.
    pub(super) lasts: Vec<BoundingBox>,
}

pub(super) struct Still {
    /// Frame index, from 0.
    pub index: usize,
    pub frame: GrayFrame,
    pub observations: Vec<Observation>,
}

/// Settings of a run through a recording.
pub struct Watch<'a> {
    pub methods: &'a [Variant],
    /// Targets to follow, each with every method; if empty, the sequence's start box.
    pub targets: Vec<Target>,
    pub refusal: Refusal,
    /// Frames to keep, as indices from 0.
    pub stills: BTreeSet<usize>,
    /// Largest size in bytes of the small images that are kept, of all frames or every 2nd, 4th, ...; `None`: no images.
    pub budget: Option<usize>,
}

impl<'a> Watch<'a> {
    /// Watches the sequence's start box, and keeps no frame.
    pub fn new(methods: &'a [Variant]) -> Self {
        Self { methods, targets: Vec::new(), refusal: Refusal::Fails, stills: BTreeSet::new(), budget: None }
    }
}

/// Runs all methods on all targets of the sequence. `progress` is called after each frame. A film of several targets
/// has no ground truth. Errors: No method, no initial box, a frame that cannot be read or tracked, or a still or a box
/// in a frame that does not exist.
pub fn watch(sequence: Sequence, what: Watch<'_>, progress: impl Fn()) -> Result<FilmedRecording> {
    let Watch { methods, mut targets, refusal, stills, budget } = what;
    ensure!(!methods.is_empty(), "there is no method to show");
    if targets.is_empty() {
        targets.push(Target::new(None, vec![(sequence.first, Some(sequence.start()?.into()))]));
    }
    let Sequence { name, frames, truth, first, .. } = sequence.in_color(FFMPEG_PATIENCE);
    let locked = |target| Locked::new(target, first).with_context(|| name.clone());
    let targets: Vec<Locked> = targets.into_iter().map(locked).collect::<Result<_>>()?;
    let boxes = targets.iter().flat_map(|target| &target.starts).map(|(index, _)| *index);
    let last = stills.last().copied().into_iter().chain(boxes).max();
    let mut pairs = pairs(&targets, methods, first)?;
    let mut notes = Vec::new();
    let (mut kept, mut moments, mut size) = (Vec::new(), Vec::<Moment>::new(), (0, 0));
    let mut times = Vec::new();
    let mut images = budget.map(Images::new);
    for (index, frame) in frames.enumerate() {
        let Frame { gray: frame, color, moment, .. } = frame?;
        if index == 0 && refusal == Refusal::LeftOut {
            notes = leave_out(&mut pairs, &frame, &targets, methods[0].kind);
        }
        let look = |Pair { follower, variant, target }: &mut Pair| {
            let report = follower.step(index + first, &frame);
            let report = report.with_context(|| format!("{name}: {}", variant.name))?;
            let begun = report.zip(follower.method.observation.take());
            Ok(begun.unwrap_or_else(|| observation::not_begun(targets[*target].start())))
        };
        let looks: Result<Vec<(MethodAnswer, Observation)>> = pairs.iter_mut().map(look).collect();
        let (reports, observations): (Vec<MethodAnswer>, Vec<Observation>) = looks?.into_iter().unzip();
        size = (frame.width, frame.height);
        moments.push(Moment { reports, lasts: observations.iter().map(|observation| observation.bbox).collect() });
        times.push(moment.map(|moment| moment.seconds()));
        if let Some((images, color)) = images.as_mut().zip(color) {
            images.offer(index, &color, &observations)?;
        }
        if stills.contains(&index) {
            kept.push(Still { index, frame, observations });
        }
        progress();
    }
    let length = moments.len();
    if let Some(last) = last {
        let (number, end) = (last + first, length + first - 1);
        ensure!(last < length, "{name}: there is no frame {number}: expected {first} to {end}");
    }
    let padding = methods[0].configs.paper.padding;
    let truth = truth.filter(|_| targets.len() == 1);
    Ok(FilmedRecording {
        name,
        method_targets: pairs.iter().map(|pair| pair.target).collect(),
        methods: pairs.into_iter().map(|pair| pair.variant).collect(),
        size,
        targets,
        padding,
        moments,
        times,
        stills: kept,
        truth,
        images,
        files: Vec::new(),
        file_name_indices: Vec::new(),
        first,
        notes,
    })
}

fn pairs(targets: &[Locked], methods: &[Variant], first: usize) -> Result<Vec<Pair>> {
    let all = targets.iter().enumerate().flat_map(|target| methods.iter().map(move |method| (target, method)));
    let pair = |((target, locked), method): ((usize, &Locked), &Variant)| {
        let mut variant = method.clone();
        if let Some(name) = &locked.name {
            variant.name = format!("{name}, {}", method.name);
        }
        let starts = locked.starts.iter().map(|&(index, start)| (index + first, start)).collect();
        Ok(Pair { follower: Follower::new(Box::new(ObservedTracker::new(method)?), starts), variant, target })
    };
    all.map(pair).collect()
}

/// Removes the methods, except `first`, that refuse their start box. Returns a note with the reason for each.
fn leave_out(pairs: &mut Vec<Pair>, frame: &GrayFrame, targets: &[Locked], first: MethodKind) -> Vec<String> {
    let mut notes = Vec::new();
    pairs.retain_mut(|Pair { follower, variant, target }| {
        if variant.kind == first {
            return true;
        }
        let start = targets[*target].start();
        let Err(error) = lock(follower.method.as_mut(), &frame.frame(), start) else { return true };
        let refused = error.downcast_ref::<Refused>();
        notes.extend(refused.map(|refused| format!("{} is left out: {refused}", variant.name)));
        refused.is_none()
    });
    notes
}

impl FilmedRecording {
    /// Returns as JSON the count of the player's images and their longest side in pixels; `None` without images.
    pub fn images(&self) -> Option<Value> {
        let images = self.images.as_ref()?;
        Some(json!({ "frames": images.kept.len(), "longest_side": images.side() }))
    }

    /// Adds result files of other trackers. They cover the whole recording; `part` is the range that the film covers.
    pub fn compare(&mut self, files: &[PathBuf], part: Option<FrameRange>) -> Result<()> {
        for path in files {
            self.files.push(ResultFile::read(path, part, self.moments.len())?);
        }
        Ok(())
    }

    /// Scores all methods and result files; `None` without ground truth. Errors: Ground truth not as long as the film.
    pub fn evaluation(&self) -> Result<Option<Evaluation>> {
        let Some(truth) = &self.truth else { return Ok(None) };
        let score = |(index, variant): (usize, &Variant)| {
            let reports: Vec<MethodAnswer> = self.moments.iter().map(|moment| moment.reports[index]).collect();
            let score = Score::of(&reports, truth).with_context(|| self.name.clone())?;
            anyhow::Ok((Contestant::of(variant), score))
        };
        let mut scores = self.methods.iter().enumerate().map(score).collect::<Result<Vec<_>>>()?;
        for file in &self.files {
            let score = file.score(truth).with_context(|| self.name.clone())?;
            scores.push((Contestant::file(file.name.clone()), score));
        }
        let visible = truth.iter().flatten().count();
        Ok(Some(Evaluation { sequence: self.name.clone(), visible, scores, failures: vec![], notes: vec![] }))
    }

    /// True if the method's target is present in frame `index`: its first box was given, and it is not gone.
    pub(super) fn has(&self, method: usize, index: usize) -> bool {
        self.targets[self.method_targets[method]].is_there(index)
    }

    /// Returns the pixels of padding to show around the frame, limited because a wide padding leaves little space.
    pub(super) fn margin(&self) -> u16 {
        self.padding.min(self.size.0.max(self.size.1) / 4)
    }

    /// Returns the largest distance in pixels by which a box reaches over the border of the frame.
    pub(super) fn overhang(&self) -> u16 {
        let over = |bbox: BoundingBox| {
            let (right, below) = (bbox.x + bbox.width, bbox.y + bbox.height);
            (-bbox.x).max(-bbox.y).max(right - f64::from(self.size.0)).max(below - f64::from(self.size.1))
        };
        let boxes = self.moments.iter().flat_map(|moment| &moment.reports).filter_map(|report| report.target);
        let farthest = boxes.map(over).fold(0.0, f64::max).ceil();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // not negative; a larger one is cut off
        let overhang = farthest as u16;
        overhang
    }

    /// Formats the time of a frame as 0:12.4 or 1:02:03.4.
    pub(super) fn clock(&self, index: usize) -> Option<String> {
        let tenths = (self.times[index]?.max(0.0) * 10.0).round();
        let (seconds, minutes) = (tenths / 10.0 % 60.0, (tenths / 600.0).floor());
        let (minutes, hours) = (minutes % 60.0, (minutes / 60.0).floor());
        Some(if hours > 0.0 {
            format!("{hours}:{minutes:02}:{seconds:04.1}")
        } else {
            format!("{minutes}:{seconds:04.1}")
        })
    }

    pub(super) fn trajectory(&self, method: usize) -> Vec<Option<BoundingBox>> {
        self.moments.iter().map(|moment| moment.reports[method].target).collect()
    }

    /// Returns the first frame of the longest run of frames in which `other` is wrong and `best` correct, and true if
    /// `other` is *lost* in most of the run. Frames that hide the target do not end a run. `None` if the run is shorter
    /// than `MIN_FAILURE_FRAMES`, or without ground truth. Errors: Ground truth of another length than the film.
    pub(super) fn longest_failure(&self, best: usize, other: usize) -> Result<Option<(usize, bool)>> {
        let Some(truth) = &self.truth else { return Ok(None) };
        let of = |method: usize| overlaps(&self.trajectory(method), truth);
        let (best, right) = (of(best)?, of(other)?);
        let (mut longest, mut span) = (0..0, 0..0);
        for (index, (best, other)) in best.iter().zip(&right).enumerate() {
            let (Some(best), Some(other)) = (best, other) else { continue };
            span = if *best > CORRECT && *other <= CORRECT { span.start..index + 1 } else { index + 1..index + 1 };
            longest = if span.len() > longest.len() { span.clone() } else { longest };
        }
        let lost = longest.clone().filter(|index| self.moments[*index].reports[other].state == State::Lost).count();
        Ok((longest.len() >= MIN_FAILURE_FRAMES).then_some((longest.start, 2 * lost > longest.len())))
    }

    pub(super) fn truth_at(&self, index: usize) -> Option<BoundingBox> {
        self.truth.as_ref().and_then(|truth| *truth.get(index)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::paper::Config;
    use smr_evaluation::Configs;
    use smr_recordings::{OpenOptions, synthetic};
    use std::path::Path;

    fn open() -> Sequence {
        smr_recordings::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap()
    }

    fn variants(methods: &[MethodKind]) -> Vec<Variant> {
        let configs = Configs::from(Config::paper());
        methods.iter().map(|&kind| Variant::new(kind, &configs)).collect()
    }

    fn film(methods: &[MethodKind]) -> FilmedRecording {
        watch(open(), Watch::new(&variants(methods)), || ()).unwrap()
    }

    #[test]
    fn the_film_is_what_the_methods_answer() {
        let methods = [MethodKind::Paper, MethodKind::Sad, MethodKind::Robust];
        let film = film(&methods);
        let evaluated = smr_evaluation::evaluate(open(), &variants(&methods), &[], || ()).unwrap();
        assert_eq!(film.evaluation().unwrap().unwrap().scores, evaluated.scores);
        assert_eq!(film.moments.len(), synthetic::LENGTH);
        let states: Vec<State> = film.moments.iter().map(|moment| moment.reports[0].state).collect();
        for state in [State::Tracking, State::Leaving, State::Lost] {
            assert!(states.contains(&state), "{state:?}");
        }
    }

    #[test]
    fn the_robust_tracker_follows_the_car_in_the_street_and_the_papers_does_not() {
        let street = smr_recordings::open(Path::new("street"), &OpenOptions::default()).unwrap();
        let methods = variants(&[MethodKind::Robust, MethodKind::Paper]);
        let film = watch(street, Watch::new(&methods), || ()).unwrap();
        let scores = film.evaluation().unwrap().unwrap().scores;
        let [robust, papers] = [0, 1].map(|method| scores[method].1.mean_iou.unwrap());
        assert!(robust > 0.7 && papers < 0.3, "{robust} {papers}");
    }

    #[test]
    fn times_read_as_on_a_clock() {
        let film =
            FilmedRecording { times: vec![Some(12.38), Some(59.96), Some(3723.4), None], ..film(&[MethodKind::Sad]) };
        let clocks = [0, 1, 2, 3].map(|index| film.clock(index));
        assert_eq!(clocks, [Some("0:12.4".into()), Some("1:00.0".into()), Some("1:02:03.4".into()), None]);
    }

    #[test]
    fn any_method_can_be_the_first() {
        use clap::ValueEnum;
        for &kind in MethodKind::value_variants() {
            let film = film(&[kind]);
            assert!(
                film.moments.iter().all(|moment| kind.states().contains(&moment.reports[0].state)),
                "{}",
                kind.name()
            );
        }
        assert!(watch(open(), Watch::new(&[]), || ()).is_err());
    }

    #[test]
    fn what_counts_adds_up_to_the_ratio() {
        let stills = (0..synthetic::LENGTH).step_by(9).collect();
        let film = watch(open(), Watch { stills, ..Watch::new(&variants(&[MethodKind::Paper])) }, || ()).unwrap();
        let mut searched = 0;
        for still in &film.stills {
            let Some(search) = &still.observations[0].search else { continue };
            let evidence = film.moments[still.index].reports[0].evidence.unwrap();
            let alpha = search.alpha.unwrap();
            let counting = search.difference.pixels.pixels.iter().filter(|&&d| u16::from(d) < alpha);
            let score: f64 = counting.map(|&d| (-f64::from(d) / 255.0).exp()).sum();
            let ratio = score / search.difference.pixels.pixels.len() as f64;
            assert_eq!(evidence.alpha, search.alpha);
            assert!((ratio - evidence.ratio).abs() < 3e-5, "frame {}: {ratio} {}", still.index, evidence.ratio);
            searched += 1;
        }
        assert!(searched > 10);
    }

    #[test]
    fn a_frame_that_there_is_not_is_named() {
        let stills = BTreeSet::from([0, 240]);
        let error =
            watch(open(), Watch { stills, ..Watch::new(&variants(&[MethodKind::Paper])) }, || ()).err().unwrap();
        assert_eq!(error.to_string(), "synthetic: there is no frame 241: expected 1 to 240");
    }

    #[test]
    fn ground_truth_of_another_length_is_an_error() {
        let truth = open().truth.map(|truth| truth[..9].to_vec());
        let sequence = Sequence { truth, ..open() };
        let methods = variants(&[MethodKind::Paper]);
        let film = watch(sequence, Watch::new(&methods), || ()).unwrap();
        let error = format!("{:#}", film.evaluation().err().unwrap());
        assert_eq!(error, "synthetic: there are 240 frames, but the ground truth has 9 boxes");
    }

    #[test]
    fn a_method_that_refuses_the_box_is_left_out_if_it_may_be_and_is_not_the_first() {
        let large = || {
            let frames = (0..3).map(|_| GrayFrame { width: 400, height: 300, pixels: vec![90; 120_000] });
            let init = Some(BoundingBox { x: 10.0, y: 10.0, width: 380.0, height: 280.0 });
            Sequence { init, truth: None, ..Sequence::made("large", frames, vec![]) }
        };
        let watch = |methods: &[MethodKind], refusal| {
            watch(large(), Watch { refusal, ..Watch::new(&variants(methods)) }, || ())
        };
        let methods = [MethodKind::Robust, MethodKind::Paper];
        let film = watch(&methods, Refusal::LeftOut).unwrap();
        assert_eq!(film.methods.iter().map(|method| method.kind).collect::<Vec<_>>(), [MethodKind::Robust]);
        assert_eq!((film.notes.len(), film.moments[0].reports.len()), (1, 1));
        assert!(film.notes[0].starts_with("paper is left out: the box 10,10,380,280 "), "{}", film.notes[0]);
        assert!(watch(&methods, Refusal::Fails).is_err());
        assert!(watch(&[MethodKind::Paper, MethodKind::Robust], Refusal::LeftOut).is_err());
    }

    /// Target `a` starts in frame 11, is gone in frame 25 and locked again in frame 30; target `b` starts in frame 20.
    #[test]
    fn several_targets_are_followed_side_by_side() {
        let start = |frame: usize| (frame, synthetic::truth(frame - 1));
        let target = |name: &str, starts| Target::new(Some(name.to_owned()), starts);
        let targets = || vec![target("a", vec![start(11), (25, None), start(30)]), target("b", vec![start(20)])];
        let part = || open().part("11..50".parse().unwrap(), 1, "--frames");
        let methods = variants(&[MethodKind::Robust, MethodKind::Paper]);
        let film = watch(part(), Watch { targets: targets(), ..Watch::new(&methods) }, || ()).unwrap();
        let names: Vec<_> = film.methods.iter().map(|method| method.name.as_str()).collect();
        assert_eq!(names, ["a, robust", "a, paper", "b, robust", "b, paper"]);
        assert_eq!((film.first, film.truth.is_none(), film.moments.len()), (11, true, 40));
        let answers = |method: usize, index: usize| film.moments[index].reports[method].target;
        let seen = [0, 2, 3].map(|method| (0..40).filter(|&index| film.has(method, index)).count());
        assert_eq!(seen, [40 - 5, 40 - 9, 40 - 9]);
        assert_eq!((answers(2, 8), answers(2, 9)), (None, start(20).1));
        assert_eq!((answers(0, 0), answers(0, 14), answers(0, 19)), (start(11).1, None, start(30).1));
        let late = vec![target("a", vec![start(11)]), target("b", vec![start(60)])];
        let error = watch(part(), Watch { targets: late, ..Watch::new(&methods) }, || ()).err().unwrap();
        assert_eq!(error.to_string(), "synthetic: there is no frame 60: expected 11 to 50");
    }
}
