//! The robust tracker with configurations of every kind.

use crate::extent::Extent;
use crate::scene::Scene;
use crate::{Fuzzed, Start, mostly, paper, saved};
use arbitrary::{Result, Unstructured};
use smr_core::Robust;
use smr_core::robust::{Config, Size, Small, Standard};
use smr_core::similarity::Backend;
use std::sync::LazyLock;

/// A size, with the saved targets of its trackers.
pub(crate) trait FuzzedSize: Size {
    fn locked() -> &'static [(Scene, Vec<u8>)];
    fn starts() -> &'static [Start<Config>];
}

macro_rules! fuzzed_size {
    ($($size:ident),+) => {$(
        impl FuzzedSize for $size {
            fn locked() -> &'static [(Scene, Vec<u8>)] {
                static LOCKED: LazyLock<Vec<(Scene, Vec<u8>)>> = LazyLock::new(saved::locked::<Robust<$size>>);
                &LOCKED
            }

            fn starts() -> &'static [Start<Config>] {
                static STARTS: LazyLock<Vec<Start<Config>>> = LazyLock::new(starts::<$size>);
                &STARTS
            }
        }
    )+};
}

fuzzed_size! { Standard, Small }

fn starts<S: FuzzedSize>() -> Vec<Start<Config>> {
    // Four configurations: the usual one; one that always loses the target, so that redetection runs; one without scale
    // search; one with the largest learning rates.
    let mut configs = [Robust::<S>::usual(); 4];
    (configs[1].lost_below, configs[1].uncertain_below) = (u16::MAX, u16::MAX);
    configs[2].size = false;
    (configs[3].learning_rate, configs[3].early_rate) = (256, 1024);
    let made = configs.into_iter().flat_map(|config| {
        let all = saved::locked_by::<Robust<S>>(config).into_iter();
        all.map(move |(scene, saved)| Start { config, scene, saved })
    });
    made.collect()
}

impl<S: FuzzedSize> Fuzzed for Robust<S> {
    const SIZE_AT: usize = 40;
    const PACE: usize = 1;

    fn configuration(u: &mut Unstructured<'_>, _: &Extent) -> Result<Config> {
        let mut config = Config::refined().within::<S>();
        config.reach = if u.ratio(1, 8)? { u.arbitrary()? } else { u.int_in_range(4..=5)? };
        config.backend = paper::backend(u)?;
        let what: u8 = u.arbitrary()?;
        let asked = |bit: u8| what & (1 << bit) != 0;
        (config.size, config.sweep, config.refiner) =
            (!asked(0), if asked(1) { u.int_in_range(0..=8)? } else { 4 }, !asked(6));
        if asked(2) {
            config.table = paper::table(u)?;
        }
        if asked(3) {
            config.patience = u.arbitrary()?;
        }
        if asked(4) {
            (config.lost_below, config.uncertain_below) = (u.arbitrary()?, u.arbitrary()?);
        }
        if asked(5) {
            (config.learning_rate, config.early_rate) = (mostly(u, 0..=256)?, mostly(u, 0..=1024)?);
        }
        Ok(config)
    }

    fn by(mut config: Config, backend: Option<Backend>) -> Config {
        config.backend = backend;
        config
    }

    fn usual() -> Config {
        let mut config = Config::refined().within::<S>();
        config.reach = 4;
        config
    }

    fn plain(config: Config) -> Config {
        let mut plain = config;
        plain.backend = Some(Backend::Scalar);
        plain
    }

    fn locked() -> &'static [(Scene, Vec<u8>)] {
        S::locked()
    }

    fn starts() -> &'static [Start<Config>] {
        S::starts()
    }

    fn beside(u: &mut Unstructured<'_>) -> Result<bool> {
        u.ratio(1, 16)
    }
}
