//! Converts keyword arguments to a configuration: the numbers of `smr_core::paper::Config` and
//! `smr_core::robust::Config`, by their names.

use crate::answer::to_python;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value, json};
use smr_core::paper::{self, Fraction, Margins, Radius, RunnerUp};
use smr_core::{ConfigError, robust};

/// A number of a configuration.
pub trait Number {
    fn get(&self) -> Value;
    /// Errors: a text that says what was expected.
    fn set(&mut self, value: &Bound<'_, PyAny>) -> Result<(), &'static str>;
}

/// Implements [`Number`]: the type in Rust and in Python, the text, and how each is made from the other.
macro_rules! number {
    ($($number:ty, $python:ty, $expected:literal, |$own:ident| $shown:expr, |$given:ident| $taken:expr;)*) => {$(
        impl Number for $number {
            fn get(&self) -> Value {
                let $own = self;
                json!($shown)
            }

            fn set(&mut self, value: &Bound<'_, PyAny>) -> Result<(), &'static str> {
                let $given: $python = value.extract().map_err(|_| $expected)?;
                *self = $taken;
                Ok(())
            }
        }
    )*};
}

number! {
    bool, bool, "True or False", |own| own, |given| given;
    u8, u8, "a whole number of 0 to 255", |own| own, |given| given;
    u16, u16, "a whole number of 0 to 65535", |own| own, |given| given;
    Radius, (u16, u16), "a tuple of two whole numbers of 0 to 65535",
        |own| (own.x, own.y), |given| Self { x: given.0, y: given.1 };
    Fraction, (u16, u16), "a tuple of two whole numbers of 0 to 65535",
        |own| (own.numerator, own.denominator), |given| Self::new(given.0, given.1);
    Margins, (u16, u16, u16, u16), "a tuple of four whole numbers of 0 to 65535",
        |own| (own.left, own.top, own.right, own.bottom),
        |given| Self { left: given.0, top: given.1, right: given.2, bottom: given.3 };
    RunnerUp, bool, "True or False",
        |own| *own == Self::Always, |given| if given { Self::Always } else { Self::WhenItDecides };
}

/// A configuration whose numbers have names.
pub trait Options: Copy {
    const NAMES: &[&str];
    fn number(&mut self, name: &str) -> Option<&mut dyn Number>;
}

/// Implements [`Options`] for a configuration: its fields, and others by their place.
macro_rules! options {
    ($config:ty: $($field:ident),+; $($name:ident = $($place:ident).+),*) => {
        impl Options for $config {
            const NAMES: &[&str] = &[$(stringify!($field),)+ $(stringify!($name)),*];

            fn number(&mut self, name: &str) -> Option<&mut dyn Number> {
                match name {
                    $(stringify!($field) => Some(&mut self.$field),)+
                    $(stringify!($name) => Some(&mut self.$($place).+),)*
                    _ => None,
                }
            }
        }
    };
}

options! { robust::Config:
    reach, size, sweep, refiner, patience, lost_below, uncertain_below, learning_rate, early_rate;
}

options! { paper::Config:
    window, window_limit, k, first_threshold, least_threshold, padding, growth, neighbourhood, update_zone;
    gate_tracking = gate.tracking,
    gate_leaving = gate.leaving,
    gate_returning = gate.returning,
    gate_lost = gate.lost,
    gate_lead = gate.lead,
    least_ratio = gate.least_ratio,
    runner_up_always = runner_up
}

/// `config` with the numbers in `given` put in.
/// Errors: an unknown name, or a value of the wrong type or outside its range.
pub fn with<C: Options>(mut config: C, given: Option<&Bound<'_, PyDict>>) -> PyResult<C> {
    for (name, value) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let Some(number) = config.number(&name) else {
            return Err(PyTypeError::new_err(format!("no option {name}: expected {}", C::NAMES.join(", "))));
        };
        number
            .set(&value)
            .map_err(|expected| PyValueError::new_err(format!("{name}: expected {expected}, found {value}")))?;
    }
    Ok(config)
}

/// `built`, or an error that says why the core refuses the configuration, with the options that were given.
pub fn of_range<T>(built: Result<T, ConfigError>, given: Option<&Bound<'_, PyDict>>) -> PyResult<T> {
    let given = || given.map_or_else(|| "{}".to_owned(), ToString::to_string);
    built.map_err(|error| PyValueError::new_err(format!("{error}: {}", given())))
}

/// All numbers of the configuration by their names.
pub fn all<C: Options>(config: &C) -> Map<String, Value> {
    let mut config = *config;
    let of = |name: &&str| Some(((*name).to_owned(), config.number(name)?.get()));
    C::NAMES.iter().filter_map(of).collect()
}

/// All numbers of the configuration as keyword arguments.
pub fn keywords<'py, C: Options>(py: Python<'py>, config: &C) -> PyResult<Bound<'py, PyDict>> {
    Ok(to_python(py, &Value::Object(all(config)))?.cast_into()?)
}
