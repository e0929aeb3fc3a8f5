//! `host-sim check`: compares smr-core with the f64 reference, on recordings or by default on built-in ones.

use super::recording_options::RecordingOptions;
use super::tracker_options::TrackerOptions;
use super::{Outcome, progress, say};
use crate::check::{self, Checked, Violation, paper, robust};
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use smr_core::Robust;
use smr_core::robust::Small;
use smr_evaluation::{CoreKind, MethodKind, Origin, Paper, RobustSize, Variant, lock};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Check {
    /// The recordings; `synthetic`, `periodic` and `border` if none is given
    #[arg(value_name = "SEQ", default_values = smr_recordings::CHECKED)]
    sequences: Vec<PathBuf>,
    /// The tracker to check [default: that of --config, else paper]
    #[arg(long, value_enum)]
    method: Option<CoreKind>,
    /// Print a JSON array, one object a recording
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    tracker: TrackerOptions,
}

#[derive(Debug, Serialize)]
struct CheckedRecording {
    #[serde(flatten)]
    origin: Origin,
    #[serde(flatten)]
    report: check::Comparison<Counts>,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Counts {
    Paper(paper::Counts),
    Robust(robust::Counts),
}

impl Check {
    pub fn run(self) -> Result<Outcome> {
        self.recording.check_for(self.sequences.len())?;
        let mut reports = Vec::new();
        let result = self.sequences.iter().try_for_each(|path| {
            let report = self.check(path)?;
            if !self.json {
                say(|out| describe(&report.report, out))?;
            }
            reports.push(report);
            Ok(())
        });
        if self.json {
            let json = serde_json::to_string_pretty(&reports)?;
            say(|out| writeln!(out, "{json}"))?;
        }
        let holds = |report: &CheckedRecording| report.report.violation.is_none();
        result.map(|()| if reports.iter().all(holds) { Outcome::Holds } else { Outcome::CheckFailed })
    }

    fn variant(&self) -> Result<Variant> {
        let method = self.method.map(MethodKind::from).or_else(|| self.tracker.method());
        self.tracker.variant(method.unwrap_or(MethodKind::Paper))
    }

    fn check(&self, path: &Path) -> Result<CheckedRecording> {
        let variant = self.variant()?;
        let configs = &variant.configs;
        let report = match variant.kind {
            MethodKind::Robust => {
                let numbers = self.tracker.robust_reference_numbers();
                let both = (configs.robust, numbers);
                match configs.robust_size {
                    RobustSize::Standard => self.compare::<Robust>(path, both, configs.step, Counts::Robust)?,
                    RobustSize::Small => self.compare::<Robust<Small>>(path, both, configs.step, Counts::Robust)?,
                }
            }
            _ => {
                let numbers = self.tracker.reference_numbers();
                self.compare::<Paper>(path, (configs.paper, numbers), configs.step, Counts::Paper)?
            }
        };
        Ok(CheckedRecording { origin: variant.origin(), report })
    }

    fn compare<T: Checked>(
        &self,
        path: &Path,
        numbers: (T::Config, T::Numbers),
        step: u32,
        counts: fn(T::Counts) -> Counts,
    ) -> Result<check::Comparison<Counts>> {
        let sequence = self.recording.open(path)?;
        let target = sequence.start()?;
        let (name, mut frames) = (sequence.name, sequence.frames);
        let first = frames.next().with_context(|| format!("{name}: no frames"))??.gray;
        let progress = progress::bar(&name, sequence.length.map(|length| length.saturating_sub(1)));
        // Locks a separate tracker before the check, so that a refused box gets the same message as in other commands.
        let variant = self.variant()?;
        lock(variant.build()?.as_mut(), &first.frame(), target).with_context(|| name.clone())?;
        let mut run = check::Check::<T>::lock(&name, numbers, step, &first, target)?;
        for frame in frames {
            if !run.holds() {
                break;
            }
            run.update(&frame?.gray)?;
            progress.inc();
        }
        progress.clear();
        let check::Comparison { sequence, frames, violation, counts: counted } = run.into_comparison();
        let compared = frames > 0 || violation.is_some();
        ensure!(compared, "{name}: only one frame, which is locked on: expected two or more");
        Ok(check::Comparison { sequence, frames, violation, counts: counts(counted) })
    }
}

fn describe(report: &check::Comparison<Counts>, out: &mut impl Write) -> io::Result<()> {
    let check::Comparison { sequence, frames, violation, counts } = report;
    let (compared, equal) = match counts {
        Counts::Paper(paper::Counts { scores, runners_up, .. }) => (
            format!("{scores} scores"),
            format!(
                "scores, peaks, alpha, boxes, states, templates; the runner-up in the {runners_up} frames that need it"
            ),
        ),
        Counts::Robust(robust::Counts { responses, .. }) => (
            format!("{responses} responses"),
            "windows, features, responses, weights, early templates, ratios, confidence, identities, states, scales, boxes"
                .to_owned(),
        ),
    };
    writeln!(out, "{sequence}: {frames} frames, {compared}")?;
    match violation {
        Some(Violation { frame, what, core, reference }) => {
            writeln!(out, "  FAILED in frame {frame}: {what}\n    smr-core:  {core}\n    reference: {reference}")?;
        }
        None => writeln!(out, "  equal, bit for bit: {equal}")?,
    }
    match counts {
        Counts::Paper(counts) => describe_paper(counts, out),
        Counts::Robust(robust::Counts { uncertain, lost, learned, swept, found_again, .. }) => writeln!(
            out,
            "  {uncertain} frames uncertain, {lost} lost; the filter learned in {learned}; redetection in {swept}, found again in \
             {found_again}"
        ),
    }
}

fn describe_paper(counts: &paper::Counts, out: &mut impl Write) -> io::Result<()> {
    let paper::Counts { largest_difference, bound, other_peaks, .. } = counts;
    writeln!(
        out,
        "  rounding: scores differ from exact ones by at most {largest_difference:.1} units of 1/65535, {bound:.1} are allowed"
    )?;
    if other_peaks.is_empty() {
        return writeln!(out, "  the exact scores have the same peak in every frame");
    }
    let (count, allowed) = (other_peaks.len(), 2.0 * bound);
    writeln!(
        out,
        "  the exact scores have another peak in {count} frames; it may lead by at most {allowed:.1} units:"
    )?;
    other_peaks.iter().try_for_each(|other| writeln!(out, "    frame {}: by {:.1} units", other.frame, other.margin))
}
