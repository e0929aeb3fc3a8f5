//! The paper tracker with small sizes and with configurations of every kind.

use crate::extent::Extent;
use crate::scene::Scene;
use crate::{Fuzzed, Start, mostly};
use arbitrary::{Result, Unstructured};
use smr_core::paper::{Config, Fraction, Margins, Radius};
use smr_core::similarity::{Backend, Table};
use std::sync::LazyLock;

/// The paper tracker with limits small enough for many executions of a fuzz target per second.
pub(crate) type Small = smr_core::Paper<256, 41>;

static TABLES: LazyLock<[Table; 4]> =
    LazyLock::new(|| [255, 1, 40, 4096].map(|scale| Table::new(scale).expect("a scale in the range")));

pub(crate) fn table(u: &mut Unstructured<'_>) -> Result<&'static Table> {
    u.choose(&*TABLES)
}

/// Returns the fastest backend (`None`) or any that the machine has.
pub(crate) fn backend(u: &mut Unstructured<'_>) -> Result<Option<Backend>> {
    static ALL: LazyLock<Vec<Backend>> = LazyLock::new(|| Backend::available().collect());
    let chosen = ALL.get(usize::from(u.int_in_range(0..=7_u8)?)).copied();
    Ok(chosen)
}

fn fraction(u: &mut Unstructured<'_>) -> Result<Fraction> {
    let denominator = if u.ratio(1, 64)? { 0 } else { mostly(u, 1..=100)? };
    Ok(Fraction::new(mostly(u, 0..=130)?, denominator))
}

fn radius(u: &mut Unstructured<'_>, range: std::ops::RangeInclusive<u16>) -> Result<Radius> {
    Ok(Radius { x: mostly(u, range.clone())?, y: mostly(u, range)? })
}

impl Fuzzed for Small {
    const SIZE_AT: usize = 78;
    const PACE: usize = 0;

    fn configuration(u: &mut Unstructured<'_>, extent: &Extent) -> Result<Config> {
        let mut config = if u.arbitrary()? { Config::paper() } else { Config::camera() };
        config.window = radius(u, 0..=extent.window)?;
        config.window_limit = config.window;
        config.backend = backend(u)?;
        let what: u8 = u.arbitrary()?;
        let asked = |bit: u8| what & (1 << bit) != 0;
        if asked(0) {
            let grown = radius(u, 0..=extent.grown)?;
            config.window_limit = Radius { x: config.window.x.max(grown.x), y: config.window.y.max(grown.y) };
            config.growth = mostly(u, 0..=4)?;
        }
        if asked(1) {
            config.padding = mostly(u, 0..=30)?;
        }
        if asked(2) {
            config.table = table(u)?;
            (config.k, config.first_threshold, config.least_threshold) = (fraction(u)?, u.arbitrary()?, u.arbitrary()?);
        }
        if asked(3) {
            (config.gate_tracking, config.gate_leaving) = (fraction(u)?, fraction(u)?);
            (config.gate_returning, config.gate_lost) = (fraction(u)?, fraction(u)?);
            (config.gate_lead, config.least_ratio) = (mostly(u, 0..=200)?, u.arbitrary()?);
        }
        if asked(4) {
            config.neighbourhood = mostly(u, 0..=20)?;
        }
        if asked(5) {
            config.update_zone = Margins {
                left: mostly(u, 0..=20)?,
                top: mostly(u, 0..=20)?,
                right: mostly(u, 0..=20)?,
                bottom: mostly(u, 0..=20)?,
            };
        }
        config.runner_up_always = asked(6);
        config.pruning = !asked(7);
        Ok(config)
    }

    fn by(mut config: Config, backend: Option<Backend>) -> Config {
        config.backend = backend;
        config
    }

    fn usual() -> Config {
        let mut config = Config::camera();
        config.window = Radius { x: 4, y: 5 };
        config.window_limit = Radius { x: 9, y: 7 };
        config
    }

    fn plain(config: Config) -> Config {
        let mut plain = config;
        (plain.backend, plain.pruning) = (Some(Backend::Scalar), false);
        plain
    }

    fn locked() -> &'static [(Scene, Vec<u8>)] {
        static LOCKED: LazyLock<Vec<(Scene, Vec<u8>)>> = LazyLock::new(crate::saved::locked::<Small>);
        &LOCKED
    }

    fn starts() -> &'static [Start<Config>] {
        &[]
    }

    fn beside(_: &mut Unstructured<'_>) -> Result<bool> {
        Ok(true)
    }
}
