//! Runs of a candidate on a recording: clean from five starts, and under each fault.

use crate::faults::{self, LEAD};
use crate::matrix::{Case, Protocol, Record, Recording};
use crate::robustness::Starts;
use crate::{Run, Score, Variant};
use anyhow::{Result, ensure};
use smr_core::Rect;
use smr_recordings::fault::Fault;

pub(super) struct Choice<'a> {
    pub faults: &'a [Fault],
}

pub(super) struct RunFigures {
    /// Frames with a right box, and frames in which the target is visible: of a fault's run, from the fault on.
    right: usize,
    visible: usize,
    /// Work of each update.
    work: Vec<u32>,
    most_pixels: usize,
}

/// The runs of a candidate on a recording.
pub(super) struct Measurement {
    pub sequence: String,
    /// Fraction of visible frames with a right box, mean over the starts.
    pub clean: f64,
    /// The fraction under each fault; `None` if the recording is too short for the faults.
    pub faults: Vec<Option<f64>>,
    pub work: Vec<u32>,
    pub most_pixels: usize,
    /// Pixels of the largest box on which the tracker was locked.
    pub area: usize,
}

impl Protocol for Choice<'_> {
    type Figures = RunFigures;
    const IS_COMMON: bool = false;

    fn cases(&self, place: usize, recording: &Recording) -> Result<Vec<Case>> {
        let Recording { name, truth, .. } = recording;
        ensure!(
            truth.iter().skip(1).any(Option::is_some),
            "{name}: the target is visible in the first frame only: expected frames in which it is followed"
        );
        let mut cases = Starts::Near.cases(place, recording)?;
        let (bounds, Rect { x, y, width, height }) =
            (recording.bounds(), cases.first().map_or(Rect::default(), |case| case.target));
        ensure!(
            bounds.contains(Rect { x, y, width, height }),
            "{name}: the first box {x},{y},{width},{height} (x,y,width,height) is not wholly inside the frame of {}x{} pixels",
            bounds.width,
            bounds.height
        );
        // If not all faults fit, a recording counts with those that do.
        match faults::runs(self.faults, recording) {
            Ok(all) => cases.extend(all),
            Err(_) => cases
                .extend(self.faults.iter().flat_map(|&fault| faults::runs(&[fault], recording).unwrap_or_default())),
        }
        Ok(cases)
    }

    fn figures(&self, _: &Variant, recording: &Recording, case: &Case, run: &Run) -> Result<RunFigures> {
        let (right, visible) = if case.intervention.fault().is_some() {
            let (truth, first) = (faults::truth(recording, case), case.frame + LEAD);
            let right = run.judged(&truth).filter(|&(frame, _, right)| frame >= first && right).count();
            (right, truth[first..case.end].iter().flatten().count())
        } else {
            let answers: Vec<_> = run.reports.iter().map(|report| report.target).collect();
            let score = Score::new(&answers, &recording.truth[case.frame..])?;
            (score.correct, score.visible)
        };
        let work = run.updates().iter().filter_map(|report| report.work).collect();
        Ok(RunFigures { right, visible, work, most_pixels: run.most_pixels })
    }
}

impl Measurement {
    pub fn of(record: Record<'_, RunFigures>, faults: &[Fault]) -> Self {
        let runs = |fault: Option<Fault>| {
            record.runs.iter().filter(move |(case, _)| case.intervention.fault() == fault).map(|(_, run)| run)
        };
        let clean: Vec<f64> = runs(None).map(|run| run.right as f64 / run.visible.max(1) as f64).collect();
        let under = |&fault: &Fault| {
            let (right, visible) =
                runs(Some(fault)).fold((0, 0), |(right, visible), run| (right + run.right, visible + run.visible));
            (visible > 0).then(|| right as f64 / visible as f64)
        };
        let area = |case: &Case| usize::from(case.target.width) * usize::from(case.target.height);
        Self {
            clean: clean.iter().sum::<f64>() / clean.len().max(1) as f64,
            faults: faults.iter().map(under).collect(),
            most_pixels: record.runs.iter().map(|(_, run)| run.most_pixels).max().unwrap_or(0),
            area: record.runs.iter().map(|(case, _)| area(case)).max().unwrap_or(0),
            work: record.runs.into_iter().flat_map(|(_, run)| run.work).collect(),
            sequence: record.sequence,
        }
    }

    /// Returns the note that this recording counts without some of `faults`.
    pub fn without(&self, faults: &[Fault]) -> Option<String> {
        let missing = faults.iter().zip(&self.faults).filter(|(_, figure)| figure.is_none());
        let missing: Vec<String> = missing.map(|(fault, _)| fault.to_string()).collect();
        (!missing.is_empty()).then(|| {
            format!("{}: too short a visible part for {}: it counts without", self.sequence, missing.join(", "))
        })
    }

    /// The mean of `clean` and of the mean over the faults; without faults `clean`.
    pub fn right(&self) -> f64 {
        let known: Vec<f64> = self.faults.iter().copied().flatten().collect();
        if known.is_empty() {
            return self.clean;
        }
        f64::midpoint(self.clean, known.iter().sum::<f64>() / known.len() as f64)
    }
}
