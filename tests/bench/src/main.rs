//! Measures how fast it is: `cargo run --profile bench -p smr-bench -- RECORDINGS`, beside a plain SAD search.

use anyhow::{Context, Result, anyhow, ensure};
use clap::ValueEnum;
use host_sim::command::number::{from, whole};
use host_sim::command::recording_options::RecordingOptions;
use host_sim::command::tracker_options::Pair;
use host_sim::command::{Outcome, program, progress, tell};
use rayon::prelude::*;
use smr_bench::case::{self, Size};
use smr_bench::clock::{Patience, timed};
use smr_bench::report::Report;
use smr_bench::{Bench as Run, Settings, goals, table};
use smr_core::paper::{Config, Radius};
use smr_evaluation::{CoreKind, MethodKind, Variant};
use smr_recordings::output::complain;
use std::io::Write;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;
use std::time::Duration;

/// How many searches are timed, unless said otherwise.
const SEARCHES: usize = 60;

/// A search is not repeated again once all its times together are longer than this.
const ENOUGH: Duration = Duration::from_millis(10);

/// Threads for the whole evaluation.
const THREADS: usize = 2;

/// Measure how fast it is, beside a plain SAD search
#[derive(Debug, clap::Parser)]
#[command(version, max_term_width = 120)]
struct Bench {
    /// Recordings with ground truth beside them, or folders of such recordings
    #[arg(value_name = "SEQ", default_value = "synthetic")]
    paths: Vec<PathBuf>,
    /// Which trackers; several are separated by commas
    ///
    /// Beside them a plain SAD search, always. The window of robust is its own: it is timed in the cases of each window.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "smr,robust")]
    method: Vec<CoreKind>,
    /// Size of the template, or `own`: that of the recording's box
    #[arg(long, value_name = "WxH", default_value = "64x64")]
    template: Template,
    /// Search window to each side, in pixels; may be given several times
    #[arg(long, value_name = "XxY", default_values = ["16x16", "60x50"])]
    window: Vec<Pair>,
    /// Time a search in every N-th frame [default: so that there are about 60 in all]
    #[arg(long, value_name = "N", value_parser = from::<NonZeroUsize>(1))]
    every: Option<NonZeroUsize>,
    /// Time each search up to this many times; the shortest time counts
    #[arg(long, value_name = "N", default_value = "7", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    repeat: NonZeroU32,
    /// The most seconds for one kind of search; a slower one is timed in fewer frames
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    seconds: NonZeroU32,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

fn main() -> ExitCode {
    program(Bench::run)
}

impl Bench {
    fn run(self) -> Result<Outcome> {
        let paths = self.recording.find(&self.paths)?;

        let run = self.time(&paths)?;
        let (evaluated, time) = timed(|| self.evaluate(&paths));
        evaluated?;
        let mut report = Report::new(&run, Some(time));
        report.goals = goals::all(&report);
        tell(self.json, &report, |report, out| out.write_all(table::text(report).as_bytes()))?;
        for difference in &report.differences {
            complain(&format!("error: different answers: {difference}"));
        }
        Ok(if report.differences.is_empty() { Outcome::Holds } else { Outcome::CheckFailed })
    }

    /// All that is timed on this machine.
    fn time(&self, paths: &[PathBuf]) -> Result<Run> {
        let every = self.every.map_or_else(|| self.usual_distance(paths), |every| Ok(every.get()))?;
        let expected = self.count(paths, every)?;
        ensure!(expected > 0, "no frame to time: there must be ground truth, and two frames after it");
        let mut run = Run::new(self.settings(every), expected);
        let bar = progress::bar("bench", Some(expected));
        for path in paths {
            run.add(self.recording.open(path)?, || bar.inc(1))?;
        }
        bar.finish_and_clear();
        Ok(run)
    }

    fn usual_distance(&self, paths: &[PathBuf]) -> Result<usize> {
        Ok((self.count(paths, 1)? / SEARCHES).max(1))
    }

    fn count(&self, paths: &[PathBuf], every: usize) -> Result<usize> {
        paths.iter().map(|path| case::count(&self.recording.open(path)?, every)).sum()
    }

    /// Each once.
    fn methods(&self) -> Vec<CoreKind> {
        let asked = |method: &CoreKind| self.method.contains(method);
        CoreKind::value_variants().iter().copied().filter(asked).collect()
    }

    fn settings(&self, every: usize) -> Settings {
        Settings {
            methods: self.methods(),
            template: self.template.0,
            windows: self.window.iter().map(|&Pair(x, y)| Radius { x, y }).collect(),
            every,
            patience: Patience { repeats: self.repeat.get(), enough: ENOUGH },
            each: Duration::from_secs(self.seconds.get().into()),
        }
    }

    /// What `host-sim eval` does, decoding included.
    fn evaluate(&self, paths: &[PathBuf]) -> Result<()> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build().context("no threads")?;
        let one = |path: &PathBuf| {
            let variant = Variant::new(MethodKind::Smr, &Config::paper().into());
            smr_evaluation::evaluate(self.recording.open(path)?, &[variant], &[], || ()).map(|_| ())
        };
        pool.install(|| paths.par_iter().map(one).collect())
    }
}

/// `64x64` or `own`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Template(Size);

impl FromStr for Template {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "own" {
            return Ok(Self(Size::Own));
        }
        let expected = || anyhow!("expected two whole numbers above 0 like 64x64, or own");
        let Pair(width, height) = text.parse().map_err(|_| expected())?;
        ensure!(width > 0 && height > 0, expected());
        Ok(Self(Size::Of(width, height)))
    }
}
