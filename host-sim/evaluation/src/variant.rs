//! A tracker with its settings, under the name that it has in results.

use super::Paper;
use super::baseline::Baseline;
use super::method::{Method, MethodAnswer, MethodKind};
use super::table::Column;
use anyhow::Result;
use clap::ValueEnum;
use serde::Serialize;
use serde_json::{Map, Value};
use smr_core::paper::{Config, Fraction};
use smr_core::robust::Small;
use smr_core::{Frame, Quality, Rect, Robust, Target, Windows, robust};
use std::cell::RefCell;
use std::rc::Rc;

/// The size of the robust tracker's memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RobustSize {
    #[default]
    Standard,
    Small,
}

#[derive(Clone, Copy, Debug)]
pub struct Configs {
    /// Settings of the paper tracker; the baselines take window and padding from them.
    pub paper: Config,
    pub robust: robust::Config,
    pub robust_size: RobustSize,
    /// Approximate work per step of an update, in units of `Tracker::work`. It changes no answer. Baselines ignore it.
    pub step: u32,
}

impl From<Config> for Configs {
    fn from(paper: Config) -> Self {
        Self { paper, robust: robust::Config::refined(), robust_size: RobustSize::default(), step: u32::MAX }
    }
}

impl From<robust::Config> for Configs {
    fn from(robust: robust::Config) -> Self {
        Self { robust, ..Config::paper().into() }
    }
}

#[derive(Clone, Debug)]
pub struct Variant {
    pub name: String,
    pub kind: MethodKind,
    pub configs: Configs,
    /// Settings that were given on the command line.
    pub options: Map<String, Value>,
    /// True if the start box includes its right and lower edges.
    pub inclusive: bool,
}

/// The tracker behind a result, as the printed JSON states it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Origin {
    pub version: &'static str,
    pub method: &'static str,
    /// Settings that were given on the command line; all other settings have their defaults.
    pub options: Map<String, Value>,
}

impl Origin {
    /// Table columns of the origin; the options are one text cell that holds JSON.
    pub(super) const COLUMNS: &[Column<Self>] = &[
        ("method", "", 0, |origin| origin.method.into()),
        ("version", "", 0, |origin| origin.version.into()),
        ("options", "", 0, |origin| Value::from(origin.options.clone()).to_string().into()),
    ];

    pub fn new(kind: MethodKind, options: Map<String, Value>) -> Self {
        Self { version: env!("CARGO_PKG_VERSION"), method: kind.name(), options }
    }
}

impl Variant {
    pub fn new(kind: MethodKind, configs: &Configs) -> Self {
        Self { name: kind.name().to_owned(), kind, configs: *configs, options: Map::new(), inclusive: false }
    }

    pub fn origin(&self) -> Origin {
        Origin::new(self.kind, self.options.clone())
    }

    /// Returns the trackers for the paper's table: SMR (k = 1/4), SMR (k = 7/20, inclusive boxes), robust, baselines.
    pub fn all() -> Vec<Self> {
        let paper = Config::paper();
        let mut other = paper;
        other.k = Fraction::new(7, 20);
        let options =
            Map::from_iter([("set".to_owned(), ["k=7/20"].as_slice().into()), ("inclusive".to_owned(), true.into())]);
        let name = "paper, k = 7/20, inclusive".to_owned();
        let other = Self { name, inclusive: true, options, ..Self::new(MethodKind::Paper, &other.into()) };
        let of_kind = |&kind: &MethodKind| Self::new(kind, &paper.into());
        let mut all: Vec<Self> = MethodKind::value_variants().iter().map(of_kind).collect();
        all.insert(1, other);
        all
    }

    /// Returns the box to lock on for the start box `given`: one pixel wider and higher if `inclusive`.
    pub fn start(&self, given: Rect) -> Rect {
        let more = u16::from(self.inclusive);
        let (width, height) = (given.width.saturating_add(more), given.height.saturating_add(more));
        Rect { width, height, ..given }
    }

    pub fn build(&self) -> Result<Box<dyn Method>> {
        Ok(self.build_all(1)?.remove(0))
    }

    /// Builds trackers for `count` targets of one recording. Those of smr-core share one workspace, as in firmware.
    pub fn build_all(&self, count: usize) -> Result<Vec<Box<dyn Method>>> {
        let (kind, Configs { paper, robust, robust_size, step }) = (self.kind, self.configs);
        match kind {
            MethodKind::Paper => stepped::<Paper>(kind, count, paper, step),
            MethodKind::Robust => match robust_size {
                RobustSize::Standard => stepped::<Robust>(kind, count, robust, step),
                RobustSize::Small => stepped::<Robust<Small>>(kind, count, robust, step),
            },
            _ => several(count, || Ok(Baseline::new(kind, &paper))),
        }
    }
}

fn several<M: Method + 'static>(count: usize, one: impl Fn() -> Result<M>) -> Result<Vec<Box<dyn Method>>> {
    (0..count).map(|_| Ok(Box::new(one()?) as Box<dyn Method>)).collect()
}

fn stepped<T: Target + 'static>(
    kind: MethodKind,
    count: usize,
    config: T::Config,
    step: u32,
) -> Result<Vec<Box<dyn Method>>> {
    let workspace = Rc::default();
    several(count, || {
        let target = T::with(config)?;
        Ok(Stepped::<T> { kind, target, workspace: Rc::clone(&workspace), step, most_pixels: 0 })
    })
}

struct Stepped<T: Target> {
    kind: MethodKind,
    target: T,
    workspace: Rc<RefCell<T::Workspace>>,
    step: u32,
    most_pixels: usize,
}

impl<T: Target> Method for Stepped<T> {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.target.lock(&mut self.workspace.borrow_mut(), frame, target)?;
        let window = Windows::new(self.target.lock_window(frame.bounds(), target), None);
        self.most_pixels = self.most_pixels.max(window.pixels());
        Ok(())
    }

    fn most_pixels(&self) -> usize {
        self.most_pixels
    }

    fn quality(&self) -> Option<Quality> {
        self.target.quality()
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<MethodAnswer> {
        let pixels = self.target.windows().map_or(0, |windows| windows.pixels());
        self.most_pixels = self.most_pixels.max(pixels);
        let workspace = &mut self.workspace.borrow_mut();
        loop {
            if let Some(answer) = self.target.update_step(workspace, frame, self.step)? {
                return Ok(MethodAnswer { work: Some(T::work(workspace)), ..answer.into() });
            }
        }
    }
}
