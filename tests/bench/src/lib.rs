//! Measures speed on this machine, beside a plain SAD search, in the same run. `others/run` does it beside other trackers.
//!
//! - [`case`]: what is timed, searches in frames of recordings.
//! - [`clock`]: how long something takes.
//! - [`searches`]: the same searches with every backend. [`sad`] is what they are compared with.
//! - [`speeds`]: frames per second by size of template and window.
//! - [`goal`], [`goals`]: the goals, and whether they are reached.
//! - [`window`]: the times of a window's searches, summed up.
//! - [`report`]: the measurements as JSON; [`table`]: as text.
//!
//! Everything here runs on one thread, so that the measurements do not disturb each other. Instructions on the host are not
//! counted here, because most users may not read the processor's counters: `.ci/instructions` counts them with valgrind.

pub mod case;
pub mod clock;
pub mod goal;
pub mod goals;
pub mod report;
pub mod sad;
pub mod searches;
pub mod speeds;
pub mod table;
pub mod window;

use crate::clock::Patience;
use anyhow::{Context, Result};
use case::Size;
use searches::{Searches, Way};
use smr_core::paper::Radius;
use smr_evaluation::CoreKind;
use smr_recordings::Sequence;
use speeds::Speeds;
use std::time::Duration;

/// The options of a run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The trackers of smr-core that are measured.
    pub methods: Vec<CoreKind>,
    pub template: Size,
    pub windows: Vec<Radius>,
    /// One frame in this many is timed.
    pub every: usize,
    /// How often one search is timed.
    pub patience: Patience,
    /// How long one way to search may take in all, in each window.
    pub each: Duration,
}

/// A run: recordings are added one after the other.
pub struct Bench {
    pub settings: Settings,
    pub recordings: Vec<String>,
    pub windows: Vec<Searches>,
    pub speeds: Speeds,
}

/// One case in this many is also timed for [`Speeds`], which has many combinations.
const SPEEDS_EVERY: u32 = 3;

impl Bench {
    /// About `expected` cases will come.
    pub fn new(settings: Settings, expected: usize) -> Self {
        let ways = Way::all(&settings.methods);
        let expected = u32::try_from(expected).unwrap_or(u32::MAX);
        let searches = |&radius| Searches::new(radius, settings.template, &ways, settings.each, expected);
        let windows = settings.windows.iter().map(searches).collect();
        let cases = if settings.methods.contains(&CoreKind::Smr) { expected.div_ceil(SPEEDS_EVERY) } else { 0 };
        let speeds = Speeds::new(settings.each / 4, cases);
        Self { settings, recordings: vec![], windows, speeds }
    }

    /// Times the searches in a recording; `progress` is called after each case.
    /// Errors: The recording cannot be read or tracked.
    pub fn add(&mut self, sequence: Sequence, progress: impl Fn()) -> Result<()> {
        let name = sequence.name.clone();
        // It names the recording by itself.
        sequence.start()?;
        let mut count = 0;
        case::triples(sequence, self.settings.every, |triple| {
            for window in &mut self.windows {
                window.add(triple, &name, self.settings.patience)?;
            }
            if count % SPEEDS_EVERY == 0 && self.settings.methods.contains(&CoreKind::Smr) {
                self.speeds.add(triple, self.settings.patience)?;
            }
            count += 1;
            progress();
            Ok(())
        })
        .with_context(|| name.clone())?;
        self.recordings.push(name);
        Ok(())
    }
}
