//! Converts results to Python objects: boxes, answers and JSON values.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use serde_json::Value;
use smr_core::{Answer, FineRect, Rect};

/// A class of the Python module `smr._answer`, cached in `cell`.
fn class<'py>(py: Python<'py>, cell: &'static PyOnceLock<Py<PyAny>>, name: &str) -> PyResult<&'py Bound<'py, PyAny>> {
    let found = cell.get_or_try_init(py, || PyResult::Ok(py.import("smr._answer")?.getattr(name)?.unbind()))?;
    Ok(found.bind(py))
}

/// Converts to a Python `Box`.
pub fn to_box<'py>(py: Python<'py>, rect: Rect) -> PyResult<Bound<'py, PyAny>> {
    static BOX: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    class(py, &BOX, "Box")?.call1((rect.x, rect.y, rect.width, rect.height))
}

fn to_fine_box<'py>(py: Python<'py>, rect: FineRect) -> PyResult<Bound<'py, PyAny>> {
    static FINE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let pixels = |number: i32| f64::from(number) / 256.0;
    let size = |number: u32| f64::from(number) / 256.0;
    class(py, &FINE, "FineBox")?.call1((pixels(rect.x), pixels(rect.y), size(rect.width), size(rect.height)))
}

/// Converts a ratio in units of 1/65535 to a float.
pub fn ratio_to_float(ratio: u16) -> f64 {
    f64::from(ratio) / f64::from(u16::MAX)
}

/// Converts to a Python `Answer`, whose ratios are floats of 0.0 to 1.0.
pub fn answer<'py>(py: Python<'py>, answer: &Answer) -> PyResult<Bound<'py, PyAny>> {
    static ANSWER: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    static STATES: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let state = class(py, &STATES, "STATES")?.get_item(answer.state.code())?;
    class(py, &ANSWER, "Answer")?.call1((
        to_box(py, answer.bbox)?,
        to_fine_box(py, answer.fine)?,
        state,
        ratio_to_float(answer.confidence),
        ratio_to_float(answer.ratio),
        answer.runner_up_ratio.map(ratio_to_float),
        answer.alpha,
        answer.identity.map(ratio_to_float),
        f64::from(answer.scale) / 65536.0,
        answer.found_again,
    ))
}

pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}
