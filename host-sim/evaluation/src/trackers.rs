//! Builds the tracker of each [`MethodKind`]: those of smr-core, updated in steps, and the baselines.

use super::baseline::{Baseline, Flow, Measure};
use super::configs::{Configs, Variant};
use super::method::{Method, MethodKind, Report};
use crate::Paper;
use anyhow::Result;
use smr_core::{Frame, Quality, Rect, Robust, Target, calls};
use std::cell::RefCell;
use std::rc::Rc;

impl MethodKind {
    /// A tracker without a target.
    pub fn build(self, configs: &Configs) -> Result<Box<dyn Method>> {
        Ok(self.build_all(1, configs)?.remove(0))
    }

    /// So many trackers for the targets of one recording. Those of smr-core share one workspace, as in firmware.
    fn build_all(self, count: usize, configs: &Configs) -> Result<Vec<Box<dyn Method>>> {
        let baseline = |measure| Ok(Baseline::new(measure, &configs.paper));
        match self {
            Self::Smr => stepped::<Paper>(self, count, configs.paper, configs.step),
            Self::Robust => stepped::<Robust>(self, count, configs.robust, configs.step),
            Self::Sad => several(count, || baseline(Measure::Absolute)),
            Self::Ssd => several(count, || baseline(Measure::Squared)),
            Self::Ncc => several(count, || baseline(Measure::Correlation)),
            Self::Lk => several(count, || Ok(Flow::new(&configs.paper))),
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
    several(count, || Ok(Stepped::<T> { kind, target: T::with(config)?, workspace: Rc::clone(&workspace), step }))
}

/// A target of smr-core, updated in steps of so much work.
struct Stepped<T: Target> {
    kind: MethodKind,
    target: T,
    workspace: Rc<RefCell<T::Workspace>>,
    step: u32,
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
        calls::end::<T>(workspace); // another target's
        while !calls::step(&mut self.target, workspace, frame, self.step)? {}
        let answer = calls::commit(&mut self.target, workspace, frame);
        Ok(Report { work: Some(T::work(workspace)), ..answer.into() })
    }
}
