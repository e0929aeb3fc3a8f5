//! The two trackers of smr-core by their names on the command line, for commands that the baselines are not for.

use super::MethodKind;
use clap::ValueEnum;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CoreKind {
    /// The Similarity Matching Ratio, as in the paper
    #[default]
    Smr,
    /// Beyond the paper: holds when light, size and view change
    Robust,
}

impl From<CoreKind> for MethodKind {
    fn from(method: CoreKind) -> Self {
        match method {
            CoreKind::Smr => Self::Smr,
            CoreKind::Robust => Self::Robust,
        }
    }
}
