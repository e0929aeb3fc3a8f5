//! Builds the tracker of each [`MethodKind`]: those of smr-core, updated in steps, and the baselines.

use super::baseline::{Baseline, Flow, Measure};
use super::configs::{Configs, Variant};
use super::method::{Method, MethodKind, Report};
use crate::Paper;
use anyhow::Result;
use smr_core::{Frame, Quality, Rect, Robust, Target, Tracker};

impl MethodKind {
    /// A tracker without a target.
    pub fn build(self, configs: &Configs) -> Result<Box<dyn Method>> {
        let baseline = |measure| Box::new(Baseline::new(measure, &configs.paper));
        Ok(match self {
            Self::Smr => Box::new(Stepped::<Paper>::new(self, configs.paper, configs.step)?),
            Self::Robust => Box::new(Stepped::<Robust>::new(self, configs.robust, configs.step)?),
            Self::Sad => baseline(Measure::Absolute),
            Self::Ssd => baseline(Measure::Squared),
            Self::Ncc => baseline(Measure::Correlation),
            Self::Lk => Box::new(Flow::new(&configs.paper)),
        })
    }
}

impl Variant {
    pub fn build(&self) -> Result<Box<dyn Method>> {
        self.kind.build(&self.configs)
    }
}

/// A tracker of smr-core, updated in steps of so much work.
struct Stepped<T: Target> {
    kind: MethodKind,
    tracker: Tracker<T>,
    step: u32,
}

impl<T: Target> Stepped<T> {
    fn new(kind: MethodKind, config: T::Config, step: u32) -> Result<Self> {
        Ok(Self { kind, tracker: Tracker::new(config)?, step })
    }
}

impl<T: Target> Method for Stepped<T> {
    fn kind(&self) -> MethodKind {
        self.kind
    }

    fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<()> {
        self.tracker.lock(frame, target)?;
        Ok(())
    }

    fn quality(&self) -> Option<Quality> {
        self.tracker.quality()
    }

    fn update(&mut self, frame: &Frame<'_>) -> Result<Report> {
        let mut update = self.tracker.begin(frame)?;
        while !update.step(self.step) {}
        let answer = update.finish();
        Ok(Report { work: Some(self.tracker.work()), ..answer.into() })
    }
}
