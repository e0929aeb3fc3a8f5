//! The numbers of the method on the command line, the same for every command that runs the tracker.

use crate::evaluate::{Configs, MethodKind};
use crate::reference::Numbers;
use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, ValueEnum};
use smr_core::similarity::{Backend, Table};
use smr_core::{Config, Fraction, Radius, RunnerUp, robust};
use std::str::FromStr;

/// Which tracker follows the target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// The paper's tracker, to the letter
    #[default]
    Paper,
    /// The paper's tracker for cameras: a bounded window, the template updated up to the edge
    Camera,
    /// The tracker that goes beyond the paper: holds when light, size and view change
    Robust,
}

/// Where the paper's value is not wanted.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Tracker")]
pub struct TrackerOptions {
    /// Which tracker; of the options below, `robust` takes --backend and --without, `paper` and `camera` all others
    #[arg(long, value_enum, default_value = "paper")]
    config: Preset,
    /// Parts of the robust tracker to leave out; several are separated by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART")]
    without: Vec<Part>,
    /// Search window to each side, in pixels [default: 60x50]
    #[arg(long, value_name = "XxY")]
    window: Option<Pair>,
    /// Where the window of a lost target stops to grow; at least --window [default: at the end of
    /// the padded frame; camera: 80x70]
    #[arg(long, value_name = "XxY")]
    window_limit: Option<Pair>,
    /// Pixels by which that window grows a frame, on each side [default: 1]
    #[arg(long)]
    growth: Option<u16>,
    /// alpha = k * the largest change of a template pixel [default: 1/4]
    #[arg(long, value_name = "N/M")]
    k: Option<Ratio>,
    /// p = exp(-d / scale) of a difference of d gray levels, 1 to 4096 [default: 255]
    #[arg(long)]
    scale: Option<u16>,
    /// Zeroes around the frame, in pixels [default: 20]
    #[arg(long)]
    padding: Option<u16>,
    /// The runner-up is more than this many pixels away from the peak [default: 8]
    #[arg(long)]
    neighbourhood: Option<u16>,
    /// The least alpha after an update, in gray levels [default: none]
    #[arg(long, value_name = "LEVELS")]
    least_alpha: Option<u8>,
    /// The least similarity matching ratio of a peak that is believed, as N/M [default: none]
    #[arg(long, value_name = "N/M")]
    least_ratio: Option<Ratio>,
    /// How scores are computed; changes nothing but the time [default: the fastest that
    /// this machine has]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    backend: Option<Backend>,
    /// Score every offset to its last pixel; changes nothing but the time
    #[arg(long)]
    exhaustive: bool,
    /// Look for the runner-up in every frame, not only where the gate's decision depends on it
    #[arg(long)]
    runner_up_always: bool,
}

/// The parts of the robust tracker, each of which can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// A moving target is expected to go on
    Velocity,
    /// Far places must answer more clearly
    Near,
    /// The change of size
    Size,
    /// The early template that tells whether it is still the target
    Verification,
    /// What does not agree with the early template is not learned
    Caution,
    /// Looking for a lost target all over the frame
    Sweep,
}

impl Part {
    /// As on the command line.
    pub fn name(self) -> String {
        // Only a value that clap skips has no name there, and none is skipped.
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Leaves it out of `config`.
    pub fn leave_out(self, config: &mut robust::Config) {
        match self {
            Self::Velocity => config.velocity = false,
            Self::Near => config.near = false,
            Self::Size => config.size = false,
            Self::Verification => config.verification = false,
            Self::Caution => config.caution = false,
            Self::Sweep => config.sweep = false,
        }
    }
}

/// What this machine has, by its name in small letters.
fn backend(text: &str) -> Result<Backend> {
    let name_of = |backend: Backend| format!("{backend:?}").to_lowercase();
    let names = || Backend::available().map(name_of).collect::<Vec<_>>().join(", ");
    let found = Backend::available().find(|&backend| name_of(backend) == text);
    found.with_context(|| format!("this machine has {}", names()))
}

impl TrackerOptions {
    /// The configuration of the paper's tracker with the options put in.
    pub fn config(&self) -> Result<Config> {
        if self.config != Preset::Robust && !self.without.is_empty() {
            bail!("--without leaves out parts of the robust tracker: --config robust is missing");
        }
        let mut config = if self.config == Preset::Camera { Config::camera() } else { Config::paper() };
        if let Some(Pair(x, y)) = self.window {
            config.window = Radius { x, y };
        }
        if let Some(Pair(x, y)) = self.window_limit {
            config.window_limit = Radius { x, y };
        }
        let (Radius { x, y }, limit) = (config.window, config.window_limit);
        if limit.x < x || limit.y < y {
            match self.window_limit {
                Some(Pair(given_x, given_y)) => bail!(
                    "--window-limit {given_x}x{given_y} is smaller than the window of {x}x{y}: expected {x}x{y} to 65535x65535"
                ),
                None => bail!(
                    "--window {x}x{y} is larger than its limit of {}x{}: expected at most that, or a larger --window-limit",
                    limit.x,
                    limit.y
                ),
            }
        }
        if let Some(Ratio(k)) = self.k {
            config.k = k;
        }
        if let Some(scale) = self.scale {
            let table = Table::new(scale).with_context(|| format!("--scale {scale}"))?;
            // The configuration wants a table for the life of the program; this is the one place that makes one.
            config.table = Box::leak(Box::new(table));
        }
        config.least_threshold = self.least_alpha.unwrap_or(config.least_threshold);
        if let Some(ratio) = &self.least_ratio {
            config.gate.least_ratio = ratio.of_one().context("--least-ratio")?;
        }
        config.growth = self.growth.unwrap_or(config.growth);
        config.backend = self.backend;
        config.pruning = !self.exhaustive;
        if self.runner_up_always {
            config.runner_up = RunnerUp::Always;
        }
        config.padding = self.padding.unwrap_or(config.padding);
        config.neighbourhood = self.neighbourhood.unwrap_or(config.neighbourhood);
        Ok(config)
    }

    /// What all methods are built from.
    pub fn configs(&self) -> Result<Configs> {
        let robust = match self.preset() {
            Preset::Paper | Preset::Camera => None,
            Preset::Robust => Some(self.robust()?),
        };
        Ok(Configs { paper: self.config()?, robust })
    }

    /// Which tracker is asked for.
    pub fn preset(&self) -> Preset {
        self.config
    }

    /// The robust tracker's configuration with the options put in.
    ///
    /// # Errors
    /// An option that only the paper's tracker has.
    pub fn robust(&self) -> Result<robust::Config> {
        if let Some(name) = self.of_paper_only() {
            bail!("{name} is an option of --config paper: the robust tracker has no such number");
        }
        let mut config = robust::Config::robust();
        self.without.iter().for_each(|part| part.leave_out(&mut config));
        config.backend = self.backend;
        Ok(config)
    }

    fn of_paper_only(&self) -> Option<&'static str> {
        let given = [
            (self.window.is_some(), "--window"),
            (self.window_limit.is_some(), "--window-limit"),
            (self.growth.is_some(), "--growth"),
            (self.k.is_some(), "--k"),
            (self.scale.is_some(), "--scale"),
            (self.padding.is_some(), "--padding"),
            (self.neighbourhood.is_some(), "--neighbourhood"),
            (self.exhaustive, "--exhaustive"),
            (self.least_alpha.is_some(), "--least-alpha"),
            (self.least_ratio.is_some(), "--least-ratio"),
            (self.runner_up_always, "--runner-up-always"),
        ];
        given.into_iter().find(|(given, _)| *given).map(|(_, name)| name)
    }

    /// True if no option is given.
    pub fn says_nothing(&self) -> bool {
        self.config == Preset::Paper
            && self.without.is_empty()
            && self.backend.is_none()
            && self.of_paper_only().is_none()
    }

    /// # Errors
    /// An option that none of `methods` takes: of SMR's numbers the others have --window and --padding alone.
    pub fn check_for(&self, methods: &[MethodKind]) -> Result<()> {
        let given = [
            (self.config != Preset::default(), "--config"),
            (self.window_limit.is_some(), "--window-limit"),
            (self.growth.is_some(), "--growth"),
            (self.k.is_some(), "--k"),
            (self.scale.is_some(), "--scale"),
            (self.neighbourhood.is_some(), "--neighbourhood"),
            (self.backend.is_some(), "--backend"),
            (self.exhaustive, "--exhaustive"),
            (self.runner_up_always, "--runner-up-always"),
        ];
        match given.into_iter().find(|(given, _)| *given) {
            Some((_, name)) if !methods.contains(&MethodKind::Smr) => {
                bail!("{name} is an option of smr, which is not measured: expected it in --method")
            }
            _ => Ok(()),
        }
    }

    /// The same for the reference, which keeps its own copy of the paper's numbers.
    pub fn reference_numbers(&self) -> Numbers {
        let mut numbers = if self.config == Preset::Camera { Numbers::camera() } else { Numbers::paper() };
        if let Some(Pair(x, y)) = self.window {
            numbers.window = (x.into(), y.into());
        }
        if let Some(Pair(x, y)) = self.window_limit {
            numbers.window_limit = Some((x.into(), y.into()));
        }
        if let Some(Ratio(k)) = self.k {
            numbers.k = (k.numerator.into(), k.denominator.into());
        }
        if let Some(ratio) = self.least_ratio.as_ref().and_then(|ratio| ratio.of_one().ok()) {
            numbers.gate.least_ratio = ratio.into();
        }
        numbers.least_alpha = self.least_alpha.map_or(numbers.least_alpha, f64::from);
        numbers.runner_up_always = self.runner_up_always;
        numbers.scale = self.scale.map_or(numbers.scale, f64::from);
        numbers.growth = self.growth.map_or(numbers.growth, i64::from);
        numbers.padding = self.padding.map_or(numbers.padding, i64::from);
        numbers.neighbourhood = self.neighbourhood.map_or(numbers.neighbourhood, i64::from);
        numbers
    }
}

#[cfg(feature = "emulator")]
/// For a command that runs the paper's tracker only: the other one is refused in words, not as an unknown option.
#[derive(Args, Clone, Debug, Default)]
pub struct PaperOnly {
    /// Which tracker; only the paper's can be used here
    #[arg(long, value_enum, default_value = "paper", help_heading = "Tracker")]
    config: Preset,
}

#[cfg(feature = "emulator")]
impl PaperOnly {
    /// # Errors
    /// Another tracker is asked for.
    pub fn check(&self, command: &str) -> Result<()> {
        match self.config {
            Preset::Paper => Ok(()),
            Preset::Camera | Preset::Robust => {
                bail!("{command} is for the paper's tracker only: expected --config paper")
            }
        }
    }
}

/// `60x50`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair(pub u16, pub u16);

impl FromStr for Pair {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (x, y) = two(text, 'x').ok_or_else(|| anyhow!("expected two whole numbers like 60x50"))?;
        Ok(Self(x, y))
    }
}

/// `1/4`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ratio(Fraction);

impl Ratio {
    /// In units of 1/65535, rounded down.
    fn of_one(&self) -> Result<u16> {
        let Fraction { numerator, denominator } = self.0;
        let units = (u32::from(u16::MAX) * u32::from(numerator)).checked_div(denominator.into());
        units
            .and_then(|units| u16::try_from(units).ok())
            .ok_or_else(|| anyhow!("expected a fraction from 0 to 1, like 1/4"))
    }
}

impl FromStr for Ratio {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (numerator, denominator) = two(text, '/').ok_or_else(|| anyhow!("expected a fraction like 1/4"))?;
        Ok(Self(Fraction::new(numerator, denominator)))
    }
}

fn two(text: &str, separator: char) -> Option<(u16, u16)> {
    let (first, second) = text.split_once(separator)?;
    Some((first.parse().ok()?, second.parse().ok()?))
}
