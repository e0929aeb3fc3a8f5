//! The numbers of the methods on the command line, the same for every command that runs a tracker.

use super::number::whole;
use crate::evaluate::{Configs, MethodKind, Variant};
use crate::reference::{Numbers, robust as reference};
use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, ValueEnum};
use serde_json::{Map, Value};
use smr_core::paper::{Config, Fraction, Radius, RunnerUp};
use smr_core::robust;
use smr_core::similarity::{Backend, Table};
use smr_core::unstable::{self, without};
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// Which numbers `smr` starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// The paper's, to the letter
    #[default]
    Paper,
    /// For cameras: a bounded window, the template updated up to the edge
    Camera,
    /// Not a preset: here to be refused in words.
    #[value(hide = true)]
    Robust,
}

/// Where the usual value is not wanted. Each option says in brackets which methods take it, if that is not smr alone.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Tracker (options of smr, if not said otherwise)")]
pub struct TrackerOptions {
    /// Which numbers smr starts from
    #[arg(long, value_enum, default_value = "paper")]
    config: Preset,
    /// Search window to each side, in pixels [all but robust] [default: 60x50]
    #[arg(long, value_name = "XxY")]
    window: Option<Pair>,
    /// Where the window of a lost target stops to grow; at least --window [default: at the end of
    /// the padded frame; camera: 80x70]
    #[arg(long, value_name = "XxY")]
    window_limit: Option<Pair>,
    /// Pixels by which that window grows a frame, on each side [default: 1]
    #[arg(long, value_parser = whole::<u16>(0..=65535))]
    growth: Option<u16>,
    /// alpha = k * the largest change of a template pixel [default: 1/4]
    #[arg(long, value_name = "N/M")]
    k: Option<Ratio>,
    /// p = exp(-d / scale) of a difference of d gray levels, 1 to 4096 [default: 255]
    #[arg(long, value_parser = whole::<u16>(1..=4096))]
    scale: Option<u16>,
    /// Zeroes around the frame, in pixels [all but robust] [default: 20]
    #[arg(long, value_parser = whole::<u16>(0..=65535))]
    padding: Option<u16>,
    /// The runner-up is more than this many pixels away from the peak [default: 8]
    #[arg(long, value_parser = whole::<u16>(0..=65535))]
    neighbourhood: Option<u16>,
    /// The least alpha after an update, in gray levels [default: none]
    #[arg(long, value_name = "LEVELS", value_parser = whole::<u8>(0..=255))]
    least_alpha: Option<u8>,
    /// The least similarity matching ratio of a peak that is believed, as N/M [default: none]
    #[arg(long, value_name = "N/M")]
    least_ratio: Option<Ratio>,
    /// Score every offset to its last pixel; changes nothing but the time
    #[arg(long)]
    exhaustive: bool,
    /// Look for the runner-up in every frame, not only where the gate's decision depends on it
    #[arg(long)]
    runner_up_always: bool,
    /// Parts to leave out; several are separated by commas [robust]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART")]
    without: Vec<Part>,
    /// How far the target is looked for to each side, in cells, 4 to 8 [robust] [default: 8]
    #[arg(long, value_name = "CELLS", value_parser = whole::<u8>(4..=8))]
    reach: Option<u8>,
    /// How many 256ths of itself the confidence keeps in each frame [robust] [default: 179]
    #[arg(long, value_name = "256THS", value_parser = whole::<u8>(0..=255))]
    patience: Option<u8>,
    /// The target is lost while the confidence is below this, 0 to 65535 [robust] [default: 19200]
    #[arg(long, value_name = "CONFIDENCE", value_parser = whole::<u16>(0..=65535))]
    lost_below: Option<u16>,
    /// It is uncertain while the confidence is below this; at least --lost-below [robust] [default: 32500]
    #[arg(long, value_name = "CONFIDENCE", value_parser = whole::<u16>(0..=65535))]
    uncertain_below: Option<u16>,
    /// How far the filter goes towards what is best for the present frame, 0 to 256 256ths [robust] [default: 160]
    #[arg(long, value_name = "256THS", value_parser = whole::<u16>(0..=256))]
    learning_rate: Option<u16>,
    /// How far the early template goes towards the present frame, 0 to 1024 1024ths [robust] [default: 1]
    #[arg(long, value_name = "1024THS", value_parser = whole::<u16>(0..=1024))]
    early_rate: Option<u16>,
    /// How scores are computed; changes nothing but the time [smr, robust] [default: the fastest that
    /// this machine has]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    backend: Option<Backend>,
    /// Update in steps of so much work, as firmware with a deadline does; changes no answer [smr, robust] [default: all at once]
    #[arg(long, value_name = "WORK", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    step: Option<NonZeroU32>,
}

/// An option that was given, and which methods take it.
struct Given {
    name: &'static str,
    value: Value,
    taken_by: &'static [MethodKind],
}

const SMR: &[MethodKind] = &[MethodKind::Smr];
const ROBUST: &[MethodKind] = &[MethodKind::Robust];
const CORE: &[MethodKind] = &[MethodKind::Smr, MethodKind::Robust];
/// Those that search a window of a given radius in a padded frame.
const WINDOWED: &[MethodKind] = &[MethodKind::Smr, MethodKind::Sad, MethodKind::Ssd, MethodKind::Ncc, MethodKind::Lk];

/// The parts of the robust tracker, each of which can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// A moving target is expected to go on
    Velocity,
    /// Responses far from where the target is expected count less
    DistancePenalty,
    /// The change of size
    Size,
    /// The early template checks that it is still the target
    Verification,
    /// Only frames with enough evidence are learned
    GatedLearning,
    /// A lost target is searched all over the frame
    Sweep,
}

impl Part {
    /// As on the command line.
    pub fn name(self) -> String {
        // Only a value that clap skips has no name there, and none is skipped.
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether the reference has it.
    fn of(self, parts: &mut reference::Parts) -> &mut bool {
        match self {
            Self::Velocity => &mut parts.velocity,
            Self::DistancePenalty => &mut parts.distance_penalty,
            Self::Size => &mut parts.size,
            Self::Verification => &mut parts.verification,
            Self::GatedLearning => &mut parts.gated_learning,
            Self::Sweep => &mut parts.sweep,
        }
    }

    /// Leaves it out of `config`.
    pub fn leave_out(self, config: &mut robust::Config) {
        match self {
            Self::Velocity => *config = without(*config, unstable::Part::Velocity),
            Self::DistancePenalty => *config = without(*config, unstable::Part::DistancePenalty),
            Self::Size => config.size = false,
            Self::Verification => *config = without(*config, unstable::Part::Verification),
            Self::GatedLearning => *config = without(*config, unstable::Part::GatedLearning),
            Self::Sweep => config.sweep = false,
        }
    }
}

/// What this machine has, by its name in small letters.
fn backend(text: &str) -> Result<Backend> {
    let names = || Backend::available().map(backend_name).collect::<Vec<_>>().join(", ");
    let found = Backend::available().find(|&backend| backend_name(backend) == text);
    found.with_context(|| format!("this machine has {}", names()))
}

fn backend_name(backend: Backend) -> String {
    format!("{backend:?}").to_lowercase()
}

impl TrackerOptions {
    /// `methods`, each once, with what they are built from.
    ///
    /// # Errors
    /// An option that none of them takes, or that is out of range.
    pub fn variants(&self, methods: &[MethodKind]) -> Result<Vec<Variant>> {
        self.check_for(methods)?;
        let configs = self.configs()?;
        let first = |index: usize| !methods[..index].contains(&methods[index]);
        let variant = |index: usize| {
            let kind = methods[index];
            Variant { options: self.options_of(kind), ..Variant::new(kind, &configs) }
        };
        Ok((0..methods.len()).filter(|&index| first(index)).map(variant).collect())
    }

    /// One method, with what it is built from.
    ///
    /// # Errors
    /// An option that it does not take, or that is out of range.
    pub fn variant(&self, method: MethodKind) -> Result<Variant> {
        self.check_for(&[method])?;
        Ok(Variant { options: self.options_of(method), ..Variant::new(method, &self.configs()?) })
    }

    /// All that is given, in the order of the help.
    fn given(&self) -> Vec<Given> {
        let text = |value: Option<String>| value.map(Value::from);
        let number = |value: Option<u16>| value.map(Value::from);
        let flag = |given: bool| given.then_some(Value::from(true));
        let preset = match self.config {
            Preset::Paper => None,
            Preset::Camera => Some(Value::from("camera")),
            Preset::Robust => Some(Value::from("robust")),
        };
        let parts: Vec<String> = self.without.iter().map(|part| part.name()).collect();
        let all = [
            ("config", preset, SMR),
            ("window", text(self.window.map(|pair| pair.to_string())), WINDOWED),
            ("window-limit", text(self.window_limit.map(|pair| pair.to_string())), SMR),
            ("growth", number(self.growth), SMR),
            ("k", text(self.k.map(|ratio| ratio.to_string())), SMR),
            ("scale", number(self.scale), SMR),
            ("padding", number(self.padding), WINDOWED),
            ("neighbourhood", number(self.neighbourhood), SMR),
            ("least-alpha", number(self.least_alpha.map(u16::from)), SMR),
            ("least-ratio", text(self.least_ratio.map(|ratio| ratio.to_string())), SMR),
            ("exhaustive", flag(self.exhaustive), SMR),
            ("runner-up-always", flag(self.runner_up_always), SMR),
            ("reach", number(self.reach.map(u16::from)), ROBUST),
            ("patience", number(self.patience.map(u16::from)), ROBUST),
            ("lost-below", number(self.lost_below), ROBUST),
            ("uncertain-below", number(self.uncertain_below), ROBUST),
            ("learning-rate", number(self.learning_rate), ROBUST),
            ("early-rate", number(self.early_rate), ROBUST),
            ("without", (!parts.is_empty()).then(|| Value::from(parts)), ROBUST),
            ("backend", text(self.backend.map(backend_name)), CORE),
            ("step", self.step.map(|step| Value::from(step.get())), CORE),
        ];
        let given = all.into_iter().filter_map(|(name, value, taken_by)| Some(Given { name, value: value?, taken_by }));
        given.collect()
    }

    /// True if no option is given.
    pub fn says_nothing(&self) -> bool {
        self.given().is_empty()
    }

    /// What is given of the options that `method` takes, as it stands in JSON.
    fn options_of(&self, method: MethodKind) -> Map<String, Value> {
        let given = self.given().into_iter().filter(|given| given.taken_by.contains(&method));
        given.map(|Given { name, value, .. }| (name.to_owned(), value)).collect()
    }

    /// # Errors
    /// An option that none of `methods` takes.
    fn check_for(&self, methods: &[MethodKind]) -> Result<()> {
        if self.config == Preset::Robust {
            bail!("--config robust: the robust tracker is a method of its own: use --method robust");
        }
        let taken = |given: &Given| methods.iter().any(|method| given.taken_by.contains(method));
        if let Some(Given { name, taken_by, .. }) = self.given().iter().find(|given| !taken(given)) {
            let names = |methods: &[MethodKind]| methods.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
            bail!("--{name} is an option of {}, not of {}", names(taken_by), names(methods));
        }
        Ok(())
    }

    /// What all methods are built from.
    fn configs(&self) -> Result<Configs> {
        let step = self.step.map_or(u32::MAX, NonZeroU32::get);
        Ok(Configs { paper: self.paper()?, robust: self.robust()?, step })
    }

    /// The configuration of the paper's tracker with the options put in.
    fn paper(&self) -> Result<Config> {
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
            if k.denominator == 0 || k.numerator == 0 {
                bail!("--k {}: expected a numerator and a denominator of 1 to 65535, like 1/4", Ratio(k));
            }
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

    /// The robust tracker's configuration with the options put in.
    fn robust(&self) -> Result<robust::Config> {
        let mut config = robust::Config::robust();
        self.without.iter().for_each(|part| part.leave_out(&mut config));
        config.backend = self.backend;
        config.reach = self.reach.unwrap_or(config.reach);
        config.patience = self.patience.unwrap_or(config.patience);
        config.lost_below = self.lost_below.unwrap_or(config.lost_below);
        config.uncertain_below = self.uncertain_below.unwrap_or(config.uncertain_below);
        config.learning_rate = self.learning_rate.unwrap_or(config.learning_rate);
        config.early_rate = self.early_rate.unwrap_or(config.early_rate);
        let (lost, uncertain) = (config.lost_below, config.uncertain_below);
        if uncertain < lost {
            bail!("--uncertain-below {uncertain} is below --lost-below {lost}: expected {lost} to 65535");
        }
        Ok(config)
    }

    /// The same for its reference, which keeps its own copy of the numbers.
    pub fn robust_reference_numbers(&self) -> reference::Numbers {
        let mut numbers = reference::Numbers::robust();
        for part in &self.without {
            *part.of(&mut numbers.parts) = false;
        }
        numbers.reach = self.reach.map_or(numbers.reach, i64::from);
        numbers.trust_rate = self.patience.map_or(numbers.trust_rate, |patience| 256.0 - f64::from(patience));
        numbers.lost_below = self.lost_below.map_or(numbers.lost_below, f64::from);
        numbers.uncertain_below = self.uncertain_below.map_or(numbers.uncertain_below, f64::from);
        numbers.step = self.learning_rate.map_or(numbers.step, |rate| f64::from(rate) / 256.0);
        numbers.early_rate = self.early_rate.map_or(numbers.early_rate, |rate| f64::from(rate) / 1024.0);
        numbers
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

/// `60x50`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair(pub u16, pub u16);

impl fmt::Display for Pair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0, self.1)
    }
}

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

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.0.numerator, self.0.denominator)
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
