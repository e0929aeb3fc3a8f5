//! How far a command has got: on standard error, and only if it is a terminal.

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use smr_recordings::messages;
use std::fmt::Write;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A bar of so many frames; without their number they are counted.
pub fn bar(name: &str, frames: Option<usize>) -> ProgressBar {
    of(name, frames, "frames")
}

/// A progress bar that counts something else than frames.
pub fn of(name: &str, count: Option<usize>, what: &str) -> ProgressBar {
    let (bar, template) = match count {
        Some(count) => {
            (ProgressBar::new(count as u64), format!("{{msg}} [{{bar:40}}] {{pos}}/{{len}} {what}, {{left}} left"))
        }
        None => (ProgressBar::new_spinner(), format!("{{msg}} {{spinner}} {{pos}} {what}, {{per_sec}}")),
    };
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style.with_key("left", left)).with_message(messages::line(name))
}

/// How many frames there are, as recordings are opened: those that were not are taken for as long as the others.
pub struct Expected<'a> {
    bar: &'a ProgressBar,
    state: Mutex<Opened>,
}

struct Opened {
    frames: u64,
    recordings: usize,
    /// With those that were not opened yet.
    all: usize,
}

impl<'a> Expected<'a> {
    pub fn of(bar: &'a ProgressBar, recordings: usize) -> Self {
        Self { bar, state: Mutex::new(Opened { frames: 0, recordings: 0, all: recordings }) }
    }

    /// So many frames in so many recordings that were opened.
    pub fn add(&self, frames: u64, recordings: usize) {
        let mut opened = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        opened.frames += frames;
        opened.recordings += recordings;
        self.bar.set_length(opened.frames * opened.all as u64 / opened.recordings.max(1) as u64);
    }
}

/// By the rate of all that was done: that of the last moment says more of the last recording than of those that are left.
fn left(state: &ProgressState, out: &mut dyn Write) {
    let (done, all) = (state.pos(), state.len().unwrap_or(0));
    let seconds = state.elapsed().as_secs_f64() * all.saturating_sub(done) as f64 / done.max(1) as f64;
    // What cannot be written is not shown.
    let _ =
        if done == 0 { write!(out, "-") } else { write!(out, "{:#}", HumanDuration(Duration::from_secs_f64(seconds))) };
}
