//! The class `Recording`, which reads what host-sim reads, and the figures of host-sim.

use crate::answer::to_python;
use crate::options;
use crate::target::{Target, refused};
use crate::tracker::{Tracker, bounding_box};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use smr_core::Target as _;
use smr_evaluation::robustness::{self, Starts};
use smr_evaluation::{Configs, Score, TableName, Variant};
use smr_recordings::messages;
use smr_recordings::{BoundingBox, Frames, OpenOptions, Sequence};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

fn open(path: &Path) -> anyhow::Result<Sequence> {
    smr_recordings::open(path, &OpenOptions::default())
}

type Four = (f64, f64, f64, f64);

fn four(of: BoundingBox) -> Four {
    (of.x, of.y, of.width, of.height)
}

/// A recording as host-sim reads it: a folder of pictures, a video (if ffmpeg is installed), Y4M, or a built-in one
/// such as "synthetic".
///
/// Iterating over it decodes its frames, gray (height, width) arrays, one at a time.
#[pyclass(frozen, module = "smr")]
pub struct Recording {
    path: PathBuf,
    /// The name of the folder or file.
    #[pyo3(get)]
    name: String,
    start: Option<BoundingBox>,
    truth: Option<Vec<Option<BoundingBox>>>,
}

#[pymethods]
impl Recording {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        if path == Path::new("-") {
            return Err(PyValueError::new_err("standard input can be read only once: expected a file or a folder"));
        }
        let Sequence { name, init, truth, .. } = open(&path).map_err(refused)?;
        Ok(Self { path, name, start: init, truth })
    }

    /// The box to start from, which lies beside the recording: (x, y, width, height), or None.
    #[getter]
    fn start(&self) -> Option<Four> {
        self.start.map(four)
    }

    /// The box of each frame, None where the target is hidden; None without ground truth.
    #[getter]
    fn truth(&self) -> Option<Vec<Option<Four>>> {
        let truth = self.truth.as_ref()?;
        Some(truth.iter().map(|shown| shown.map(four)).collect())
    }

    fn __iter__(&self) -> PyResult<GrayFrames> {
        Ok(GrayFrames(Mutex::new(open(&self.path).map_err(refused)?.frames)))
    }

    /// The figures of `host-sim eval` for any tracker's boxes: one for each frame, or None where it has no answer.
    fn score<'py>(&self, py: Python<'py>, boxes: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let truth = self.truth.as_ref();
        let truth = truth.ok_or_else(|| PyValueError::new_err(format!("{}: no ground truth beside it", self.name)))?;
        let answer = |item: PyResult<Bound<'py, PyAny>>| {
            let item = item?;
            if item.is_none() { Ok(None) } else { bounding_box(&item).map(Some) }
        };
        let answers: Vec<Option<BoundingBox>> = boxes.try_iter()?.map(answer).collect::<PyResult<_>>()?;
        let score = Score::new(&answers, truth).map_err(refused)?;
        to_python(py, &serde_json::to_value(score).map_err(refused)?)
    }
}

#[pyclass(frozen)]
struct GrayFrames(Mutex<Frames>);

#[pymethods]
impl GrayFrames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u8>>>> {
        let next = py.detach(|| self.0.lock().map(|mut frames| frames.next()).ok().flatten());
        let Some(frame) = next.transpose().map_err(|error| PyOSError::new_err(messages::of(&error)))? else {
            return Ok(None);
        };
        let shape = [usize::from(frame.height), usize::from(frame.width)];
        PyArray1::from_vec(py, frame.pixels).reshape(shape).map(Some)
    }
}

/// The recordings in folders, as host-sim finds them.
#[pyfunction]
pub fn recordings(paths: Vec<PathBuf>) -> PyResult<Vec<PathBuf>> {
    smr_recordings::recordings(&paths).map_err(refused)
}

/// The tracker to measure: its configuration, and the name of its figures.
fn variant(name: &str, tracker: &Tracker) -> PyResult<Variant> {
    let target = &*tracker.target()?;
    let (configs, mut options): (Configs, _) = match target {
        Target::Paper(of) => ((*of.config()).into(), options::all(of.config())),
        Target::Robust(of) => ((*of.config()).into(), options::all(of.config())),
    };
    options.insert("preset".to_owned(), tracker.preset.into());
    Ok(Variant { name: name.to_owned(), options, ..Variant::new(target.kind(), &configs) })
}

/// Measures trackers on one recording: the table `measured` of `host-sim eval --robustness`, as columns.
#[pyfunction]
pub fn measure<'py>(
    py: Python<'py>,
    path: PathBuf,
    trackers: &Bound<'py, PyDict>,
    starts: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let starts = match starts.extract::<&str>() {
        Ok("given") => Starts::Given,
        Ok("near") => Starts::Near,
        _ => match starts.extract::<NonZeroUsize>() {
            Ok(every) => Starts::Every(every),
            Err(_) => {
                let expected = "'given', 'near' or the number of frames between starts";
                return Err(PyValueError::new_err(format!("starts: expected {expected}, found {starts}")));
            }
        },
    };
    let named = |(name, tracker): (Bound<'py, PyAny>, Bound<'py, PyAny>)| {
        variant(name.extract()?, tracker.cast::<Tracker>()?.get())
    };
    let variants: Vec<_> = trackers.iter().map(named).collect::<PyResult<_>>()?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(refused)?;
    let mut measured = py.detach(|| alone.install(|| robustness::measure(&[path], open, &variants, starts, &|_| ())));
    if !measured.failures.is_empty() {
        return Err(refused(measured.failures.remove(0)));
    }
    let tables = measured.tables();
    let columns = PyDict::new(py);
    for (name, values) in tables.columns(TableName::Measured) {
        let values: PyResult<Vec<_>> = values.into_iter().map(|value| to_python(py, value)).collect();
        columns.set_item(name, values?)?;
    }
    Ok(columns)
}
