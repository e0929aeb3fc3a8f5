//! `host-sim eval`: methods, and the published results of others, measured against ground truth, from one start or many.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::recordings::recordings;
use super::tracker_options::TrackerOptions;
use crate::evaluate::robustness::{self, Progress, Robustness, Settings, Starts};
use crate::evaluate::{self, Evaluation, MethodKind, Results};
use anyhow::{Error, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use smr_core::Config;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Eval {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// What is measured; several are separated by commas
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
    /// answer and the target is visible; correct answers over all answers; answers while the target is hidden; comparisons
    /// (at most) and time of an update. Then means over recordings, and over those of each folder. A recording is in memory
    /// as a whole, and may have 1 GiB of frames.
    #[arg(long, conflicts_with = "compare")]
    robustness: bool,
    /// With --robustness: in place of the 5, start at every N-th frame in which the target is visible
    ///
    /// From the ground truth's box, cut to the frame, to the end of the recording; not in the last frame.
    #[arg(long, value_name = "N", requires = "robustness", conflicts_with_all = ["init", "inclusive"])]
    starts_every: Option<NonZeroUsize>,
    /// Print JSON instead of tables: an array of objects, one for each tracker and recording; with --robustness an object
    /// of two arrays, `recordings` and `means`
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

impl Eval {
    pub fn run(mut self) -> Result<Outcome> {
        let config = self.tracker.config()?;
        for kind in &self.method {
            // A configuration that cannot be used is no fault of a recording: it is said once, here.
            kind.build(&config)?;
        }
        drop_repeated(&mut self.method);
        let found: Result<Vec<_>> = self.paths.iter().map(|path| recordings(path)).collect();
        let paths = found?.concat();
        if self.robustness {
            return self.measure_robustness(&paths, &config);
        }

        let evaluations = self.evaluate(&paths, &config);
        let failed = say_what_failed(evaluations.iter().flat_map(errors));
        let mut evaluations: Vec<Evaluation> = evaluations.into_iter().flatten().collect();
        evaluations.retain(|evaluation| !evaluation.scores.is_empty());
        say_what_to_know(&evaluations);
        self.print(&Results::new(&evaluations))?;
        end(failed)
    }

    fn measure_robustness(&self, paths: &[PathBuf], config: &Config) -> Result<Outcome> {
        let starts = self.starts_every.map_or(Starts::Near, Starts::Every);
        let settings = Settings { methods: &self.method, config, starts };
        let bar = progress_bar();
        let mut robustness =
            robustness::measure(paths, |path| self.recording.open(path), settings, &|progress| match progress {
                Progress::Expected(frames) => bar.inc_length(frames),
                Progress::Done => bar.inc(1),
            });
        bar.finish_and_clear();
        if robustness.is_empty() && robustness.failures.len() == 1 {
            // Nothing else was asked for: one line says it all.
            return Err(robustness.failures.remove(0));
        }
        let failed = say_what_failed(&robustness.failures);
        self.print_robustness(&robustness)?;
        end(failed)
    }

    fn print_robustness(&self, robustness: &Robustness) -> Result<()> {
        let text = match self.json {
            true => serde_json::to_string_pretty(robustness)? + "\n",
            false => robustness.table(),
        };
        Ok(std::io::stdout().lock().write_all(text.as_bytes())?)
    }

    /// Recordings run in parallel, each on one thread; the results come in the order of `paths`.
    fn evaluate(&self, paths: &[PathBuf], config: &Config) -> Vec<Result<Evaluation>> {
        let bar = progress_bar();
        let evaluations = paths.par_iter().map(|path| self.evaluate_one(path, config, &bar)).collect();
        bar.finish_and_clear();
        evaluations
    }

    fn evaluate_one(&self, path: &Path, config: &Config, bar: &ProgressBar) -> Result<Evaluation> {
        let sequence = self.recording.open(path)?;
        bar.inc_length(sequence.truth.as_ref().map_or(0, |truth| truth.len() as u64));
        let files = if self.compare { evaluate::result_files(path)? } else { Vec::new() };
        evaluate::evaluate(sequence, &self.method, config, &files, || bar.inc(1))
    }

    fn print(&self, results: &Results) -> Result<()> {
        let text = match self.json {
            true => serde_json::to_string_pretty(&results.rows().collect::<Vec<_>>())? + "\n",
            false if results.is_empty() => String::new(),
            false => format!("{}\n{}", results.details(), results.correct_frames()),
        };
        Ok(std::io::stdout().lock().write_all(text.as_bytes())?)
    }
}

/// The first of each stays where it is.
fn drop_repeated(methods: &mut Vec<MethodKind>) {
    let all = methods.clone();
    let mut index = 0..;
    methods.retain(|kind| index.next().is_some_and(|index| !all[..index].contains(kind)));
}

/// One line on standard error for everything that could not be measured; how many there are.
fn say_what_failed<'a>(errors: impl IntoIterator<Item = &'a Error>) -> usize {
    let say = |error: &Error| eprintln!("error: {error:#}");
    errors.into_iter().map(say).count()
}

fn errors(evaluation: &Result<Evaluation>) -> &[Error] {
    match evaluation {
        Ok(evaluation) => &evaluation.failures,
        Err(error) => std::slice::from_ref(error),
    }
}

fn end(failed: usize) -> Result<Outcome> {
    if failed > 0 {
        bail!("{failed} of what was asked for could not be measured (see above); results are of the rest");
    }
    Ok(Outcome::Holds)
}

fn say_what_to_know(evaluations: &[Evaluation]) {
    for note in evaluations.iter().flat_map(|evaluation| &evaluation.notes) {
        eprintln!("note: {note}");
    }
}

/// Frames done, on standard error; nothing is drawn if that is no terminal.
fn progress_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
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
