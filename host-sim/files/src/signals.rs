//! Signals to this program: one that asks it to stop, and one that ends it after the clean-up.

use crate::cleanup;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::{io, thread};

/// True after a signal that ends this program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// True if the first signal only requests a stop. [`STOPPED`] is then the number of the latest signal, 0 before any.
static STOPS_FIRST: AtomicBool = AtomicBool::new(false);
static STOPPED: AtomicI32 = AtomicI32::new(0);

/// Makes the first signal from here on only request a stop (see [`is_stopped`]); the second one ends this program.
pub fn stop_first() {
    STOPS_FIRST.store(true, Ordering::SeqCst);
}

pub fn is_stopped() -> bool {
    stopped_by().is_some()
}

/// Returns the number of the signal that has requested a stop.
pub fn stopped_by() -> Option<i32> {
    Some(STOPPED.load(Ordering::SeqCst)).filter(|&signal| signal > 0)
}

/// After `stop_first`, records `signal`. Returns true if it is the first signal since, which only requests a stop.
fn asks_to_stop(signal: i32) -> bool {
    STOPS_FIRST.load(Ordering::SeqCst) && STOPPED.swap(signal, Ordering::SeqCst) == 0
}

/// Handles SIGINT, SIGTERM and SIGHUP (unless ignored, as by `nohup`): cleans up, then exits with 128 + signal.
#[cfg(unix)]
pub fn heed() -> io::Result<()> {
    use signal_hook::consts::{SIGCHLD, SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use std::sync::Arc;
    // A write above a limit of the size of files is then an error, and not the end of this program.
    signal_hook::flag::register(SIGXFSZ, Arc::default())?;
    // A parent may have set SIGCHLD to be ignored; the system would then forget the exit status of every child.
    signal_hook::flag::register(SIGCHLD, Arc::default())?;
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(signal));
    let mut signals = signal_hook::iterator::Signals::new(wanted)?;
    thread::spawn(move || {
        if let Some(signal) = signals.forever().find(|&signal| !asks_to_stop(signal)) {
            end_by(signal);
        }
    });
    Ok(())
}

/// Handles Ctrl-C and similar events, the only signals outside Unix: cleans up, then exits with 130.
#[cfg(not(unix))]
pub fn heed() -> io::Result<()> {
    let heed = || {
        if !asks_to_stop(2) {
            end_by(2);
        }
    };
    ctrlc::set_handler(heed).map_err(io::Error::other)
}

/// True if this process ignores the signal. Always false outside Linux, where only unsafe code could find out.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    ignored >> (signal - 1) & 1 == 1
}

fn end_by(signal: i32) -> ! {
    ENDING.store(true, Ordering::SeqCst);
    cleanup::exit(128 + signal)
}

/// Blocks for good if a signal is ending this program. Call it before printing an error that the signal may have
/// caused.
pub fn yield_to_signal() {
    while ENDING.load(Ordering::SeqCst) {
        thread::park();
    }
}
