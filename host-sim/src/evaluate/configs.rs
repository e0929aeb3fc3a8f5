//! What methods are built from: the numbers of the paper's tracker, and those of the robust one where it is asked for.

use super::method::{Method, MethodKind, State};
use anyhow::Result;
use smr_core::{Config, robust};

/// The configurations of all methods.
#[derive(Clone, Copy, Debug)]
pub struct Configs {
    /// The paper's tracker's; the baselines take window and padding from it.
    pub paper: Config,
    /// Where there is one, `smr` is the robust tracker.
    pub robust: Option<robust::Config>,
}

impl From<Config> for Configs {
    fn from(paper: Config) -> Self {
        Self { paper, robust: None }
    }
}

impl Configs {
    /// The states that `smr` can be in, the best one first.
    #[must_use]
    pub const fn states(&self) -> [State; 3] {
        let between = if self.robust.is_some() { State::Uncertain } else { State::Leaving };
        [State::Tracking, between, State::Lost]
    }
}

/// A method with what it is built from, under the name that it has in results.
#[derive(Clone, Debug)]
pub struct Variant {
    pub name: String,
    kind: MethodKind,
    configs: Configs,
}

impl Variant {
    /// `kind`, under its own name.
    #[must_use]
    pub fn new(kind: MethodKind, configs: &Configs) -> Self {
        Self { name: kind.name(configs).to_owned(), kind, configs: *configs }
    }

    /// The robust tracker with other parts than all, which `name` tells.
    #[must_use]
    pub fn robust(name: String, config: robust::Config) -> Self {
        let configs = Configs { robust: Some(config), ..Config::paper().into() };
        Self { name, kind: MethodKind::Smr, configs }
    }

    /// # Errors
    /// A number of the configuration that SMR cannot use.
    pub fn build(&self) -> Result<Box<dyn Method>> {
        self.kind.build(&self.configs)
    }
}
