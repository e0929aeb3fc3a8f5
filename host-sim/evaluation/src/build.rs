//! Builds the tracker of each [`MethodKind`]: those of smr-core, updated in steps, and the baselines.

use super::baseline::{Baseline, Flow, Measure};
use super::configs::{Configs, Variant};
use super::method::{Method, MethodKind, Report};
use crate::Paper;
use anyhow::Result;
use smr_core::{Frame, Quality, Rect, Robust, Target};
use std::cell::RefCell;
use std::rc::Rc;

impl MethodKind {
    /// A tracker without a target.
    pub fn build(self, configs: &Configs) -> Result<Box<dyn Method>> {
        let baseline = |measure| Box::new(Baseline::new(measure, &configs.paper));
        Ok(match self {
            Self::Smr => Box::new(Stepped::<Paper>::new(self, configs.paper, configs.step, &Rc::default())?),
            Self::Robust => Box::new(Stepped::<Robust>::new(self, configs.robust, configs.step, &Rc::default())?),
            Self::Sad => baseline(Measure::Absolute),
            Self::Ssd => baseline(Measure::Squared),
            Self::Ncc => baseline(Measure::Correlation),
            Self::Lk => Box::new(Flow::new(&configs.paper)),
        })
    }

    /// So many trackers for the targets of one recording. Those of smr-core share one workspace, as in firmware.
    fn build_all(self, count: usize, configs: &Configs) -> Result<Vec<Box<dyn Method>>> {
        match self {
            Self::Smr => stepped::<Paper>(self, count, configs.paper, configs.step),
            Self::Robust => stepped::<Robust>(self, count, configs.robust, configs.step),
            _ => (0..count).map(|_| self.build(configs)).collect(),
        }
    }
}

impl Variant {
    pub fn build(&self) -> Result<Box<dyn Method>> {
        self.kind.build(&self.configs)
    }

    /// As many, for the targets of one recording.
    pub fn build_all(&self, count: usize) -> Result<Vec<Box<dyn Method>>> {
        self.kind.build_all(count, &self.configs)
    }
}

fn stepped<T: Target + 'static>(
    kind: MethodKind,
    count: usize,
    config: T::Config,
    step: u32,
) -> Result<Vec<Box<dyn Method>>> {
    let workspace = Rc::default();
    (0..count).map(|_| Ok(Box::new(Stepped::<T>::new(kind, config, step, &workspace)?) as Box<dyn Method>)).collect()
}

/// A target of smr-core, updated in steps of so much work.
struct Stepped<T: Target> {
    kind: MethodKind,
    target: T,
    workspace: Rc<RefCell<T::Workspace>>,
    step: u32,
}

impl<T: Target> Stepped<T> {
    fn new(kind: MethodKind, config: T::Config, step: u32, workspace: &Rc<RefCell<T::Workspace>>) -> Result<Self> {
        Ok(Self { kind, target: T::new(config)?, workspace: Rc::clone(workspace), step })
    }
}

impl<T: Target> Method for Stepped<T> {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.target.lock(&mut self.workspace.borrow_mut(), frame, target)?;
        Ok(())
    }

    fn quality(&self) -> Option<Quality> {
        self.target.quality()
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        let workspace = &mut self.workspace.borrow_mut();
        let mut update = self.target.begin(workspace, frame)?;
        while !update.step(self.step) {}
        let answer = update.finish();
        Ok(Report { work: Some(T::work(workspace)), ..answer.into() })
    }
}
