//! Converts keyword arguments to a configuration, by the names of its settings.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value, json};
use smr_core::{ConfigError, Setting, Settings, Shape};
use std::ffi::CString;

/// Returns `config` with the options in `given`. Fails on an unknown name, a wrong type or a value outside its range.
pub fn with<C: Settings>(mut config: C, given: Option<&Bound<'_, PyDict>>) -> PyResult<C> {
    for (name, value) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let Some(setting) = config.settings().find(|setting| setting.name() == name) else {
            let names: Vec<_> = C::SETTINGS.iter().map(Setting::name).collect();
            return Err(PyTypeError::new_err(format!("no option {name}: expected {}", names.join(", "))));
        };
        let values = numbers(setting.shape, &value)
            .map_err(|_| PyValueError::new_err(format!("{name}: expected {}, found {value}", expected(&setting))))?;
        config.set(&name, &values).map_err(|error| PyValueError::new_err(error.to_string()))?;
    }
    Ok(config)
}

fn numbers(shape: Shape, value: &Bound<'_, PyAny>) -> PyResult<Vec<u16>> {
    match shape {
        Shape::Switch => Ok(vec![value.extract::<bool>()?.into()]),
        Shape::Number => Ok(vec![value.extract()?]),
        Shape::Fraction | Shape::Radius | Shape::Margins => {
            let values: Vec<u16> = value.extract()?;
            if values.len() == shape.count() { Ok(values) } else { Err(PyTypeError::new_err("another count")) }
        }
    }
}

/// The expected type and range of a setting, for messages.
fn expected(setting: &Setting) -> String {
    let shape = match setting.shape {
        Shape::Switch => return "True or False".to_owned(),
        Shape::Number => "a whole number",
        Shape::Fraction | Shape::Radius => "a tuple of two whole numbers",
        Shape::Margins => "a tuple of four whole numbers",
    };
    format!("{shape} of {} to {}", setting.lowest, setting.highest)
}

/// Adds all options to the docstring and signature of a class. `first` is the name of the default preset.
pub fn document<C: Settings>(class: &Bound<'_, PyAny>, first: &str) -> PyResult<()> {
    let mut text: String = class.getattr("__doc__")?.extract()?;
    text.push('\n');
    for (setting, about) in C::SETTINGS.iter().zip(C::TEXTS) {
        text += &format!("\n- `{}`, {}: {about}", setting.name(), expected(setting));
    }
    class.setattr("__doc__", text)?;
    let names: Vec<_> = C::SETTINGS.iter().map(Setting::name).collect();
    let alike = CString::new(format!("lambda preset='{first}', *, {}=...: 0", names.join("=..., ")))?;
    let py = class.py();
    class.setattr("__signature__", py.import("inspect")?.call_method1("signature", (py.eval(&alike, None, None)?,))?)
}

/// Returns `built`, or an exception with the options `given` and the reason why the core refuses the configuration.
pub fn or_value_error<T>(built: Result<T, ConfigError>, given: Option<&Bound<'_, PyDict>>) -> PyResult<T> {
    let given = || given.map_or_else(|| "{}".to_owned(), ToString::to_string);
    built.map_err(|error| PyValueError::new_err(format!("{error}: {}", given())))
}

pub fn all<C: Settings>(config: &C) -> Map<String, Value> {
    let of = |setting: &Setting| {
        let values = config.get(setting.name()).unwrap_or_default();
        let value = match setting.shape {
            Shape::Switch => json!(values[0] != 0),
            Shape::Number => json!(values[0]),
            shape => json!(values[..shape.count()]),
        };
        (setting.name().to_owned(), value)
    };
    C::SETTINGS.iter().map(of).collect()
}
