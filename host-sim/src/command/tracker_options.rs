//! The numbers of the methods on the command line, the same for every command that runs a tracker.

use super::whole;
use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, ValueEnum};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};
use smr_core::paper::{Config, Fraction, Radius, RunnerUp};
use smr_core::robust;
use smr_core::similarity::{Backend, Table};
use smr_evaluation::{Configs, MethodKind, Variant};
use smr_recordings::messages::choice_name;
use smr_reference::{Numbers, robust as reference};
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// The presets of both trackers, with the names that they have in every language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// smr: the paper's, to the letter
    Paper,
    /// smr: for cameras: a bounded window, the template updated up to the edge
    Camera,
    /// robust: without the refiner. In firmware: Config::robust(), smr_config_robust
    Robust,
    /// robust: with the refiner. In firmware: Config::refined(), smr_config_refined
    Refined,
}

impl Preset {
    /// The method that has it.
    const fn method(self) -> MethodKind {
        match self {
            Self::Paper | Self::Camera => MethodKind::Smr,
            Self::Robust | Self::Refined => MethodKind::Robust,
        }
    }
}

/// Where the usual value is not wanted. Each option says in brackets which methods take it, if that is not smr alone.
#[derive(Args, Clone, Debug, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Tracker (options of smr, if not said otherwise)")]
pub struct TrackerOptions {
    /// The preset to start from [smr, robust] [default: paper; of robust: refined]
    #[arg(long, value_enum, value_name = "PRESET")]
    config: Option<Preset>,
    /// Search window to each side, in pixels [all but robust] [default: 60x50]
    #[arg(long, value_name = "XxY")]
    window: Option<Pair>,
    /// The largest search window of a lost target; at least --window [default: the padded frame; camera: 80x70]
    #[arg(long, value_name = "XxY")]
    window_limit: Option<Pair>,
    /// Pixels by which the window of a lost target grows in each frame, on each side [default: 1]
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
    /// The smallest alpha after an update, in gray levels [default: none]
    #[arg(long, value_name = "LEVELS", value_parser = whole::<u8>(0..=255))]
    least_alpha: Option<u8>,
    /// The smallest similarity matching ratio at which a peak is believed, as N/M [default: none]
    #[arg(long, value_name = "N/M")]
    least_ratio: Option<Ratio>,
    /// Score every offset to its last pixel; changes only the time
    #[arg(long)]
    exhaustive: bool,
    /// Look for the runner-up in every frame, not only where the gate's decision depends on it
    #[arg(long)]
    runner_up_always: bool,
    /// Parts to turn off, separated by commas [robust]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART")]
    without: Vec<Part>,
    /// How far the target is looked for to each side, in cells, 4 to 8 [robust] [default: 8]
    #[arg(long, value_name = "CELLS", value_parser = whole::<u8>(4..=8))]
    reach: Option<u8>,
    /// How much of the confidence is kept from one frame to the next, in 256ths, 0 to 255 [robust] [default: 179]
    #[arg(long, value_name = "256THS", value_parser = whole::<u8>(0..=255))]
    patience: Option<u8>,
    /// The target is lost while the confidence is below this, 0 to 65535 [robust] [default: 19200]
    #[arg(long, value_name = "CONFIDENCE", value_parser = whole::<u16>(0..=65535))]
    lost_below: Option<u16>,
    /// The target is uncertain while the confidence is below this; at least --lost-below [robust] [default: 32500]
    #[arg(long, value_name = "CONFIDENCE", value_parser = whole::<u16>(0..=65535))]
    uncertain_below: Option<u16>,
    /// How far the filter moves towards the best one for the current frame, in 256ths, 0 to 256 [robust] [default: 160]
    #[arg(long, value_name = "256THS", value_parser = whole::<u16>(0..=256))]
    learning_rate: Option<u16>,
    /// How far the early template moves towards the current frame, in 1024ths, 0 to 1024 [robust] [default: 1]
    #[arg(long, value_name = "1024THS", value_parser = whole::<u16>(0..=1024))]
    early_rate: Option<u16>,
    /// How scores are computed; changes only the time [smr, robust] [default: the fastest on this machine]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    #[serde(serialize_with = "backend_as_name")]
    backend: Option<Backend>,
    /// Update in steps of this much work, as firmware with a deadline does; does not change the answers [smr, robust] [default: all at once]
    #[arg(long, value_name = "WORK", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    step: Option<NonZeroU32>,
}

/// The methods that take an option.
fn taken_by(option: &str) -> &'static [MethodKind] {
    use MethodKind::{Lk, Ncc, Robust, Sad, Smr, Ssd};
    match option {
        // Those that search a window of a given radius in a padded frame.
        "window" | "padding" => &[Smr, Sad, Ssd, Ncc, Lk],
        "without" | "reach" | "patience" | "lost-below" | "uncertain-below" | "learning-rate" | "early-rate" => {
            &[Robust]
        }
        "config" | "backend" | "step" => &[Smr, Robust],
        _ => &[Smr],
    }
}

/// Parts of the robust tracker that `--without` turns off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
enum Part {
    /// The change of size
    Size,
    /// A lost target is searched all over the frame
    Sweep,
    /// A small learned network corrects the box
    Refiner,
}

fn backend(text: &str) -> Result<Backend> {
    let names = || Backend::available().map(backend_name).collect::<Vec<_>>().join(", ");
    let found = Backend::available().find(|&backend| backend_name(backend) == text);
    found.with_context(|| format!("expected one that this machine has: {}", names()))
}

fn backend_name(backend: Backend) -> String {
    format!("{backend:?}").to_lowercase()
}

fn backend_as_name<S: Serializer>(backend: &Option<Backend>, serializer: S) -> Result<S::Ok, S::Error> {
    backend.map(backend_name).serialize(serializer)
}

impl TrackerOptions {
    /// `methods`, each once, with what they are built from.
    /// Errors: An option that none of them takes, or that is out of range.
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
    /// Errors: An option that it does not take, or that is out of range.
    pub fn variant(&self, method: MethodKind) -> Result<Variant> {
        Ok(self.variants(&[method])?.remove(0))
    }

    fn given(&self) -> Map<String, Value> {
        let Ok(Value::Object(mut given)) = serde_json::to_value(self) else { return Map::new() };
        let defaults = [json!(null), json!(false), json!([]), json!("paper"), json!("refined")];
        given.retain(|_, value| !defaults.contains(value));
        given
    }

    pub fn says_nothing(&self) -> bool {
        self.given().is_empty()
    }

    /// What is given of the options that `method` takes, as it stands in JSON.
    fn options_of(&self, method: MethodKind) -> Map<String, Value> {
        let of_another = self.config.is_some_and(|preset| preset.method() != method);
        let takes = |option: &str| taken_by(option).contains(&method) && !(option == "config" && of_another);
        self.given().into_iter().filter(|(option, _)| takes(option)).collect()
    }

    /// Errors: An option that none of `methods` takes.
    fn check_for(&self, methods: &[MethodKind]) -> Result<()> {
        let names = |methods: &[MethodKind]| methods.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
        if let Some(preset) = self.config.filter(|preset| !methods.contains(&preset.method())) {
            let (name, method) = (choice_name(&preset), preset.method().name());
            bail!("--config {name} is a preset of {method}, not of {}: use --method {method}", names(methods));
        }
        let taken = |option: &str| methods.iter().any(|method| taken_by(option).contains(method));
        if let Some(option) = self.given().keys().find(|option| !taken(option)) {
            let taking = taken_by(option);
            bail!(
                "--{option} is an option of {}, not of {}: use --method {}",
                names(taking),
                names(methods),
                taking[0].name()
            );
        }
        Ok(())
    }

    fn configs(&self) -> Result<Configs> {
        let step = self.step.map_or(u32::MAX, NonZeroU32::get);
        Ok(Configs { paper: self.paper()?, robust: self.robust()?, step })
    }

    /// The configuration of the paper's tracker with the options put in.
    fn paper(&self) -> Result<Config> {
        let mut config = if self.config == Some(Preset::Camera) { Config::camera() } else { Config::paper() };
        let radius = |Pair(x, y): Pair| Radius { x, y };
        config.window = self.window.map_or(config.window, radius);
        config.window_limit = self.window_limit.map_or(config.window_limit, radius);
        let (Radius { x, y }, limit) = (config.window, config.window_limit);
        if (x, y) == (0, 0) {
            bail!("--window 0x0: the target is looked for nowhere else: expected pixels to each side, like 16x16");
        }
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
            config.gate.least_ratio = ratio.of_one().with_context(|| format!("--least-ratio {ratio}"))?;
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
        let plain = self.config == Some(Preset::Robust);
        let mut config = if plain { robust::Config::robust() } else { robust::Config::refined() };
        for part in &self.without {
            match part {
                Part::Size => config.size = false,
                Part::Sweep => config.sweep = false,
                Part::Refiner => config.refiner = false,
            }
        }
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
        let mut numbers = reference::Numbers::refined();
        numbers.parts.refiner = self.config != Some(Preset::Robust);
        for part in &self.without {
            match part {
                Part::Size => numbers.parts.size = false,
                Part::Sweep => numbers.parts.sweep = false,
                Part::Refiner => numbers.parts.refiner = false,
            }
        }
        numbers.reach = self.reach.map_or(numbers.reach, i64::from);
        numbers.confidence_rate = self.patience.map_or(numbers.confidence_rate, |patience| 256.0 - f64::from(patience));
        numbers.lost_below = self.lost_below.map_or(numbers.lost_below, f64::from);
        numbers.uncertain_below = self.uncertain_below.map_or(numbers.uncertain_below, f64::from);
        numbers.step = self.learning_rate.map_or(numbers.step, |rate| f64::from(rate) / 256.0);
        numbers.early_rate = self.early_rate.map_or(numbers.early_rate, |rate| f64::from(rate) / 1024.0);
        numbers
    }

    /// The same for the reference, which keeps its own copy of the paper's numbers.
    pub fn reference_numbers(&self) -> Numbers {
        let mut numbers = if self.config == Some(Preset::Camera) { Numbers::camera() } else { Numbers::paper() };
        let radius = |Pair(x, y): Pair| (x.into(), y.into());
        numbers.window = self.window.map_or(numbers.window, radius);
        numbers.window_limit = self.window_limit.map(radius).or(numbers.window_limit);
        numbers.k = self.k.map_or(numbers.k, |Ratio(k)| (k.numerator.into(), k.denominator.into()));
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

impl Serialize for Pair {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl FromStr for Pair {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (x, y) =
            two(text, 'x').ok_or_else(|| anyhow!("expected two whole numbers like 60x50, each at most 65535"))?;
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

impl Serialize for Ratio {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
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
