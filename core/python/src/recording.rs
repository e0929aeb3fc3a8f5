//! The class `Recording`, which reads every source that host-sim reads, and the scores and tables of `host-sim eval`.

use crate::answer::to_python;
use crate::frame::refused;
use crate::interrupt::{Interrupted, Stop, check, checked, interruptible};
use crate::options;
use crate::target::{Target, each};
use crate::tracker::{Tracker, bounding_box};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use smr_core::Target as _;
use smr_evaluation::robustness::{self, Starts};
use smr_evaluation::{Configs, Score, TableName, Variant};
use smr_files::{messages, wait::Wanted};
use smr_recordings::{BoundingBox, FFMPEG_PATIENCE, Frame, OpenOptions, Sequence, Source};
use std::mem::{self, ManuallyDrop};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

fn open(path: &Path) -> anyhow::Result<Sequence> {
    smr_recordings::open(path, &OpenOptions { takes_live: true, ..OpenOptions::default() })
}

pub type Four = (f64, f64, f64, f64);

fn four(of: BoundingBox) -> Four {
    (of.x, of.y, of.width, of.height)
}

/// A value that owns threads or a child process. A fork does not copy these, so a forked process neither uses nor drops
/// the value.
struct ProcessLocal<T>(u32, ManuallyDrop<T>);

impl<T> ProcessLocal<T> {
    fn new(value: T) -> Self {
        Self(process::id(), ManuallyDrop::new(value))
    }

    /// Fails in a process that did not create the value.
    fn get(&self) -> PyResult<&T> {
        let other =
            "another process began to read this recording: make a smr.Recording and iterate over it in this one";
        if self.0 == process::id() { Ok(&self.1) } else { Err(PyRuntimeError::new_err(other)) }
    }
}

impl<T> Drop for ProcessLocal<T> {
    fn drop(&mut self) {
        if self.0 == process::id() {
            // SAFETY: The value is dropped only here.
            #[allow(unsafe_code)]
            unsafe {
                ManuallyDrop::drop(&mut self.1);
            }
        }
    }
}

/// A recording as host-sim reads it: a folder of pictures, a video, Y4M, a built-in one such as "street", a camera of
/// Linux ("/dev/video0" or its number, 0), or an address ("rtsp://camera.local/stream").
///
/// Iterating over it decodes one frame at a time: arrays of uint8, gray (height, width), or BGR (height, width, 3) with
/// `color=True`. A camera or an address yields its newest frame and drops older ones. After a fork, or a Ctrl-C while
/// a frame was read, iterate anew. `close` of the iterator ends it, also while another thread waits for a frame.
///
/// Videos, cameras and addresses need ffmpeg (not OpenCV) on the PATH. Raises ValueError if the recording cannot be
/// opened; iterating raises OSError at a damaged frame, or if a camera fails.
#[pyclass(frozen, module = "smr")]
pub struct Recording {
    path: PathBuf,
    /// The name of the folder or file.
    #[pyo3(get)]
    name: String,
    /// True for a camera or an address, whose frames have no end and arrive in real time.
    #[pyo3(get)]
    is_live: bool,
    start: Option<BoundingBox>,
    truth: Option<Vec<Option<BoundingBox>>>,
    color: bool,
    length: Option<usize>,
    source: Source,
    /// The stream of a live source, which is opened only once: the first iteration takes it.
    live: ProcessLocal<Mutex<Option<Sequence>>>,
}

impl Recording {
    /// Returns the first `count` frames, decoded. Reads nothing from a live source and returns an empty list for it.
    fn first(&self, py: Python<'_>, count: usize) -> PyResult<Vec<Frame>> {
        let path = self.path.clone();
        let read = move || open(&path)?.frames.take(count).collect::<anyhow::Result<_>>();
        if self.is_live { Ok(Vec::new()) } else { called(py, read)?.map_err(refused) }
    }
}

#[pymethods]
impl Recording {
    #[new]
    #[pyo3(signature = (path, *, color = false))]
    fn new(py: Python<'_>, path: &Bound<'_, PyAny>, color: bool) -> PyResult<Self> {
        let expected = "path: expected a path, an address or the number of a camera, found";
        let camera = path.extract::<u16>().map(|number| format!("/dev/video{number}").into());
        let wrong = |_| PyTypeError::new_err(format!("{expected} {path}"));
        let path: PathBuf = camera.or_else(|_| path.extract()).map_err(wrong)?;
        if path == Path::new("-") {
            return Err(PyValueError::new_err("standard input can be read only once: expected a file or a folder"));
        }
        let is_live = smr_recordings::is_live(&path);
        let named = path.clone();
        let mut opened = called(py, move || open(&named))?.map_err(refused)?;
        let (name, start, truth) = (opened.name.clone(), opened.init, opened.truth.take());
        let (length, source) = (opened.length, opened.source.clone());
        let live = ProcessLocal::new(Mutex::new(is_live.then_some(opened)));
        Ok(Self { path, name, is_live, start, truth, color, length, source, live })
    }

    /// Width and height of the frames in pixels; None for a camera or an address.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<Option<(u16, u16)>> {
        Ok(self.first(py, 1)?.first().map(|first| (first.gray.width, first.gray.height)))
    }

    /// Frames per second, from the times of the first 31 frames. None for a live source or with fewer than two times.
    #[getter]
    fn fps(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let times: Vec<f64> = self.first(py, 31)?.iter().filter_map(|frame| frame.seconds).collect();
        Ok(times.get(1..).and_then(<[f64]>::last).map(|last| (times.len() - 1) as f64 / (last - times[0])))
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        let count = match self.length {
            None => {
                let source = self.source.clone();
                called(py, move || source.length(FFMPEG_PATIENCE))?
            }
            length => length,
        };
        count.ok_or_else(|| PyTypeError::new_err(format!("{}: the number of frames is not known", self.name)))
    }

    fn __bool__(&self) -> bool {
        true // also where `len` is not known
    }

    fn __repr__(&self) -> String {
        format!("smr.Recording({:?}{})", self.path, if self.color { ", color=True" } else { "" })
    }

    /// The initial box, from a file beside the recording: (x, y, width, height) in pixels, or None.
    #[getter]
    fn start(&self) -> Option<Four> {
        self.start.map(four)
    }

    /// The true box of each frame, (x, y, width, height) in pixels or None (hidden target). None without ground truth.
    #[getter]
    fn truth(&self) -> Option<Vec<Option<Four>>> {
        self.truth.as_ref().map(|truth| truth.iter().map(|shown| shown.map(four)).collect())
    }

    fn __iter__(&self) -> PyResult<Decoded> {
        let kept = if self.is_live { self.live.get()?.lock().ok().and_then(|mut live| live.take()) } else { None };
        let (path, color) = (self.path.clone(), self.color);
        let in_color = move |sequence: Sequence| if color { sequence.in_color(FFMPEG_PATIENCE) } else { sequence };
        let opened = move || kept.map_or_else(|| open(&path), Ok).map(in_color);
        let stream = ProcessLocal::new(Arc::new(Mutex::new(Stream::ToOpen(Box::new(opened)))));
        Ok(Decoded { stream, wanted: Wanted::default(), is_closed: AtomicBool::new(false) })
    }

    /// Scores the boxes of any tracker. Returns the figures of `host-sim eval` as a dict from name to value.
    ///
    /// `boxes` has (x, y, width, height) in pixels for each frame, or None where the tracker has no answer. Raises
    /// ValueError without ground truth, or if the number of boxes differs from it.
    fn score<'py>(&self, py: Python<'py>, boxes: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let missing = || PyValueError::new_err(format!("{}: no ground truth beside it", self.name));
        let truth = self.truth.as_ref().ok_or_else(missing)?;
        let answer = |item: PyResult<Bound<'py, PyAny>>| {
            let item = item?;
            if item.is_none() { Ok(None) } else { bounding_box(&item).map(Some) }
        };
        let answers: Vec<Option<BoundingBox>> = boxes.try_iter()?.map(answer).collect::<PyResult<_>>()?;
        let score = Score::new(&answers, truth).map_err(refused)?;
        to_python(py, &serde_json::to_value(score).map_err(refused)?)
    }
}

/// Runs a call that may block.
fn called<T: Send + 'static>(py: Python<'_>, call: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    Ok(interruptible(py, &Wanted::default(), call)?)
}

/// An iterator over the frames of a `Recording`, from `iter(recording)`.
#[pyclass(frozen, name = "Frames", module = "smr._smr")]
pub struct Decoded {
    stream: ProcessLocal<Arc<Mutex<Stream>>>,
    wanted: Wanted,
    is_closed: AtomicBool,
}

/// The recording of an iterator, which the first call of `next` opens.
enum Stream {
    ToOpen(Box<dyn FnOnce() -> anyhow::Result<Sequence> + Send>),
    Open(Sequence),
    Closed,
}

/// Shape `[rows, columns, bytes per pixel]` and bytes of a frame.
type Bytes = ([usize; 3], Vec<u8>);

impl Stream {
    /// Returns the next frame; `None` after the last one.
    fn next(&mut self) -> PyResult<Option<Bytes>> {
        if matches!(self, Self::ToOpen(_))
            && let Self::ToOpen(open) = mem::replace(self, Self::Closed)
        {
            *self = Self::Open(open().map_err(refused)?);
        }
        let Self::Open(sequence) = self else { return Ok(None) };
        next(sequence).map_err(|error| PyOSError::new_err(messages::of(&error)))
    }
}

fn next(sequence: &mut Sequence) -> anyhow::Result<Option<Bytes>> {
    let Some(frame) = sequence.frames.next().transpose()? else {
        let ended = sequence.source.live().and_then(|live| live.ended());
        return ended.map_or(Ok(None), |reason| Err(anyhow::anyhow!(reason)));
    };
    let [rows, columns] = [frame.gray.height, frame.gray.width].map(usize::from);
    let Some(color) = frame.color else { return Ok(Some(([rows, columns, 1], frame.gray.pixels))) };
    let bytes = color.pixels.into_iter().flat_map(|[red, green, blue]| [blue, green, red]).collect();
    Ok(Some(([rows, columns, 3], bytes)))
}

impl Decoded {
    /// Ends the recording's ffmpeg, unless a call is reading, which then does so.
    fn close_stream(&self, py: Python<'_>) -> PyResult<()> {
        let stream = self.stream.get()?;
        py.detach(|| stream.try_lock().map(|mut stream| *stream = Stream::Closed).ok());
        Ok(())
    }
}

#[pymethods]
impl Decoded {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<u8>>>> {
        let (stream, wanted) = (Arc::clone(self.stream.get()?), self.wanted.clone());
        let read = move || {
            let mut stream = stream.lock().unwrap_or_else(PoisonError::into_inner);
            let read = stream.next();
            if wanted.has_ended() {
                // The call has left: nobody else would end the recording's ffmpeg.
                *stream = Stream::Closed;
            }
            read
        };
        let next = match interruptible(py, &self.wanted, read) {
            Ok(next) => next?,
            Err(interrupted) => {
                self.close_stream(py)?;
                return match interrupted {
                    Interrupted::Raised(error) => Err(error),
                    Interrupted::Ended if self.is_closed.load(Ordering::SeqCst) => Ok(None),
                    Interrupted::Ended => Err(PyRuntimeError::new_err(
                        "this iteration was interrupted while it read a frame: iterate over the recording anew",
                    )),
                };
            }
        };
        let Some((shape, bytes)) = next else { return Ok(None) };
        let shape = if shape[2] == 1 { &shape[..2] } else { &shape[..] };
        PyArray1::from_vec(py, bytes).reshape(shape).map(Some)
    }

    /// Ends the iteration, also while another thread waits for a frame. Closes a camera, and ends its ffmpeg.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.stream.get()?;
        self.is_closed.store(true, Ordering::SeqCst);
        self.wanted.end();
        self.close_stream(py)
    }
}

/// The initial box, from a file beside `path`: (x, y, width, height) in pixels, or None. Reads no frame.
///
/// Raises ValueError if a file with boxes cannot be read.
#[pyfunction]
pub fn start_beside(py: Python<'_>, path: PathBuf) -> PyResult<Option<Four>> {
    Ok(called(py, move || smr_recordings::start_beside(&path))?.map_err(refused)?.map(four))
}

/// Finds the recordings in folders, as host-sim does: a list of paths. Raises ValueError if a folder has none.
#[pyfunction]
pub fn recordings(py: Python<'_>, paths: Vec<PathBuf>) -> PyResult<Vec<PathBuf>> {
    called(py, move || smr_recordings::recordings(&paths))?.map_err(refused)
}

fn variant(name: &str, tracker: &Tracker) -> PyResult<Variant> {
    let target = &*tracker.target()?;
    let (mut configs, mut options): (Configs, _) =
        each!(target, of => ((*of.config()).into(), options::all(of.config())));
    configs.robust_size = target.size();
    options.insert("preset".to_owned(), tracker.preset.into());
    Ok(Variant { name: name.to_owned(), options, ..Variant::new(target.kind(), &configs) })
}

/// Measures trackers on one recording. Returns the table `measured` of `host-sim eval --robustness` as a dict of
/// columns. `starts` is 'given', 'near' or the number of frames between starts, as documented at `smr.evaluate`. `stop`
/// ends the call from another thread.
#[pyfunction]
#[pyo3(signature = (path, trackers, starts, stop = None))]
pub fn measure<'py>(
    py: Python<'py>,
    path: PathBuf,
    trackers: &Bound<'py, PyDict>,
    starts: Bound<'py, PyAny>,
    stop: Option<&Bound<'py, Stop>>,
) -> PyResult<Bound<'py, PyDict>> {
    let starts = match (starts.extract::<&str>(), starts.extract::<NonZeroUsize>()) {
        (Ok("given"), _) => Starts::Given,
        (Ok("near"), _) => Starts::Near,
        (_, Ok(every)) => Starts::Every(every),
        _ => {
            let expected = "'given', 'near' or the number of frames between starts";
            return Err(PyValueError::new_err(format!("starts: expected {expected}, found {starts}")));
        }
    };
    let named = |(name, tracker): (Bound<'py, PyAny>, Bound<'py, PyAny>)| {
        variant(name.extract()?, tracker.cast::<Tracker>()?.get())
    };
    let variants: Vec<_> = trackers.iter().map(named).collect::<PyResult<_>>()?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(refused)?;
    let wanted = stop.map_or_else(Wanted::default, |stop| stop.get().0.clone());
    let flag = wanted.clone();
    let run = move || {
        let open = |path: &Path| open(path).map(|sequence| checked(sequence, &flag));
        robustness::measure(&[path], open, &variants, starts, None, &|_| check(&flag))
    };
    let in_pool = wanted.clone();
    let mut measured = interruptible(py, &wanted, move || alone.install(|| in_pool.scope(run)))?;
    if !measured.failures.is_empty() {
        return Err(refused(measured.failures.remove(0)));
    }
    let tables = measured.tables.map_err(refused)?;
    let columns = PyDict::new(py);
    for (name, values) in tables.columns(TableName::Measured) {
        let values: PyResult<Vec<_>> = values.into_iter().map(|value| to_python(py, value)).collect();
        columns.set_item(name, values?)?;
    }
    Ok(columns)
}
