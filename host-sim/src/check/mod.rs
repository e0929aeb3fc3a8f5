//! Comparison of `smr-core` with the f64 references, value by value in each frame. Each tracker has a file of its own.

pub mod paper;
pub mod robust;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use smr_core::{Answer, Frame, Rect, Target, Tracker, UpdateError};
use smr_recordings::GrayFrame;

/// A tracker of smr-core that can be compared with its reference.
pub trait Checked: Target {
    type Reference;
    type Numbers;
    type Counts: Serialize + Default;

    /// Locks the reference on the box `target` (left, top, width, height) in the frame `first` of `size` pixels.
    fn reference(
        numbers: Self::Numbers,
        first: &[u8],
        size: (i64, i64),
        target: (i64, i64, i64, i64),
    ) -> Self::Reference;

    fn counts(_target: Rect) -> Self::Counts {
        Self::Counts::default()
    }

    /// Compares the states of both trackers after the first frame.
    fn locked(_core: &Self, _reference: &Self::Reference) -> Option<Violation> {
        None
    }

    /// Updates both trackers with the next frame and compares them; `number` counts frames from 1.
    fn compare(sides: &mut Sides<Self>, frame: &GrayFrame, number: usize) -> Result<Option<Violation>>;
}

/// A tracker of smr-core and its reference, which run side by side, and the counts of the check.
pub struct Sides<T: Checked> {
    core: Box<Tracker<T>>,
    reference: T::Reference,
    counts: T::Counts,
    step: u32,
}

impl<T: Checked> Sides<T> {
    fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        loop {
            if let Some(answer) = self.core.update_step(frame, self.step)? {
                return Ok(answer);
            }
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct Comparison<C> {
    pub sequence: String,
    /// Compared frames: all after the first, up to and including the first violation.
    pub frames: usize,
    pub violation: Option<Violation>,
    #[serde(flatten)]
    pub counts: C,
}

pub struct Check<T: Checked> {
    name: String,
    sides: Sides<T>,
    frames: usize,
    violation: Option<Violation>,
}

impl<T: Checked> Check<T> {
    /// Locks smr-core and the reference on `target` in the first frame. smr-core then updates in steps of `step` units
    /// of work (see `Tracker::update_step`). `config` and `numbers` must describe the same settings.
    pub fn lock(
        name: &str,
        (config, numbers): (T::Config, T::Numbers),
        step: u32,
        first: &GrayFrame,
        target: Rect,
    ) -> Result<Self> {
        let mut core = Box::new(Tracker::<T>::with(config)?);
        core.lock(&first.frame(), target).with_context(|| format!("{name}: cannot lock on {target:?}"))?;
        let Rect { x, y, width, height } = target;
        let size = (first.width.into(), first.height.into());
        let box_ = (x.into(), y.into(), width.into(), height.into());
        let (reference, counts) = (T::reference(numbers, &first.pixels, size, box_), T::counts(target));
        let violation = T::locked(core.target(), &reference).map(|found| Violation { frame: 1, ..found });
        let sides = Sides { core, reference, counts, step };
        Ok(Self { name: name.to_owned(), sides, frames: 0, violation })
    }

    pub const fn holds(&self) -> bool {
        self.violation.is_none()
    }

    /// Compares the next frame.
    /// Errors: smr-core refuses the frame, or an earlier frame differed and left the trackers in different states.
    pub fn update(&mut self, frame: &GrayFrame) -> Result<()> {
        if !self.holds() {
            bail!("{}: a check ends with its first violation", self.name);
        }
        self.frames += 1;
        let number = self.frames + 1;
        let found = T::compare(&mut self.sides, frame, number)?;
        self.violation = found.map(|found| Violation { frame: number, ..found });
        Ok(())
    }

    pub fn into_comparison(self) -> Comparison<T::Counts> {
        let Self { name: sequence, sides: Sides { counts, .. }, frames, violation } = self;
        Comparison { sequence, frames, violation, counts }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// Frame number, counted from 1.
    pub frame: usize,
    pub what: String,
    pub core: String,
    /// Value of the reference, or the bound that the value of smr-core exceeds.
    pub reference: String,
}

impl Violation {
    /// Creates a violation in frame 0; the caller sets the frame.
    fn new(what: String, core: impl ToString, reference: impl ToString) -> Self {
        Self { frame: 0, what, core: core.to_string(), reference: reference.to_string() }
    }
}

fn differs<T: PartialEq + std::fmt::Debug>(what: &str, core: T, reference: T) -> Option<Violation> {
    (core != reference).then(|| Violation::new(what.into(), format!("{core:?}"), format!("{reference:?}")))
}
