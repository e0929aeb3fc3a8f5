//! The measurements as `--json` prints them; the tables are made from the same data.

use super::Bench;
use super::goal::{Goal, STATED_FOR};
use super::speeds::Speed;
use super::window::Window;
use serde::Serialize;
use smr_evaluation::MethodKind;
use std::time::Duration;

/// All measurements of a run.
#[derive(Serialize)]
pub struct Report {
    /// That of this program.
    pub version: &'static str,
    pub methods: Vec<&'static str>,
    /// What this machine says its processor is.
    pub processor: String,
    pub recordings: Vec<String>,
    /// `64x64`, or `own`.
    pub template: String,
    pub every: usize,
    pub windows: Vec<Window>,
    pub speeds: Vec<Speed>,
    /// Seconds that `eval` takes for the recordings, on two threads.
    pub eval_seconds: Option<f64>,
    pub goals_stated_for: &'static str,
    /// Filled in by [`goals::all`](super::goals::all).
    pub goals: Vec<Goal>,
    /// Cases and frames in which two ways gave different answers.
    pub differences: Vec<String>,
}

impl Report {
    pub fn new(bench: &Bench, eval: Option<Duration>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            methods: bench.settings.methods.iter().map(|&method| MethodKind::from(method).name()).collect(),
            processor: processor(),
            recordings: bench.recordings.clone(),
            template: match bench.settings.template {
                super::case::Size::Own => "own".to_owned(),
                super::case::Size::Of(width, height) => format!("{width}x{height}"),
            },
            every: bench.settings.every,
            windows: bench.windows.iter().map(Window::new).collect(),
            speeds: bench.speeds.rows(),
            differences: bench.windows.iter().flat_map(|window| window.differences.clone()).collect(),
            eval_seconds: eval.map(|time| time.as_secs_f64()),
            goals_stated_for: STATED_FOR,
            goals: vec![],
        }
    }
}

/// Linux tells the processor's name, others at least what kind it is.
fn processor() -> String {
    let file = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = file.lines().find(|line| line.starts_with("model name"));
    let name = line.and_then(|line| line.split_once(':')).map(|(_, name)| name.trim().to_owned());
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}
