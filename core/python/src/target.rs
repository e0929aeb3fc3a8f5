//! A target of either tracker of smr-core, and the scratch memory for updates.

use crate::answer::to_python;
use crate::frame::{Pixels, refused};
use crate::options;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;
use smr_core::calls::Checked;
use smr_core::robust::Small;
use smr_core::{Answer, ConfigError, Frame, Rect, Robust, Target as Stepping, UpdateError, paper, robust};
use smr_evaluation::{MethodKind, Refused, RobustSize};
use std::cell::RefCell;

/// The paper tracker with host-sim's limits on the pixels of a template and the offsets of a search window.
type Paper = smr_evaluation::Paper;
type PaperWorkspace = paper::Workspace<{ smr_evaluation::MAX_PIXELS }, { smr_evaluation::MAX_OFFSETS }>;

pub enum Target {
    Paper(Box<Paper>),
    Robust(Box<Robust>),
    Small(Box<Robust<Small>>),
}

/// Scratch memory for `lock` and `update`. Any number of targets can share it, but only one call at a time may use it.
#[derive(Default)]
pub struct Scratch {
    paper: Option<Box<PaperWorkspace>>,
    robust: Option<Box<robust::Workspace>>,
    small: Option<Box<robust::Workspace<Small>>>,
    /// Gray pixels that were converted from another layout.
    gray: Vec<u8>,
}

/// Lends `count` scratch memories of this thread to `call`.
pub fn with_scratch<T>(count: usize, call: impl FnOnce(&mut [Scratch]) -> T) -> T {
    thread_local! {
        static SCRATCH: RefCell<Vec<Scratch>> = RefCell::default();
    }
    SCRATCH.with(|kept| {
        // The handler of a signal may call a tracker while another one works in this thread.
        let (mut kept, mut own) = (kept.try_borrow_mut(), Vec::new());
        let all = kept.as_deref_mut().unwrap_or(&mut own);
        all.resize_with(count.max(all.len()), Scratch::default);
        call(&mut all[..count])
    })
}

fn not_updated(error: UpdateError) -> PyErr {
    match error {
        UpdateError::NotLocked => PyRuntimeError::new_err("there is no target yet: call init first"),
        error => refused(error),
    }
}

/// Work of a step, in the units of [`smr_core::Tracker::update_step`]: some hundredths of a second.
const STEP: u32 = 100_000_000;

fn stepped<T: Stepping>(
    target: &mut T,
    workspace: &mut T::Workspace,
    frame: &Frame<'_>,
    mut go_on: impl FnMut() -> PyResult<()>,
) -> PyResult<Answer> {
    loop {
        if let Some(answer) = target.update_step(workspace, frame, STEP).map_err(not_updated)? {
            return Ok(answer);
        }
        go_on().inspect_err(|_| target.cancel())?;
    }
}

/// Evaluates `$result` with `$of` bound to the target, for either tracker.
macro_rules! each {
    ($target:expr, $of:ident => $result:expr) => {
        match $target {
            Target::Paper($of) => $result,
            Target::Robust($of) => $result,
            Target::Small($of) => $result,
        }
    };
}
pub(crate) use each;

impl Target {
    pub fn paper(config: paper::Config) -> Result<Self, ConfigError> {
        Ok(Self::Paper(Box::new(Paper::with(config)?)))
    }

    pub fn robust(config: robust::Config) -> Result<Self, ConfigError> {
        Ok(Self::Robust(Box::new(Robust::with(config)?)))
    }

    pub fn small(config: robust::Config) -> Result<Self, ConfigError> {
        Ok(Self::Small(Box::new(Robust::with(config)?)))
    }

    pub fn kind(&self) -> MethodKind {
        match self {
            Self::Paper(_) => MethodKind::Paper,
            Self::Robust(_) | Self::Small(_) => MethodKind::Robust,
        }
    }

    pub fn size(&self) -> RobustSize {
        if matches!(self, Self::Small(_)) { RobustSize::Small } else { RobustSize::Standard }
    }

    pub fn lock(&mut self, scratch: &mut Scratch, pixels: &Pixels<'_>, target: Rect) -> PyResult<()> {
        let (bounds, kind) = (pixels.bounds(), self.kind());
        let window = each!(self, of => of.lock_window(bounds, target));
        let Scratch { paper, robust, small, gray } = scratch;
        let frame = pixels.frame([Some(window), None], gray)?;
        let locked = match self {
            Self::Paper(of) => of.lock(paper.get_or_insert_default(), &frame, target),
            Self::Robust(of) => of.lock(robust.get_or_insert_default(), &frame, target),
            Self::Small(of) => of.lock(small.get_or_insert_default(), &frame, target),
        };
        locked.map(drop).map_err(|error| refused(Refused::or(error.into(), kind, target, bounds)))
    }

    /// Checks whether `update` would accept the frame. Changes nothing and reads no pixel.
    pub fn check(&self, pixels: &Pixels<'_>) -> PyResult<()> {
        let frame = pixels.corner()?;
        match each!(self, of => Checked::update(&**of, &frame).map(drop)) {
            // Expected with only one pixel in memory. The core checks the window last, so all else has passed.
            Err(UpdateError::WindowNotInMemory) => Ok(()),
            checked => checked.map_err(not_updated),
        }
    }

    /// Finds the target. `go_on` is called from time to time; its error ends the update, which then changes nothing.
    pub fn update(
        &mut self,
        scratch: &mut Scratch,
        pixels: &Pixels<'_>,
        go_on: impl FnMut() -> PyResult<()>,
    ) -> PyResult<Answer> {
        let windows = each!(self, of => [of.window(), of.sweep_window()]);
        let Scratch { paper, robust, small, gray } = scratch;
        let frame = pixels.frame(windows, gray)?;
        match self {
            Self::Paper(of) => stepped(&mut **of, paper.get_or_insert_default(), &frame, go_on),
            Self::Robust(of) => stepped(&mut **of, robust.get_or_insert_default(), &frame, go_on),
            Self::Small(of) => stepped(&mut **of, small.get_or_insert_default(), &frame, go_on),
        }
    }

    /// Saves the target as bytes; `None` without a target.
    pub fn saved(&self) -> Option<Vec<u8>> {
        each!(self, of => {
            let mut bytes = vec![0; of.saved_size().ok()?];
            of.save(&mut bytes).ok()?;
            Some(bytes)
        })
    }

    /// The configuration as keyword arguments of the Python class.
    pub fn keywords<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let options = Value::Object(each!(self, of => options::all(of.config())));
        let options: Bound<'py, PyDict> = to_python(py, &options)?.cast_into()?;
        let lists = options.iter().filter_map(|(name, value)| Some((name, value.cast_into::<PyList>().ok()?)));
        lists.collect::<Vec<_>>().into_iter().try_for_each(|(name, list)| options.set_item(name, list.to_tuple()))?;
        Ok(options)
    }
}
