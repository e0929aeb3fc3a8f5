//! `host-sim check`: smr-core against the reference, on recordings or on the built-in ones.

use super::Outcome;
use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use crate::check::{Check as Run, Report};
use crate::sequence;
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Check {
    /// The recordings; the built-in ones if none is given
    #[arg(value_name = "SEQ", default_values = sequence::BUILT_IN)]
    sequences: Vec<PathBuf>,
    /// Compare only the first N frames after the one that is locked on
    #[arg(long, value_name = "N")]
    frames: Option<NonZeroUsize>,
    /// Print a JSON array, one object a recording
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

impl Check {
    pub fn run(self) -> Result<Outcome> {
        let mut reports = Vec::new();
        let result = self.sequences.iter().try_for_each(|path| {
            let report = self.check(path)?;
            if !self.json {
                print_report(&report);
            }
            reports.push(report);
            Ok(())
        });
        if self.json {
            println!("{}", serde_json::to_string_pretty(&reports)?);
        }
        result.map(|()| if reports.iter().all(Report::holds) { Outcome::Holds } else { Outcome::CheckFailed })
    }

    fn check(&self, path: &Path) -> Result<Report> {
        let sequence = self.recording.open(path)?;
        let target = sequence.start()?;
        let (name, mut frames) = (sequence.name, sequence.frames);
        let first = frames.next().with_context(|| format!("{name}: no frames"))??;
        let (config, numbers) = (self.tracker.config()?, self.tracker.reference_numbers());
        let mut run = Run::lock(&name, config, numbers, &first, target)?;

        let most = self.frames.map_or(usize::MAX, NonZeroUsize::get);
        let progress = progress(&name, sequence.length.map(|length| length.saturating_sub(1).min(most)));
        for frame in frames.take(most) {
            run.update(&frame?)?;
            progress.inc(1);
            if !run.report().holds() {
                break;
            }
        }
        progress.finish_and_clear();
        ensure!(run.report().frames > 0, "{name}: only one frame, which is locked on: there is nothing to compare");
        Ok(run.into_report())
    }
}

/// A bar on a terminal, nothing elsewhere.
fn progress(name: &str, length: Option<usize>) -> ProgressBar {
    let bar = length.map_or_else(ProgressBar::new_spinner, |length| ProgressBar::new(length as u64));
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} frames {eta}");
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.with_message(name.to_owned())
}

fn print_report(report: &Report) {
    let Report { sequence, frames, scores, largest_difference, bound, .. } = report;
    println!("{sequence}: {frames} frames, {scores} scores");
    if let Some(violation) = &report.violation {
        println!("  FAILED in frame {}: {}", violation.frame, violation.what);
        println!("    smr-core:  {}", violation.core);
        println!("    reference: {}", violation.reference);
    } else {
        println!("  equal, bit for bit: scores, peaks, runners-up, alpha, boxes, states, templates");
    }
    println!(
        "  largest difference from an exact score: {largest_difference:.1} of at most {bound:.1} units of 1/65535"
    );
    match report.other_peaks.as_slice() {
        [] => println!("  exact sums have the same arg max in every frame"),
        others => {
            println!(
                "  exact sums have another arg max in {} frames, none by more than the bound allows:",
                others.len()
            );
            for other in others {
                println!("    frame {}: by {:.1} units", other.frame, other.margin);
            }
        }
    }
}
