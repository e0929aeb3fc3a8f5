//! The classes `Tracker`, `Paper` and `Robust`.

use crate::answer;
use crate::frame::{Borrowed, Pixels, refused};
use crate::interrupt::Signals;
use crate::options::{or_value_error, with};
use crate::target::{Scratch, Target, each, with_scratch};
use pyo3::PyClassInitializer as New;
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use smr_core::robust::Small;
use smr_core::{Answer, ConfigError, Rect, Settings, State, Target as _, paper, robust};
use smr_recordings::BoundingBox;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

/// Follows one target. Its subclasses are `Paper` and `Robust`.
///
/// Frames are numpy arrays of uint8, gray (height, width) or BGR (height, width, 3), of one size, with any strides.
/// OpenCV is not needed. Calls release the lock of Python (GIL); do not write to the frame meanwhile.
#[pyclass(frozen, subclass, module = "smr")]
pub struct Tracker {
    target: Mutex<Target>,
    /// The name of the preset on which the options are based.
    pub preset: &'static str,
    /// The last answer; `None` after `init` and `restore`.
    answer: Mutex<Option<Answer>>,
}

/// The tracker of the paper: fast, for a target that keeps its size.
///
/// `preset` is "camera" (bounded time and memory) or "paper" (the authors' program). Options change its values.
#[pyclass(frozen, extends = Tracker, module = "smr")]
pub struct Paper;

/// The robust tracker: follows changes of size, light and view, and searches the whole frame for a lost target.
///
/// `preset` is "refined" or "robust" (without the refiner). "small_refined" and "small" take less memory and time, and
/// have a `reach` of at most 7. Options change its values; `options` shows all.
#[pyclass(frozen, extends = Tracker, module = "smr")]
pub struct Robust;

/// The name of a preset, its configuration, and the tracker that it is for.
type Preset<C> = (&'static str, C, fn(C) -> Result<Target, ConfigError>);

fn rect(value: &Bound<'_, PyAny>) -> PyResult<Rect> {
    bounding_box(value)?.pixels().map_err(|what| PyValueError::new_err(format!("the box {what}")))
}

pub fn bounding_box(value: &Bound<'_, PyAny>) -> PyResult<BoundingBox> {
    let numbers: PyResult<Vec<f64>> = value.try_iter().and_then(|items| items.map(|item| item?.extract()).collect());
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) if [x, y, width, height].iter().all(|number| number.is_finite()) => {
            Ok(BoundingBox { x, y, width, height })
        }
        Ok([_, _, _, _]) => Err(PyValueError::new_err(format!("box: expected finite numbers, found {value}"))),
        _ => Err(PyTypeError::new_err(format!("box: expected four numbers (x, y, width, height), found {value}"))),
    }
}

impl Tracker {
    /// Creates a tracker from the preset called `name` (by default the first of `presets`), changed by `options`.
    fn new<C: Settings>(
        presets: &[Preset<C>],
        name: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<New<Self>> {
        let names = presets.iter().map(|(preset, ..)| format!("'{preset}'")).collect::<Vec<_>>();
        let name = name.map_or_else(|| names[0].clone(), |name| format!("{name:?}"));
        let Some(&(preset, config, target)) = names.iter().position(|one| *one == name).map(|at| &presets[at]) else {
            return Err(PyValueError::new_err(format!("preset: expected {}, found {name}", names.join(" or "))));
        };
        let target = Mutex::new(or_value_error(target(with(config, options)?), options)?);
        Ok(New::from(Self { target, preset, answer: Mutex::default() }))
    }

    /// Fails if another thread is using the tracker.
    pub fn target(&self) -> PyResult<MutexGuard<'_, Target>> {
        let busy = "this tracker is in use by another thread: give each thread a tracker of its own";
        self.target.try_lock().map_err(|_| PyRuntimeError::new_err(busy))
    }

    fn next(&self, frame: &Bound<'_, PyAny>) -> PyResult<Answer> {
        let (py, frame) = (frame.py(), Borrowed::new(frame)?);
        let (pixels, target) = (frame.pixels(), &mut *self.target()?);
        let mut signals = Signals::new();
        let update = || with_scratch(1, |scratch| target.update(&mut scratch[0], &pixels, || signals.check()));
        py.detach(update).inspect(|&answer| self.keep(Some(answer)))
    }

    fn keep(&self, answer: Option<Answer>) {
        *self.answer.lock().unwrap_or_else(PoisonError::into_inner) = answer;
    }
}

#[pymethods]
impl Tracker {
    /// Starts to follow the target in `box`, (x, y, width, height) in pixels, which must lie inside the frame.
    ///
    /// Forgets any previous target. May be called at any time. Fractions are rounded to whole pixels. Raises ValueError
    /// if the box is not inside, or its size does not suit the tracker.
    fn init(&self, frame: &Bound<'_, PyAny>, r#box: &Bound<'_, PyAny>) -> PyResult<()> {
        let (py, frame) = (frame.py(), Borrowed::new(frame)?);
        let (pixels, place, target) = (frame.pixels(), rect(r#box)?, &mut *self.target()?);
        let lock = || with_scratch(1, |scratch| target.lock(&mut scratch[0], &pixels, place));
        py.detach(lock).inspect(|()| self.keep(None))
    }

    /// Finds the target in the next frame: `(ok, box)`, as OpenCV's trackers answer. `ok` is False only if the target
    /// is lost; the attribute `answer` tells whether the box is uncertain.
    fn update<'py>(&self, py: Python<'py>, frame: &Bound<'py, PyAny>) -> PyResult<(bool, Bound<'py, PyAny>)> {
        let answer = self.next(frame)?;
        Ok((answer.state != State::Lost, answer::to_box(py, answer.bbox)?))
    }

    /// Finds the target in the next frame and returns the whole `Answer`.
    fn follow<'py>(&self, py: Python<'py>, frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        answer::answer(py, &self.next(frame)?)
    }

    /// The `Answer` of the last `update` or `follow`; None directly after `init` or `restore`.
    #[getter]
    fn answer<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let last = *self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        last.map(|last| answer::answer(py, &last)).transpose()
    }

    /// Distinctness of the target from shifted copies at `init`, from 0 (the box may slip along the target unnoticed)
    /// to 1. None without a target.
    #[getter]
    fn quality(&self) -> PyResult<Option<f64>> {
        let quality = each!(&*self.target()?, of => of.quality());
        Ok(quality.map(|quality| answer::ratio_to_float(quality.value())))
    }

    /// The part of the frame that the next update reads, in whole pixels; None without a target.
    fn window<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        each!(&*self.target()?, of => of.window()).map(|window| answer::to_box(py, window)).transpose()
    }

    /// The second part of the frame that the next update reads, to search for a lost target, in whole pixels; None if
    /// there is no such part.
    fn sweep_window<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        each!(&*self.target()?, of => of.sweep_window()).map(|window| answer::to_box(py, window)).transpose()
    }

    /// Reports a turn of the camera: (x, y) is expected at (x + right, y + down), in pixels rounded to 1/256.
    fn moved(&self, right: f64, down: f64) -> PyResult<()> {
        let units = |pixels: f64| (pixels * 256.0).round();
        let fits = |pixels: f64| units(pixels).abs() <= f64::from(i32::MAX);
        if !fits(right) || !fits(down) {
            let wrong = format!("moved: expected pixels of -8388607 to 8388607, found {right}, {down}");
            return Err(PyValueError::new_err(wrong));
        }
        #[allow(clippy::cast_possible_truncation)] // checked
        let [right, down] = [right, down].map(|pixels| units(pixels) as i32);
        each!(&mut *self.target()?, of => of.moved(right, down));
        Ok(())
    }

    /// Saves the target as bytes, for `restore` with equal preset and options, in Python, Rust, C or MicroPython.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let saved = self.target()?.saved();
        let saved = saved.ok_or_else(|| PyRuntimeError::new_err("there is no target yet: call init first"))?;
        Ok(PyBytes::new(py, &saved))
    }

    /// Continues with a saved target. It must have been saved with equal options; if not, the error names the first
    /// option that differs.
    fn restore(&self, saved: &[u8]) -> PyResult<()> {
        each!(&mut *self.target()?, of => of.restore(saved)).map_err(refused).inspect(|()| self.keep(None))
    }

    /// All options by name, and the preset: `type(tracker)(**tracker.options)` creates an equal tracker.
    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let options = self.target()?.keywords(py)?;
        options.set_item("preset", self.preset)?;
        Ok(options)
    }

    // Pickling and copying: Python calls the class with the options, then restores the saved target.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        Ok((PyTuple::empty(py), self.options(py)?))
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<(Option<Bound<'py, PyBytes>>,)> {
        Ok((self.target()?.saved().map(|saved| PyBytes::new(py, &saved)),))
    }

    fn __setstate__(&self, state: (Option<Vec<u8>>,)) -> PyResult<()> {
        match state.0 {
            Some(saved) => self.restore(&saved),
            None => each!(&mut *self.target()?, of => of.configure(*of.config())).map_err(refused),
        }
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let options = slf.get().options(slf.py())?;
        let options: Vec<String> = options.iter().map(|(name, value)| format!("{name}={value:?}")).collect();
        Ok(format!("smr.{}({})", slf.get_type().name()?, options.join(", ")))
    }
}

#[pymethods]
impl Paper {
    #[new]
    #[pyo3(signature = (preset = None, **options))]
    fn new(preset: Option<&Bound<'_, PyAny>>, options: Option<&Bound<'_, PyDict>>) -> PyResult<New<Self>> {
        let presets: [Preset<_>; 2] =
            [("camera", paper::Config::camera(), Target::paper), ("paper", paper::Config::paper(), Target::paper)];
        Ok(Tracker::new(&presets, preset, options)?.add_subclass(Self))
    }
}

#[pymethods]
impl Robust {
    #[new]
    #[pyo3(signature = (preset = None, **options))]
    fn new(preset: Option<&Bound<'_, PyAny>>, options: Option<&Bound<'_, PyDict>>) -> PyResult<New<Self>> {
        let (refined, robust) = (robust::Config::refined(), robust::Config::robust());
        let presets: [Preset<_>; 4] = [
            ("refined", refined, Target::robust),
            ("robust", robust, Target::robust),
            ("small", robust.within::<Small>(), Target::small),
            ("small_refined", refined.within::<Small>(), Target::small),
        ];
        Ok(Tracker::new(&presets, preset, options)?.add_subclass(Self))
    }
}

/// Updates all trackers of a `Group` on at most `threads` threads. Updates no tracker if any tracker is in use by
/// another thread or would refuse the frame.
#[pyfunction]
pub fn follow<'py>(
    trackers: Vec<Bound<'py, Tracker>>,
    frame: &Bound<'py, PyAny>,
    threads: usize,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (py, frame) = (frame.py(), Borrowed::new(frame)?);
    let pixels = frame.pixels();
    let mut guards = trackers.iter().map(|tracker| tracker.get().target()).collect::<PyResult<Vec<_>>>()?;
    let targets: Vec<&mut Target> = guards.iter_mut().map(|guard| &mut **guard).collect();
    targets.iter().try_for_each(|target| target.check(&pixels))?;
    let threads = threads.clamp(1, targets.len().max(1));
    let answers = py.detach(|| with_scratch(threads, |scratch| side_by_side(targets, scratch, &pixels)))?;
    trackers.iter().zip(&answers).for_each(|(tracker, &one)| tracker.get().keep(Some(one)));
    answers.iter().map(|one| answer::answer(py, one)).collect()
}

/// Updates `targets` on one thread per element of `scratch`: the calling thread and new ones. The new threads end
/// before the call returns, because a fork would lose threads that wait for the next call.
fn side_by_side(targets: Vec<&mut Target>, scratch: &mut [Scratch], pixels: &Pixels<'_>) -> PyResult<Vec<Answer>> {
    let mut answers: Vec<PyResult<Option<Answer>>> = targets.iter().map(|_| Ok(None)).collect();
    let queue = Mutex::new(targets.into_iter().zip(&mut answers));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = |scratch: &mut Scratch| {
        while let Some((target, answer)) = next() {
            // A signal waits for the end of the frame: all targets follow in it, or none.
            *answer = target.update(scratch, pixels, || Ok(())).map(Some);
        }
    };
    let [own, others @ ..] = scratch else { return Ok(Vec::new()) };
    thread::scope(|scope| {
        for scratch in others {
            // If a thread cannot be started, the running threads (at least the calling one) update all targets.
            let _ = thread::Builder::new().spawn_scoped(scope, || work(scratch));
        }
        work(own);
    });
    answers.into_iter().filter_map(Result::transpose).collect()
}
