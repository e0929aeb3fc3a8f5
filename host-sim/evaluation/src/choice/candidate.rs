//! The trackers among which `eval --chip` chooses, with their settings in each language.

use crate::{Configs, MethodKind, RobustSize, Variant};
use smr_core::robust::Small;
use smr_core::{ConfigError, Paper, Robust, Steps, Tracker as Whole, paper, robust};

/// The trackers whose cycles are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracker {
    Paper,
    Robust,
    /// The robust tracker with the refiner.
    Refined,
}

#[derive(Clone, Debug)]
pub struct Candidate {
    pub tracker: Tracker,
    pub variant: Variant,
    /// Lines in Rust, with the box's largest area as `PIXELS`.
    rust: &'static str,
    c: &'static str,
    pub python: &'static str,
    /// Options of host-sim.
    pub options: &'static str,
    /// Bytes of target and workspace for a box without pixels.
    bytes: usize,
    /// Bytes for each pixel of the largest box.
    bytes_per_pixel: usize,
}

/// Area of the largest box of the paper tracker in the lines of code below.
const PIXELS: usize = 1024;
/// `SMR_PIXELS` of smr's C library, unless it is built with another number.
const C_PIXELS: usize = 4096;
/// Bytes of the refiner in a target and in a workspace. Here all trackers have them.
const REFINER: usize = 1056 + 24;

/// A tracker in Rust, which is compiled as it stands.
struct Line<C> {
    config: C,
    rust: &'static str,
    /// Bytes of target and workspace.
    bytes: usize,
}

macro_rules! line {
    ($target:ty, $config:expr) => {{
        const _: fn() -> Result<Whole<$target>, ConfigError> = || Whole::with($config);
        Line {
            config: $config,
            rust: concat!("let mut tracker = Tracker::<", stringify!($target), ">::with(", stringify!($config), ")?;"),
            bytes: size_of::<$target>() + size_of::<<$target as Steps>::Workspace>(),
        }
    }};
    ($target:ty, $config:expr, $setting:ident = $value:literal) => {{
        let mut config = $config;
        config.$setting = $value;
        Line {
            config,
            rust: concat!(
                "let mut config = ",
                stringify!($config),
                "; config.",
                stringify!($setting = $value),
                "; let mut tracker = Tracker::<",
                stringify!($target),
                ">::with(config)?;"
            ),
            ..line!($target, $config)
        }
    }};
}

impl Candidate {
    fn paper(name: &str, line: Line<paper::Config>, words: [&'static str; 3]) -> Self {
        let line = Line { bytes: line.bytes - 2 * PIXELS, ..line };
        Self { bytes_per_pixel: 2, ..Self::of(name, Tracker::Paper, line.config.into(), line, words) }
    }

    fn robust(name: &str, robust_size: RobustSize, line: Line<robust::Config>, words: [&'static str; 3]) -> Self {
        let (tracker, unused) = if line.config.refiner { (Tracker::Refined, 0) } else { (Tracker::Robust, REFINER) };
        let configs = Configs { robust_size, ..line.config.into() };
        Self::of(name, tracker, configs, Line { bytes: line.bytes - unused, ..line }, words)
    }

    fn of<C>(
        name: &str,
        tracker: Tracker,
        configs: Configs,
        Line { rust, bytes, .. }: Line<C>,
        [c, python, options]: [&'static str; 3],
    ) -> Self {
        let kind = if tracker == Tracker::Paper { MethodKind::Paper } else { MethodKind::Robust };
        let variant = Variant { name: name.to_owned(), ..Variant::new(kind, &configs) };
        Self { tracker, variant, rust, c, python, options, bytes, bytes_per_pixel: 0 }
    }

    pub fn all() -> Vec<Self> {
        use RobustSize::{Small as SmallSize, Standard};
        vec![
            Self::paper(
                "paper +-16",
                line!(Paper<PIXELS, 33>, paper::Config::camera_within(16)),
                [
                    "smr_config_camera(&config); config.paper.window.x = config.paper.window.y = 16; \
                     config.paper.window_limit = config.paper.window;",
                    "smr.Paper(\"camera\", window=(16, 16), window_limit=(16, 16))",
                    "--config camera --set window=16x16 --set window_limit=16x16",
                ],
            ),
            Self::paper(
                "paper +-60x50",
                line!(Paper<PIXELS, 161>, paper::Config::camera()),
                ["smr_config_camera(&config);", "smr.Paper(\"camera\")", "--config camera"],
            ),
            Self::robust(
                "small, reach 5",
                SmallSize,
                line!(Robust<Small>, robust::Config::robust().within::<Small>(), reach = 5),
                [
                    "smr_config_small(&config); config.robust.reach = 5;",
                    "smr.Robust(\"small\", reach=5)",
                    "--config small --set reach=5",
                ],
            ),
            Self::robust(
                "small",
                SmallSize,
                line!(Robust<Small>, robust::Config::robust().within::<Small>()),
                ["smr_config_small(&config);", "smr.Robust(\"small\")", "--config small"],
            ),
            Self::robust(
                "robust",
                Standard,
                line!(Robust, robust::Config::robust()),
                ["smr_config_robust(&config);", "smr.Robust(\"robust\")", "--config robust"],
            ),
            Self::robust(
                "small-refined, reach 5",
                SmallSize,
                line!(Robust<Small>, robust::Config::refined().within::<Small>(), reach = 5),
                [
                    "smr_config_small_refined(&config); config.robust.reach = 5;",
                    "smr.Robust(\"small_refined\", reach=5)",
                    "--config small-refined --set reach=5",
                ],
            ),
            Self::robust(
                "small-refined",
                SmallSize,
                line!(Robust<Small>, robust::Config::refined().within::<Small>()),
                ["smr_config_small_refined(&config);", "smr.Robust(\"small_refined\")", "--config small-refined"],
            ),
            Self::robust(
                "refined",
                Standard,
                line!(Robust, robust::Config::refined()),
                ["smr_config_refined(&config);", "smr.Robust(\"refined\")", "--config refined"],
            ),
        ]
    }

    /// True of the trackers whose cycles are measured.
    #[cfg(test)]
    pub const fn is_measured_on_chips(&self) -> bool {
        match self.tracker {
            Tracker::Paper => self.variant.configs.paper.window.x == 16,
            Tracker::Robust | Tracker::Refined => matches!(self.variant.configs.robust_size, RobustSize::Standard),
        }
    }

    /// Returns the bytes of target and workspace, if the box has at most `area` pixels.
    pub const fn bytes(&self, area: usize) -> usize {
        self.bytes + self.bytes_per_pixel * area.next_multiple_of(8)
    }

    /// Returns the lines in C, if the box has at most `area` pixels.
    pub fn c(&self, area: usize) -> String {
        if self.tracker == Tracker::Paper && area > C_PIXELS {
            return format!("{} /* in a library built with SMR_PIXELS={area} */", self.c);
        }
        self.c.to_owned()
    }

    /// Returns the lines in Rust, if the box has at most `area` pixels.
    pub fn rust(&self, area: usize) -> String {
        self.rust.replace("PIXELS", &area.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_core::Settings;

    /// Changes the settings in the words of Python: `smr.Robust("small", reach=5)`.
    fn put<C: Settings>(mut config: C, python: &str) -> C {
        let options = python.trim_end_matches(')').split_once("\", ").map_or("", |(_, options)| options);
        for option in options.split("), ").filter(|option| !option.is_empty()) {
            let (name, values) = option.split_once('=').unwrap();
            let values = values.trim_start_matches('(').split(", ").map(|value| value.parse().unwrap());
            config.set(name, &values.collect::<Vec<u16>>()).unwrap();
        }
        config
    }

    #[test]
    fn the_words_of_each_language_name_the_same_settings() {
        for Candidate { tracker, variant, python, c, options, rust, .. } in Candidate::all() {
            let preset = python.split('"').nth(1).unwrap();
            assert!(c.starts_with(&format!("smr_config_{preset}(&config);")), "{c}");
            assert!(options.starts_with(&format!("--config {}", preset.replace('_', "-"))), "{options}");
            let Configs { paper, robust, robust_size, .. } = variant.configs;
            if tracker == Tracker::Paper {
                let numbers = |config: paper::Config| (config.window, config.window_limit, config.least_ratio);
                assert_eq!(numbers(put(paper::Config::camera(), python)), numbers(paper), "{python}");
                continue;
            }
            let config = if tracker == Tracker::Refined { robust::Config::refined() } else { robust::Config::robust() };
            let is_small = preset.starts_with("small");
            let config = if is_small { config.within::<Small>() } else { config };
            assert_eq!(put(config, python), robust, "{python}");
            assert_eq!(is_small, robust_size == RobustSize::Small, "{python}");
            assert_eq!(is_small, rust.contains("Robust<Small>"), "{rust}");
        }
    }

    #[test]
    fn the_memory_is_that_of_the_types() {
        let bytes = |name: &str, area| {
            Candidate::all().iter().find(|candidate| candidate.variant.name == name).unwrap().bytes(area)
        };
        // The rows of the table "Memory" in core/README.md.
        assert_eq!((bytes("paper +-16", 1024), bytes("paper +-16", 4096)), (1192 + 2512, 4264 + 5584));
        assert_eq!(bytes("paper +-60x50", 4096), 4264 + 8144);
        assert_eq!((bytes("robust", 0), bytes("refined", 0)), (11376 + 39248, 12432 + 39272));
        assert_eq!((bytes("small", 0), bytes("small-refined", 0)), (9248 + 34200, 10304 + 34224));
    }

    #[test]
    fn one_candidate_of_each_tracker_was_measured() {
        for tracker in [Tracker::Paper, Tracker::Robust, Tracker::Refined] {
            let own = Candidate::all().into_iter().filter(|one| one.tracker == tracker && one.is_measured_on_chips());
            assert_eq!(own.count(), 1, "{tracker:?}");
        }
    }
}
