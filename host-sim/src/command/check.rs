//! `host-sim check`: smr-core against the reference, on recordings or on two built-in ones.

use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, say};
use crate::check::{Check as Run, Report};
use crate::sequence;
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Check {
    /// The recordings; `synthetic` and `periodic` if none is given
    #[arg(value_name = "SEQ", default_values = sequence::CHECKED)]
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
                say(|out| describe(&report, out))?;
            }
            reports.push(report);
            Ok(())
        });
        if self.json {
            let json = serde_json::to_string_pretty(&reports)?;
            say(|out| writeln!(out, "{json}"))?;
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

fn describe(report: &Report, out: &mut impl Write) -> io::Result<()> {
    let Report { sequence, frames, scores, runners_up, largest_difference, bound, .. } = report;
    writeln!(out, "{sequence}: {frames} frames, {scores} scores")?;
    if let Some(violation) = &report.violation {
        writeln!(out, "  FAILED in frame {}: {}", violation.frame, violation.what)?;
        writeln!(out, "    smr-core:  {}", violation.core)?;
        writeln!(out, "    reference: {}", violation.reference)?;
    } else {
        writeln!(
            out,
            "  equal, bit for bit: scores, peaks, alpha, boxes, states, templates; \
             the runner-up in {runners_up} frames, where it is asked for"
        )?;
    }
    writeln!(
        out,
        "  largest difference from an exact score: {largest_difference:.1} of at most {bound:.1} units of 1/65535"
    )?;
    match report.other_peaks.as_slice() {
        [] => writeln!(out, "  exact sums have the same arg max in every frame"),
        others => {
            writeln!(
                out,
                "  exact sums have another arg max in {} frames, where {:.1} units are allowed:",
                others.len(),
                2.0 * bound
            )?;
            for other in others {
                writeln!(out, "    frame {}: by {:.1} units", other.frame, other.margin)?;
            }
            Ok(())
        }
    }
}
