//! Converts keyword arguments to a configuration: the numbers of `smr_core::paper::Config` and
//! `smr_core::robust::Config`, by their names.

use crate::answer::to_python;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value, json};
use smr_core::paper::{self, RunnerUp};
use smr_core::{ConfigError, robust};

/// A number of a configuration.
pub enum Slot<'a> {
    Flag(&'a mut bool),
    Byte(&'a mut u8),
    Short(&'a mut u16),
    /// A radius, or a numerator and a denominator.
    Pair(&'a mut u16, &'a mut u16),
    RunnerUp(&'a mut RunnerUp),
}

/// A configuration whose numbers have names.
pub trait Options: Copy {
    const NAMES: &[&str];
    fn slot(&mut self, name: &str) -> Option<Slot<'_>>;
}

/// Implements [`Options`] for a configuration: the name and the place of each number.
macro_rules! options {
    ($config:ty, $of:ident: $($name:literal => $slot:expr,)*) => {
        impl Options for $config {
            const NAMES: &[&str] = &[$($name),*];

            fn slot(&mut self, name: &str) -> Option<Slot<'_>> {
                let $of = self;
                match name {
                    $($name => Some($slot),)*
                    _ => None,
                }
            }
        }
    };
}

options! { robust::Config, of:
    "reach" => Slot::Byte(&mut of.reach),
    "size" => Slot::Flag(&mut of.size),
    "sweep" => Slot::Flag(&mut of.sweep),
    "refiner" => Slot::Flag(&mut of.refiner),
    "patience" => Slot::Byte(&mut of.patience),
    "lost_below" => Slot::Short(&mut of.lost_below),
    "uncertain_below" => Slot::Short(&mut of.uncertain_below),
    "learning_rate" => Slot::Short(&mut of.learning_rate),
    "early_rate" => Slot::Short(&mut of.early_rate),
}

options! { paper::Config, of:
    "window" => Slot::Pair(&mut of.window.x, &mut of.window.y),
    "window_limit" => Slot::Pair(&mut of.window_limit.x, &mut of.window_limit.y),
    "k" => Slot::Pair(&mut of.k.numerator, &mut of.k.denominator),
    "first_threshold" => Slot::Byte(&mut of.first_threshold),
    "least_threshold" => Slot::Byte(&mut of.least_threshold),
    "padding" => Slot::Short(&mut of.padding),
    "growth" => Slot::Short(&mut of.growth),
    "neighbourhood" => Slot::Short(&mut of.neighbourhood),
    "least_ratio" => Slot::Short(&mut of.gate.least_ratio),
    "runner_up_always" => Slot::RunnerUp(&mut of.runner_up),
}

impl Slot<'_> {
    fn get(&self) -> Value {
        match self {
            Self::Flag(flag) => json!(flag),
            Self::Byte(number) => json!(number),
            Self::Short(number) => json!(number),
            Self::Pair(x, y) => json!([x, y]),
            Self::RunnerUp(when) => json!(**when == RunnerUp::Always),
        }
    }

    /// Errors: a text that says what was expected.
    fn set(self, value: &Bound<'_, PyAny>) -> Result<(), &'static str> {
        match self {
            Self::Flag(flag) => *flag = value.extract().map_err(|_| "True or False")?,
            Self::Byte(number) => *number = value.extract().map_err(|_| "a whole number of 0 to 255")?,
            Self::Short(number) => *number = value.extract().map_err(|_| "a whole number of 0 to 65535")?,
            Self::Pair(x, y) => {
                (*x, *y) = value.extract().map_err(|_| "a tuple of two whole numbers of 0 to 65535")?;
            }
            Self::RunnerUp(when) => {
                let always: bool = value.extract().map_err(|_| "True or False")?;
                *when = if always { RunnerUp::Always } else { RunnerUp::WhenItDecides };
            }
        }
        Ok(())
    }
}

/// `config` with the numbers in `given` put in.
/// Errors: an unknown name, or a value of the wrong type or outside its range.
pub fn with<C: Options>(mut config: C, given: Option<&Bound<'_, PyDict>>) -> PyResult<C> {
    for (name, value) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let Some(slot) = config.slot(&name) else {
            return Err(PyTypeError::new_err(format!("no option {name}: expected {}", C::NAMES.join(", "))));
        };
        slot.set(&value)
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
    let of = |name: &&str| Some(((*name).to_owned(), config.slot(name)?.get()));
    C::NAMES.iter().filter_map(of).collect()
}

/// All numbers of the configuration as keyword arguments.
pub fn keywords<'py, C: Options>(py: Python<'py>, config: &C) -> PyResult<Bound<'py, PyDict>> {
    Ok(to_python(py, &Value::Object(all(config)))?.cast_into()?)
}
