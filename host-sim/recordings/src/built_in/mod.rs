//! Built-in recordings: the drawn scenes as sequences with ground truth.

pub(crate) mod border;
pub(crate) mod noise;
pub(crate) mod periodic;
pub mod street;
pub mod synthetic;
pub(crate) mod tiles;

use crate::sequence::Sequence;
use std::path::Path;

pub const BUILT_IN: [&str; 6] = [street::NAME, synthetic::NAME, periodic::NAME, border::NAME, noise::NAME, tiles::NAME];

/// Names of the built-in recordings that test smr-core, without `noise`, which has no target and is only for timing.
pub const CHECKED: [&str; 3] = [synthetic::NAME, periodic::NAME, border::NAME];

pub(crate) fn built_in(path: &Path) -> Option<Sequence> {
    let made =
        [street::sequence, synthetic::sequence, periodic::sequence, border::sequence, noise::sequence, tiles::sequence];
    let exact = BUILT_IN.iter().zip(made).find(|(name, _)| path == Path::new(name)).map(|(_, made)| made());
    exact.or_else(|| synthetic::seeded(path.to_str()?))
}
