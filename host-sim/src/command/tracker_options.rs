//! Options for the settings of methods, shared by all commands that run a tracker.

use super::whole;
use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::{Args, ValueEnum};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};
use smr_core::paper::Config;
use smr_core::robust::{self, Small};
use smr_core::similarity::{Backend, Table};
use smr_core::{ConfigError, Setting, Settings, Shape};
use smr_evaluation::{Configs, MethodKind, RobustSize, Variant};
use smr_files::messages::choice_name;
use smr_reference::{Numbers, robust as robust_reference};
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// The presets of both trackers. Their names are the same in every programming language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// of the paper tracker: exactly as in the paper
    Paper,
    /// of the paper tracker, for cameras: a bounded window, the template updated up to the frame's edge
    Camera,
    /// of robust, without the refiner; in firmware: Config::robust(), smr_config_robust
    Robust,
    /// of robust, with the refiner; in firmware: Config::refined(), smr_config_refined
    Refined,
    /// of robust with less memory, without the refiner; in firmware: robust::Small, smr_config_small
    Small,
    /// of robust with less memory, with the refiner; in firmware: robust::Small, smr_config_small_refined
    SmallRefined,
}

impl Preset {
    const fn method(self) -> MethodKind {
        match self {
            Self::Paper | Self::Camera => MethodKind::Paper,
            Self::Robust | Self::Refined | Self::Small | Self::SmallRefined => MethodKind::Robust,
        }
    }
}

/// The options of trackers.
#[derive(Args, Clone, Debug, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Tracker (paper, robust)")]
pub struct TrackerOptions {
    /// The preset whose settings --set changes [default: for paper: paper; for robust: refined]
    #[arg(long, value_enum, value_name = "PRESET")]
    config: Option<Preset>,
    /// A setting of the tracker, such as window=16x16, k=7/20, reach=5 or size=off; --help lists all
    #[arg(long, value_name = "NAME=VALUE", long_help = help())]
    set: Vec<Given>,
    /// The kernels that compute scores; changes only the time [default: the fastest on this machine]
    #[arg(long, value_name = "NAME", value_parser = backend)]
    #[serde(serialize_with = "backend_as_name")]
    backend: Option<Backend>,
    /// Split each update into steps of at most WORK units, as firmware with a deadline does; does not change the answers [default: one
    /// step]
    #[arg(long, value_name = "WORK", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    step: Option<NonZeroU32>,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    setting: Setting,
    text: &'static str,
    methods: &'static [MethodKind],
}

/// Settings that `--set` accepts: all that smr-core lists for both trackers, and `scale` and `pruning` of the paper's
/// tracker, which it does not list.
fn known() -> impl Iterator<Item = Known> {
    use MethodKind::{Lk, Ncc, Paper, Robust, Sad, Ssd};
    fn of<C: Settings>(methods: &'static [MethodKind]) -> impl Iterator<Item = Known> {
        C::SETTINGS.iter().zip(C::TEXTS).map(move |(&setting, text)| match setting.name() {
            // The baselines (sad, ssd, ncc, lk) search a window in a padded frame, too.
            "window" | "padding" => Known { setting, text, methods: &[Paper, Sad, Ssd, Ncc, Lk] },
            _ => Known { setting, text, methods },
        })
    }
    let scale = Setting::new("scale\0", Shape::Number, (1, 4096), 0);
    let scale_text = "p = exp(-d / scale) of a difference of d gray levels.";
    let pruning = Setting::new("pruning\0", Shape::Switch, (0, 1), 0);
    let pruning_text = "Whether offsets that cannot change the result are skipped; changes only the time.";
    let own = [(scale, scale_text), (pruning, pruning_text)];
    let own = own.into_iter().map(|(setting, text)| Known { setting, text, methods: &[Paper] });
    of::<Config>(&[Paper]).chain(own).chain(of::<robust::Config>(&[Robust]))
}

impl Known {
    fn of(name: &str) -> Option<Self> {
        known().find(|known| known.setting.name() == name)
    }

    fn form(&self) -> String {
        let Setting { shape, lowest, highest, .. } = self.setting;
        let form = match shape {
            Shape::Switch => "on or off".to_owned(),
            Shape::Number => format!("N, {lowest} to {highest}"),
            Shape::Fraction => format!("N/M, N {lowest} to {highest}, M 1 to {highest}"),
            Shape::Radius => format!("XxY, each {lowest} to {highest}"),
            Shape::Margins => format!("LEFTxTOPxRIGHTxBOTTOM, each {lowest} to {highest}"),
        };
        format!("{}={form}", self.setting.name())
    }

    /// Errors: The text has not the form of the setting, or a value is out of range.
    fn values(&self, text: &str) -> Result<Vec<u16>> {
        let shape = self.setting.shape;
        let values: Result<Vec<u16>, _> = match (shape, text) {
            (Shape::Switch, "on") => Ok(vec![1]),
            (Shape::Switch, "off") => Ok(vec![0]),
            _ => text.split(if shape == Shape::Fraction { '/' } else { 'x' }).map(str::parse).collect(),
        };
        let values = values.ok().filter(|values| values.len() == shape.count());
        values.with_context(|| format!("expected {}", self.form()))
    }
}

fn help() -> String {
    let mut help = "A setting of the tracker; of several, once for each".to_owned();
    for setting in known() {
        let methods: Vec<_> = setting.methods.iter().map(|method| method.name()).collect();
        let text = setting.text.split(". ").next().unwrap_or_default().trim_end_matches('.');
        help += &format!("\n{}: {text} [{}]", setting.form(), methods.join(", "));
    }
    help
}

#[derive(Clone, Debug)]
struct Given {
    name: String,
    text: String,
    values: Vec<u16>,
}

impl FromStr for Given {
    type Err = anyhow::Error;

    fn from_str(given: &str) -> Result<Self> {
        let (name, text) = given.split_once('=').context("expected NAME=VALUE, like window=16x16")?;
        let values = Known::of(name).map(|known| known.values(text)).transpose()?;
        Ok(Self { name: name.to_owned(), text: text.to_owned(), values: values.unwrap_or_default() })
    }
}

impl Serialize for Given {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{}={}", self.name, self.text))
    }
}

fn taken_by(name: &str) -> &'static [MethodKind] {
    Known::of(name).map_or(&[MethodKind::Paper, MethodKind::Robust], |known| known.methods)
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
    /// Returns one variant, with the settings given, for each different method in `methods`. Errors: An option applies
    /// to none of `methods`, or is out of range.
    pub fn variants(&self, methods: &[MethodKind]) -> Result<Vec<Variant>> {
        self.check_for(methods)?;
        self.check_ranges()?;
        let configs = self.configs()?;
        let first = |index: usize| !methods[..index].contains(&methods[index]);
        let variant = |index: usize| {
            let kind = methods[index];
            Variant { options: self.options_of(kind), ..Variant::new(kind, &configs) }
        };
        Ok((0..methods.len()).filter(|&index| first(index)).map(variant).collect())
    }

    /// Errors: An option does not apply to the method, or is out of range.
    pub fn variant(&self, method: MethodKind) -> Result<Variant> {
        Ok(self.variants(&[method])?.remove(0))
    }

    /// The method of which `--config` names a preset.
    pub fn method(&self) -> Option<MethodKind> {
        self.config.map(Preset::method)
    }

    fn given(&self) -> Map<String, Value> {
        let Ok(Value::Object(mut given)) = serde_json::to_value(self) else { return Map::new() };
        let defaults = [json!(null), json!([]), json!("paper"), json!("refined")];
        given.retain(|_, value| !defaults.contains(value));
        given
    }

    pub fn says_nothing(&self) -> bool {
        self.given().is_empty()
    }

    fn options_of(&self, method: MethodKind) -> Map<String, Value> {
        let config = self.config.filter(|preset| preset.method() == method);
        let set = self.set.iter().filter(|given| taken_by(&given.name).contains(&method)).cloned().collect();
        let of_core = Self { config, set, ..self.clone() };
        if method.is_core() { of_core.given() } else { Self { set: of_core.set, ..Self::default() }.given() }
    }

    /// Errors: An option or a setting applies to none of `methods`.
    fn check_for(&self, methods: &[MethodKind]) -> Result<()> {
        let names = |methods: &[MethodKind]| methods.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
        if let Some(preset) = self.config.filter(|preset| !methods.contains(&preset.method())) {
            let (name, method) = (choice_name(&preset), preset.method().name());
            bail!("--config {name} is a preset of {method}, not of {}: use --method {method}", names(methods));
        }
        let takes = |taken: &[MethodKind]| methods.iter().any(|method| taken.contains(method));
        for Given { name, text, values } in &self.set {
            if values.is_empty() {
                let settings = known().filter(|setting| takes(setting.methods));
                let settings: Vec<_> = settings.map(|setting| setting.form()).collect();
                bail!("--set {name}={text}: {} has no such setting: expected {}", names(methods), settings.join("; "));
            }
        }
        let settings = self.set.iter().map(|given| format!("set {}", given.name));
        let options = ["backend", "step"].into_iter().filter(|option| self.given().contains_key(*option));
        for option in settings.chain(options.map(str::to_owned)) {
            let taking = taken_by(option.trim_start_matches("set "));
            let (what, names_of) = (if option.starts_with("set ") { "a setting" } else { "an option" }, names(taking));
            ensure!(
                takes(taking),
                "--{option} is {what} of {names_of}, not of {}: use --method {}",
                names(methods),
                taking[0].name()
            );
        }
        Ok(())
    }

    /// Errors: A value is out of the range that the setting has with the preset.
    fn check_ranges(&self) -> Result<()> {
        let robust = self.robust_preset();
        for Given { name, text, values } in &self.set {
            let own = robust.settings().find(|setting| setting.name() == name);
            if let Some(setting) = own.or_else(|| Known::of(name).map(|known| known.setting)) {
                setting.check(values).with_context(|| format!("--set {name}={text}"))?;
            }
        }
        Ok(())
    }

    fn configs(&self) -> Result<Configs> {
        let step = self.step.map_or(u32::MAX, NonZeroU32::get);
        Ok(Configs { paper: self.paper()?, robust: self.robust()?, robust_size: self.robust_size(), step })
    }

    fn paper(&self) -> Result<Config> {
        let mut config = if self.config == Some(Preset::Camera) { Config::camera() } else { Config::paper() };
        config.backend = self.backend;
        let given = |name: &str| self.set.iter().rfind(|given| given.name == name).map(|given| given.values[0]);
        if let Some(scale) = given("scale") {
            // A configuration borrows its table for the life of the program, so the table is leaked.
            config.table = Box::leak(Box::new(Table::new(scale)?));
        }
        if let Some(pruning) = given("pruning") {
            config.pruning = pruning != 0;
        }
        let config = self.put(config)?;
        ensure!(
            (config.window.x, config.window.y) != (0, 0),
            "--set window=0x0: the window is a single position: expected a search radius in pixels, like 16x16"
        );
        config.check().map_err(|error| both(&config, error))?;
        Ok(config)
    }

    fn robust(&self) -> Result<robust::Config> {
        let mut config = self.put(self.robust_preset())?;
        config.backend = self.backend;
        config.check().map_err(|error| both(&config, error))?;
        Ok(config)
    }

    fn robust_preset(&self) -> robust::Config {
        let config = if self.refines() { robust::Config::refined() } else { robust::Config::robust() };
        match self.robust_size() {
            RobustSize::Standard => config,
            RobustSize::Small => config.within::<Small>(),
        }
    }

    /// True unless the preset is one without the refiner.
    fn refines(&self) -> bool {
        !matches!(self.config, Some(Preset::Robust | Preset::Small))
    }

    fn robust_size(&self) -> RobustSize {
        match self.config {
            Some(Preset::Small | Preset::SmallRefined) => RobustSize::Small,
            _ => RobustSize::Standard,
        }
    }

    fn put<C: Settings>(&self, mut config: C) -> Result<C> {
        let is_own = |given: &&Given| C::SETTINGS.iter().any(|setting| setting.name() == given.name);
        for given in self.set.iter().filter(is_own) {
            config.set(&given.name, &given.values)?;
        }
        Ok(config)
    }

    /// Parameters of the robust tracker's reference, which has its own copy of the defaults.
    pub fn robust_reference_numbers(&self) -> robust_reference::Numbers {
        let mut numbers = robust_reference::Numbers::refined();
        if self.robust_size() == RobustSize::Small {
            numbers = numbers.small();
        }
        numbers.refiner = self.refines();
        for Given { name, values, .. } in &self.set {
            numbers.set(name, values[0]);
        }
        numbers
    }

    /// Parameters of the reference of the paper tracker, which has its own copy of the defaults.
    pub fn reference_numbers(&self) -> Numbers {
        let mut numbers = if self.config == Some(Preset::Camera) { Numbers::camera() } else { Numbers::paper() };
        for Given { name, values, .. } in &self.set {
            numbers.set(name, values);
        }
        numbers
    }
}

/// Returns an error with the message of `error`, and with the values of the settings that this message names.
fn both<C: Settings>(config: &C, error: ConfigError) -> anyhow::Error {
    let shown = |setting: &Setting| {
        let values = config.get(setting.name()).unwrap_or_default().map(|value| value.to_string());
        format!("{}={}", setting.name(), values[..setting.shape.count()].join("x"))
    };
    let text = error.to_string();
    let named = C::SETTINGS.iter().filter(|setting| text.split(' ').any(|word| word == setting.name()));
    anyhow!("--set: {text}: expected other values than {}", named.map(shown).collect::<Vec<_>>().join(", "))
}

/// Two numbers like `60x50`, for example a width and a height.
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
        let pair = text.split_once('x').and_then(|(x, y)| Some(Self(x.parse().ok()?, y.parse().ok()?)));
        pair.context("expected two whole numbers like 60x50, each at most 65535")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reference would otherwise keep its default, and `check --set` would compare two settings.
    #[test]
    fn every_setting_reaches_the_reference() {
        let differ = |name: &str, [low, high]: [(bool, String); 2]| {
            assert!(low.0 && high.0, "the reference does not know {name}");
            assert_ne!(low.1, high.1, "{name} changes nothing");
        };
        for Known { setting, methods, .. } in known() {
            let (name, range) = (setting.name(), [setting.lowest, setting.highest]);
            match methods[0] {
                // Pruning changes only the time.
                MethodKind::Paper if name == "pruning" => {}
                MethodKind::Paper => differ(
                    name,
                    range.map(|value| {
                        let mut numbers = Numbers::paper();
                        (numbers.set(name, &[value; 4]), format!("{numbers:?}"))
                    }),
                ),
                _ => differ(
                    name,
                    range.map(|value| {
                        let mut numbers = robust_reference::Numbers::refined();
                        (numbers.set(name, value), format!("{numbers:?}"))
                    }),
                ),
            }
        }
    }
}
