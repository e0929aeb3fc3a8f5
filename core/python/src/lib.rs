//! The extension module `smr._smr`: the trackers of smr-core as Python classes. Conversions only; the package `smr` is around it.

mod answer;
mod frame;
mod options;
mod recording;
mod target;
mod tracker;

#[pyo3::pymodule]
mod _smr {
    #[pymodule_export]
    use super::{
        recording::{Recording, measure, recordings, start_beside},
        tracker::{Paper, Robust, Tracker, follow},
    };
    use crate::options::document;
    use pyo3::prelude::*;
    use smr_core::{paper, robust};

    /// Loads numpy, lists the options, and adds the version of the workspace, which the wheel has, too.
    /// Otherwise the first array would load numpy, and panic if Ctrl-C is pressed meanwhile.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.py().import("numpy")?;
        numpy::PyArray1::<u8>::zeros(module.py(), 0, false);
        document::<paper::Config>(&module.getattr("Paper")?, "camera")?;
        document::<robust::Config>(&module.getattr("Robust")?, "refined")?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
