//! What methods are built from: the numbers of both trackers of smr-core.

use super::method::MethodKind;
use super::tables::Columns;
use clap::ValueEnum;
use serde::Serialize;
use serde_json::{Map, Value};
use smr_core::paper::{Config, Fraction};
use smr_core::{Rect, robust};

#[derive(Clone, Copy, Debug)]
pub struct Configs {
    /// The paper's tracker's; the baselines take window and padding from it.
    pub paper: Config,
    pub robust: robust::Config,
    /// The work of a step in which smr-core's trackers are updated; it changes no answer.
    pub step: u32,
}

impl From<Config> for Configs {
    fn from(paper: Config) -> Self {
        Self { paper, robust: robust::Config::refined(), step: u32::MAX }
    }
}

impl From<robust::Config> for Configs {
    fn from(robust: robust::Config) -> Self {
        Self { robust, ..Config::paper().into() }
    }
}

/// A method with what it is built from, under the name that it has in results.
#[derive(Clone, Debug)]
pub struct Variant {
    pub name: String,
    pub kind: MethodKind,
    pub configs: Configs,
    /// As on the command line, where they are given.
    pub options: Map<String, Value>,
    /// Whether the right and lower edges of the box to start from belong to it.
    pub inclusive: bool,
}

/// What a figure or an answer is of: in the JSON objects that are printed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Origin {
    pub version: &'static str,
    pub method: &'static str,
    /// The options that were given to it; what is not in here has its default.
    pub options: Map<String, Value>,
}

impl Origin {
    /// Its columns in a table. The options are a text, itself JSON.
    pub(super) fn columns<'a>() -> Columns<'a, Self> {
        Columns::new(&[
            ("method", "", |origin| origin.method.into()),
            ("version", "", |origin| origin.version.into()),
            ("options", "", |origin| Value::from(origin.options.clone()).to_string().into()),
        ])
    }

    pub fn new(kind: MethodKind, options: Map<String, Value>) -> Self {
        Self { version: env!("CARGO_PKG_VERSION"), method: kind.name(), options }
    }
}

impl Variant {
    /// `kind`, under its own name.
    pub fn new(kind: MethodKind, configs: &Configs) -> Self {
        Self { name: kind.name().to_owned(), kind, configs: *configs, options: Map::new(), inclusive: false }
    }

    pub fn origin(&self) -> Origin {
        Origin::new(self.kind, self.options.clone())
    }

    /// All that is set beside each other: both readings of the paper, the robust tracker, and the baselines.
    pub fn all() -> Vec<Self> {
        let paper = Config::paper();
        let mut other = paper;
        other.k = Fraction::new(7, 20);
        let options =
            Map::from_iter([("set".to_owned(), ["k=7/20"].as_slice().into()), ("inclusive".to_owned(), true.into())]);
        let name = "smr, k = 7/20, inclusive".to_owned();
        let other = Self { name, inclusive: true, options, ..Self::new(MethodKind::Smr, &other.into()) };
        let of_kind = |&kind: &MethodKind| Self::new(kind, &paper.into());
        let mut all: Vec<Self> = MethodKind::value_variants().iter().map(of_kind).collect();
        all.insert(1, other);
        all
    }

    /// The box that it is locked on where `given` is the one to start from.
    pub fn start(&self, given: Rect) -> Rect {
        let more = u16::from(self.inclusive);
        let (width, height) = (given.width.saturating_add(more), given.height.saturating_add(more));
        Rect { width, height, ..given }
    }
}
