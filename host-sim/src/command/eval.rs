//! `host-sim eval`: methods, and the published results of others, measured against ground truth, from one start or many.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::recordings::recordings;
use super::robustness::{self, end, progress_bar, say_what_failed};
use super::tracker_options::TrackerOptions;
use crate::evaluate::robustness::Robustness;
use crate::evaluate::{self, Configs, Evaluation, MethodKind, Results, Variant};
use crate::output::{Output, print};
use crate::report::calibration;
use crate::report::diagram::Form;
use anyhow::{Error, Result, ensure};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Eval {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// What is measured; several are separated by commas. With --config robust `smr` is the robust tracker
    #[arg(long, value_enum, value_delimiter = ',', default_value = "smr")]
    method: Vec<MethodKind>,
    /// Also score other trackers' results, trackers/*.txt beside a recording
    ///
    /// One x1,y1,x2,y2 a frame, NaN for no answer. A file that ends early has no answer from there on; lines after the
    /// last frame are not looked at.
    #[arg(long)]
    compare: bool,
    /// Run from 5 starts: the given box, 2 pixels to the right, 2 down, and scaled by 0.95 and 1.05 about its centre
    ///
    /// The numbers of a changed box are rounded to whole pixels once, and what lies outside the frame is cut off. Of each
    /// recording: correct frames over visible ones, mean over the starts and from the worst; mean IoU where there is an
    /// answer and the target is visible; correct answers over all answers; answers while the target is hidden; how
    /// often it came back, and in how many of these a correct answer came within 50 frames; comparisons (at most) and time of
    /// an update. Then means over recordings, and over those of each folder. A recording is in memory
    /// as a whole, and may have 1 GiB of frames.
    #[arg(long, conflicts_with = "compare")]
    robustness: bool,
    /// With --robustness: in place of the 5, start at every N-th frame in which the target is visible
    ///
    /// From the ground truth's box, cut to the frame, to the end of the recording; not in the last frame.
    #[arg(long, value_name = "N", requires = "robustness", conflicts_with_all = ["init", "inclusive"])]
    starts_every: Option<NonZeroUsize>,
    /// With --robustness: draw the chance that a frame is correct by the ratio that was reported in it: FILE.svg or FILE.png
    ///
    /// Over all frames of all runs of SMR, with the numbers as one more table. A frame without an answer is not correct, and
    /// neither is one in which the target is hidden.
    #[arg(long, value_name = "FILE", requires = "robustness")]
    calibration: Option<PathBuf>,
    /// Print JSON instead of tables: an array of objects, one for each tracker and recording; with --robustness an object
    /// of three arrays, `recordings`, `means` and `calibration`
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

impl Eval {
    pub fn run(mut self) -> Result<Outcome> {
        let configs = self.tracker.configs()?;
        for kind in &self.method {
            // A configuration that cannot be used is no fault of a recording: it is said once, here.
            kind.build(&configs)?;
        }
        drop_repeated(&mut self.method);
        if self.robustness {
            return self.measure_robustness(&configs);
        }

        let found: Result<Vec<_>> = self.paths.iter().map(|path| recordings(path)).collect();
        let found = found?.concat();
        self.recording.check_for(found.len())?;
        let evaluations = self.evaluate(&found, &configs);
        let failed = say_what_failed(evaluations.iter().flat_map(errors));
        let mut evaluations: Vec<Evaluation> = evaluations.into_iter().flatten().collect();
        evaluations.retain(|evaluation| !evaluation.scores.is_empty());
        say_what_to_know(&evaluations);
        self.print(&Results::new(&evaluations))?;
        end(failed)
    }

    fn measure_robustness(&self, configs: &Configs) -> Result<Outcome> {
        let form = self.calibration.as_deref().map(Form::of).transpose()?;
        let smr = self.method.contains(&MethodKind::Smr);
        ensure!(smr || form.is_none(), "--calibration is of the ratio that SMR reports: --method smr is missing");
        let plot = self.calibration.as_deref().map(Output::create).transpose()?;
        let variants: Vec<Variant> = self.method.iter().map(|&kind| Variant::new(kind, configs)).collect();
        let (robustness, failed) = robustness::measure(&self.paths, &self.recording, &variants, self.starts_every)?;
        if let (Some(mut plot), Some(form)) = (plot, form) {
            plot.write(&form.draw(&calibration::marks(robustness.calibration()))?)?;
            plot.finish()?;
        }
        self.print_robustness(&robustness)?;
        end(failed)
    }

    fn print_robustness(&self, robustness: &Robustness) -> Result<()> {
        let text = match (self.json, &self.calibration) {
            (true, _) => serde_json::to_string_pretty(robustness)? + "\n",
            (false, None) => robustness.table(),
            (false, Some(_)) => format!("{}\n{}", robustness.table(), robustness.calibration_table()),
        };
        print(|out| out.write_all(text.as_bytes()))
    }

    /// Recordings run in parallel, each on one thread; the results come in the order of `paths`.
    fn evaluate(&self, paths: &[PathBuf], configs: &Configs) -> Vec<Result<Evaluation>> {
        let bar = progress_bar();
        let evaluations = paths.par_iter().map(|path| self.evaluate_one(path, configs, &bar)).collect();
        bar.finish_and_clear();
        evaluations
    }

    fn evaluate_one(&self, path: &Path, configs: &Configs, bar: &ProgressBar) -> Result<Evaluation> {
        let sequence = self.recording.open(path)?;
        bar.inc_length(sequence.truth.as_ref().map_or(0, |truth| truth.len() as u64));
        let files = if self.compare { evaluate::result_files(path)? } else { Vec::new() };
        evaluate::evaluate(sequence, &self.method, configs, &files, || bar.inc(1))
    }

    fn print(&self, results: &Results) -> Result<()> {
        let text = match self.json {
            true => serde_json::to_string_pretty(&results.rows().collect::<Vec<_>>())? + "\n",
            false if results.is_empty() => String::new(),
            false => format!("{}\n{}", results.details(), results.correct_frames()),
        };
        print(|out| out.write_all(text.as_bytes()))
    }
}

/// The first of each stays where it is.
fn drop_repeated(methods: &mut Vec<MethodKind>) {
    let all = methods.clone();
    let mut index = 0..;
    methods.retain(|kind| index.next().is_some_and(|index| !all[..index].contains(kind)));
}

fn errors(evaluation: &Result<Evaluation>) -> &[Error] {
    match evaluation {
        Ok(evaluation) => &evaluation.failures,
        Err(error) => std::slice::from_ref(error),
    }
}

fn say_what_to_know(evaluations: &[Evaluation]) {
    for note in evaluations.iter().flat_map(|evaluation| &evaluation.notes) {
        eprintln!("note: {note}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_is_measured_once() {
        let mut methods = [MethodKind::Sad, MethodKind::Smr, MethodKind::Sad].to_vec();
        drop_repeated(&mut methods);
        assert_eq!(methods, [MethodKind::Sad, MethodKind::Smr]);
    }
}
