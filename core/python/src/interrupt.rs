//! Ends calls that block, at Ctrl-C or when another thread asks for it.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};
use smr_files::wait::Wanted;
use smr_recordings::Sequence;
use std::panic::{self, AssertUnwindSafe};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Longest time between two looks at Python's signals.
const SLICE: Duration = Duration::from_millis(50);
/// Time for an interrupted reader to end its child processes. A reader that waits for a file to be opened takes longer,
/// has none, and goes on alone.
const ENDING: Duration = Duration::from_millis(500);

/// Payload of the unwinding that ends a work without waits, such as an evaluation.
struct Ended;

/// Runs `work`, which must not use Python, in a thread of its own. Meanwhile this one looks at signals, which Python
/// handles in its main thread only.
///
/// After a signal whose handler raises an exception, or after `wanted.end()` in any thread, this call ends the waits of
/// `work` and fails; what `work` then returns is dropped. All calls that may block go through here.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    wanted: &Wanted,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Interrupted> {
    if wanted.has_ended() {
        return Err(Interrupted::Ended);
    }
    let (sender, mut done) = channel();
    let flag = wanted.clone();
    let worker = move || {
        let worked = panic::catch_unwind(AssertUnwindSafe(|| flag.scope(work)));
        // Nobody receives it if this call was interrupted.
        let _ = sender.send(worked);
    };
    thread::Builder::new().spawn(worker).map_err(|error| Interrupted::Raised(error.into()))?;
    loop {
        let worker = &mut done;
        match py.detach(move || worker.recv_timeout(SLICE)) {
            Ok(Ok(worked)) if !wanted.has_ended() => return Ok(worked),
            Ok(Err(payload)) if !payload.is::<Ended>() => panic::resume_unwind(payload),
            Ok(_) | Err(RecvTimeoutError::Disconnected) => return Err(Interrupted::Ended),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let interrupt = py.check_signals();
        if interrupt.is_err() || wanted.has_ended() {
            wanted.end();
            // Waits for the child processes to end, because Python may end directly after this call.
            let _ = py.detach(move || done.recv_timeout(ENDING));
            return Err(interrupt.err().map_or(Interrupted::Ended, Interrupted::Raised));
        }
    }
}

/// The reason why a call has no result.
pub enum Interrupted {
    /// The handler of a signal raised this exception.
    Raised(PyErr),
    /// Another thread ended the call.
    Ended,
}

impl From<Interrupted> for PyErr {
    fn from(interrupted: Interrupted) -> Self {
        match interrupted {
            Interrupted::Raised(error) => error,
            Interrupted::Ended => PyRuntimeError::new_err("another thread ended this call"),
        }
    }
}

/// Ends calls from another thread. A copy in another process ends none.
#[pyclass(frozen, module = "smr._smr")]
#[derive(Default)]
pub struct Stop(pub Wanted);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Ends the calls that were given this object, now and later.
    fn end(&self) {
        self.0.end();
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, Bound<'py, PyTuple>) {
        (slf.get_type(), PyTuple::empty(slf.py()))
    }
}

/// Ends the work of this thread if nobody wants it any more.
pub fn check(wanted: &Wanted) {
    if wanted.has_ended() {
        panic::resume_unwind(Box::new(Ended));
    }
}

/// Makes each frame of a recording a place at which the work of `wanted` can end.
pub fn checked(sequence: Sequence, wanted: &Wanted) -> Sequence {
    let wanted = wanted.clone();
    let frames = sequence.frames.inspect(move |_| check(&wanted));
    Sequence { frames: Box::new(frames), ..sequence }
}

/// Looks at signals while this thread has no lock of Python, at most every [`SLICE`].
pub struct Signals(Instant);

impl Signals {
    pub fn new() -> Self {
        Self(Instant::now())
    }

    pub fn check(&mut self) -> PyResult<()> {
        if self.0.elapsed() < SLICE {
            return Ok(());
        }
        self.0 = Instant::now();
        Python::attach(|py| py.check_signals())
    }
}
