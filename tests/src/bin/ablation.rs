//! Measures what each part of the robust tracker is worth by leaving it out: `cargo run --release -p smr-tests --bin ablation -- RECORDINGS`.

use anyhow::Result;
use clap::{CommandFactory, Parser, ValueEnum};
use host_sim::command::number::from;
use host_sim::command::recording_options::RecordingOptions;
use host_sim::command::table_options::TableOptions;
use host_sim::command::tracker_options::Part;
use host_sim::command::{Outcome, program, robustness};
use smr_core::{paper, robust};
use smr_evaluation::robustness::{Starts, TABLES};
use smr_evaluation::{MethodKind, Variant};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measure what each part of the robust tracker is worth: the tracker without it, against ground truth
#[derive(Debug, Parser)]
#[command(name = "ablation", version, max_term_width = 120)]
struct Ablation {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// In place of the 5 starts of `eval --robustness`, start at every N-th frame in which the target is visible
    #[arg(long, value_name = "N", conflicts_with_all = ["init", "inclusive"], value_parser = from::<NonZeroUsize>(1))]
    starts_every: Option<NonZeroUsize>,
    /// Keep what is measured in this folder, and go on from there
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    tables: TableOptions,
    #[command(flatten)]
    recording: RecordingOptions,
}

fn main() -> ExitCode {
    program(Ablation::run)
}

impl Ablation {
    fn run(self) -> Result<Outcome> {
        self.tables.check(TABLES)?;
        let starts = self.starts_every.map_or(Starts::Near, Starts::Every);
        let (command, resume) = (Self::command(), self.resume.as_deref());
        let (robustness, failed) =
            robustness::measure(&command, &self.paths, &self.recording, &variants(), starts, resume)?;
        self.tables.print(&robustness.tables(), |layout| robustness.summary(layout))?;
        robustness::end(failed)
    }
}

/// The paper's tracker, the robust one, and the robust one without each of its parts.
fn variants() -> Vec<Variant> {
    let robust = |config: robust::Config| Variant::new(MethodKind::Robust, &config.into());
    let whole = robust::Config::refined();
    let without = Part::value_variants().iter().map(|&part| {
        let mut config = whole;
        part.leave_out(&mut config);
        let options = serde_json::Map::from_iter([("without".to_owned(), vec![part.name()].into())]);
        Variant { name: format!("without {}", part.name()), options, ..robust(config) }
    });
    let paper = Variant::new(MethodKind::Smr, &paper::Config::paper().into());
    [paper, robust(whole)].into_iter().chain(without).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_left_out_once() {
        let names: Vec<String> = variants().into_iter().map(|variant| variant.name).collect();
        assert_eq!(names.len(), 2 + Part::value_variants().len());
        assert_eq!(names[..4], ["smr", "robust", "without velocity", "without distance-penalty"]);
        assert!(variants().iter().all(|variant| variant.build().is_ok()));
    }
}
