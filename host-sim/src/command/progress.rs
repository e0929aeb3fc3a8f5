//! Progress line of a command, on standard error if it is a terminal.

use smr_files::messages;
use smr_files::output::{ERASE, has_cursor};
use std::io::{Write, stderr};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

const PAUSE: Duration = Duration::from_millis(100);
/// Terminal codes that turn line wrapping off and on, so that a long line is cut.
const CUT: [&str; 2] = ["\x1b[?7l", "\x1b[?7h"];

/// A progress line such as `car: 120 of 300 frames, 4 s left`.
pub struct Bar {
    name: String,
    what: &'static str,
    is_hidden: bool,
    began: Instant,
    state: Mutex<State>,
}

struct State {
    done: u64,
    all: Option<u64>,
    shown: Instant,
}

/// Creates a progress line for `frames` frames. With `None` it shows the number of frames done and their rate.
pub fn bar(name: &str, frames: Option<usize>) -> Bar {
    of(name, frames, "frames")
}

/// Creates a progress line that counts `what` instead of frames.
pub fn of(name: &str, count: Option<usize>, what: &'static str) -> Bar {
    let now = Instant::now();
    let state = Mutex::new(State { done: 0, all: count.map(|count| count as u64), shown: now });
    Bar { name: messages::line(name), what, is_hidden: !has_cursor(), began: now, state }
}

impl Bar {
    pub fn hidden() -> Self {
        let mut hidden = of("", None, "");
        hidden.is_hidden = true;
        hidden
    }

    pub const fn is_hidden(&self) -> bool {
        self.is_hidden
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn inc(&self) {
        let mut state = self.state();
        state.done += 1;
        if !self.is_hidden && state.shown.elapsed() >= PAUSE {
            state.shown = Instant::now();
            // Output errors are ignored, because progress is no result.
            let _ = write!(stderr(), "{ERASE}{}{}{}{}", CUT[0], self.name, self.line(&state), CUT[1]);
        }
    }

    fn line(&self, State { done, all, .. }: &State) -> String {
        let seconds = self.began.elapsed().as_secs_f64();
        match all {
            Some(all) => {
                // Estimates the time left from the mean rate since the start, because the latest rate depends on a
                // single recording.
                let left = seconds * all.saturating_sub(*done) as f64 / *done as f64;
                format!(": {done} of {all} {}, {left:.0} s left", self.what)
            }
            None => format!(": {done} {}, {:.0} a second", self.what, *done as f64 / seconds),
        }
    }

    /// Clears the line before other output to the terminal.
    pub fn suspend<T>(&self, write: impl FnOnce() -> T) -> T {
        self.clear();
        write()
    }

    pub fn clear(&self) {
        if !self.is_hidden {
            let _ = write!(stderr(), "{ERASE}");
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Estimates the number of frames: a recording that is not opened yet counts with the mean length of the opened ones.
pub struct Expected<'a> {
    bar: &'a Bar,
    state: Mutex<Opened>,
}

struct Opened {
    frames: u64,
    recordings: usize,
    all: usize,
}

impl<'a> Expected<'a> {
    pub fn of(bar: &'a Bar, recordings: usize) -> Self {
        Self { bar, state: Mutex::new(Opened { frames: 0, recordings: 0, all: recordings }) }
    }

    pub fn add(&self, frames: u64, recordings: usize) {
        let mut opened = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        opened.frames += frames;
        opened.recordings += recordings;
        self.bar.state().all = Some(opened.frames * opened.all as u64 / opened.recordings.max(1) as u64);
    }
}
