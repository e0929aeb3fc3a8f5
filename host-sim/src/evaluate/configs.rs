//! What methods are built from: the numbers of the paper's tracker, and those of the robust one where it is asked for.

use super::method::{Method, MethodKind, State};
use anyhow::Result;
use clap::ValueEnum;
use smr_core::{Config, Fraction, Rect, robust};

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
    inclusive: bool,
}

impl Variant {
    /// `kind`, under its own name.
    #[must_use]
    pub fn new(kind: MethodKind, configs: &Configs) -> Self {
        Self { name: kind.name(configs).to_owned(), kind, configs: *configs, inclusive: false }
    }

    /// The robust tracker with other parts than all, which `name` tells.
    #[must_use]
    pub fn robust(name: String, config: robust::Config) -> Self {
        let configs = Configs { robust: Some(config), ..Config::paper().into() };
        Self { name, kind: MethodKind::Smr, configs, inclusive: false }
    }

    /// All that is set beside each other: both readings of the paper, the baselines, and the robust tracker.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let paper = Config::paper();
        let mut other = paper;
        other.k = Fraction::new(7, 20);
        let other = Self {
            name: "smr, k = 7/20, inclusive".to_owned(),
            inclusive: true,
            ..Self::new(MethodKind::Smr, &other.into())
        };
        let of_kind = |&kind: &MethodKind| Self::new(kind, &paper.into());
        let mut all: Vec<Self> = MethodKind::value_variants().iter().map(of_kind).collect();
        all.insert(1, other);
        all.push(Self::robust("robust".to_owned(), robust::Config::robust()));
        all
    }

    /// The box that it is locked on where `given` is the one to start from.
    #[must_use]
    pub fn start(&self, given: Rect) -> Rect {
        let more = u16::from(self.inclusive);
        let (width, height) = (given.width.saturating_add(more), given.height.saturating_add(more));
        Rect { width, height, ..given }
    }

    /// # Errors
    /// A number of the configuration that SMR cannot use.
    pub fn build(&self) -> Result<Box<dyn Method>> {
        self.kind.build(&self.configs)
    }
}
