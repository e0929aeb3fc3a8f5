//! The extension module `smr._smr`: converts between smr-core and Python. The Python package `smr` wraps it.

mod answer;
mod frame;
mod interrupt;
mod options;
mod recording;
mod target;
mod tracker;

#[pyo3::pymodule]
mod _smr {
    #[pymodule_export]
    use super::{
        interrupt::Stop,
        recording::{Decoded, Recording, measure, recordings, start_beside},
        tracker::{Paper, Robust, Tracker, follow},
    };
    use crate::options::document;
    use pyo3::prelude::*;
    use smr_core::{paper, robust};

    /// Documents the options. Loads numpy now: if the first array loaded it, a Ctrl-C at that time would cause a panic.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.py().import("numpy")?;
        numpy::PyArray1::<u8>::zeros(module.py(), 0, false);
        document::<paper::Config>(&module.getattr("Paper")?, "camera")?;
        document::<robust::Config>(&module.getattr("Robust")?, "refined")?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
