//! `host-sim check`: smr-core against the reference, on recordings or on two built-in ones.

use super::recording_options::RecordingOptions;
use super::tracker_options::{Preset, TrackerOptions};
use super::{Outcome, say};
use crate::check::{self, Violation, robust};
use crate::sequence::{self, Frames, GrayFrame};
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Check {
    /// The recordings; `synthetic`, `periodic` and `border` if none is given
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

/// What was compared, by the tracker it was compared of.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Report {
    Paper(check::Report),
    Robust(robust::Report),
}

impl Report {
    fn holds(&self) -> bool {
        match self {
            Self::Paper(report) => report.holds(),
            Self::Robust(report) => report.holds(),
        }
    }

    fn frames(&self) -> usize {
        match self {
            Self::Paper(report) => report.frames,
            Self::Robust(report) => report.frames,
        }
    }
}

impl Check {
    pub fn run(self) -> Result<Outcome> {
        self.recording.check_for(self.sequences.len())?;
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
        let progress = progress(&name, sequence.length.map(|length| length.saturating_sub(1).min(self.most())));
        let report = match self.tracker.preset() {
            Preset::Paper | Preset::Camera => {
                let (config, numbers) = (self.tracker.config()?, self.tracker.reference_numbers());
                let mut run = check::Check::lock(&name, config, numbers, &first, target)?;
                self.walk(frames, &progress, |frame| run.update(frame).map(|()| run.report().holds()))?;
                Report::Paper(run.into_report())
            }
            Preset::Robust => {
                let config = self.tracker.robust()?;
                let mut run = robust::Check::lock(&name, config, robust::numbers(&config), &first, target)?;
                self.walk(frames, &progress, |frame| run.update(frame).map(|()| run.report().holds()))?;
                Report::Robust(run.into_report())
            }
        };
        progress.finish_and_clear();
        ensure!(report.frames() > 0, "{name}: only one frame, which is locked on: there is nothing to compare");
        Ok(report)
    }

    fn most(&self) -> usize {
        self.frames.map_or(usize::MAX, NonZeroUsize::get)
    }

    /// Frame by frame, as long as `holds` says so.
    fn walk(
        &self,
        frames: Frames,
        progress: &ProgressBar,
        mut holds: impl FnMut(&GrayFrame) -> Result<bool>,
    ) -> Result<()> {
        for frame in frames.take(self.most()) {
            let holds = holds(&frame?)?;
            progress.inc(1);
            if !holds {
                break;
            }
        }
        Ok(())
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
    match report {
        Report::Paper(report) => describe_paper(report, out),
        Report::Robust(report) => describe_robust(report, out),
    }
}

fn describe_robust(report: &robust::Report, out: &mut impl Write) -> io::Result<()> {
    let robust::Report { sequence, frames, responses, uncertain, lost, learned, swept, found_again, .. } = report;
    writeln!(out, "{sequence}: {frames} frames, {responses} responses")?;
    match &report.violation {
        Some(violation) => describe_violation(violation, out)?,
        None => writeln!(
            out,
            "  equal, bit for bit: windows, features, responses, weights, early templates, ratios, confidence, states, \
             scales, boxes"
        )?,
    }
    writeln!(
        out,
        "  {uncertain} frames uncertain, {lost} lost; {learned} learned from; {swept} windows of the sweep, found again \
         in {found_again}"
    )
}

fn describe_paper(report: &check::Report, out: &mut impl Write) -> io::Result<()> {
    let check::Report { sequence, frames, scores, runners_up, largest_difference, bound, .. } = report;
    writeln!(out, "{sequence}: {frames} frames, {scores} scores")?;
    if let Some(violation) = &report.violation {
        describe_violation(violation, out)?;
    } else {
        writeln!(
            out,
            "  equal, bit for bit: scores, peaks, alpha, boxes, states, templates; \
             the runner-up in {runners_up} frames, where it is asked for"
        )?;
    }
    describe_difference(*largest_difference, *bound, out)?;
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

fn describe_violation(violation: &Violation, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "  FAILED in frame {}: {}", violation.frame, violation.what)?;
    writeln!(out, "    smr-core:  {}", violation.core)?;
    writeln!(out, "    reference: {}", violation.reference)
}

fn describe_difference(largest: f64, bound: f64, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "  largest difference from an exact score: {largest:.1} of at most {bound:.1} units of 1/65535")
}
