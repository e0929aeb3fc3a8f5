//! How far a command has got with a recording: on standard error, and only if it is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of so many frames; without their number they are counted.
pub fn bar(name: &str, frames: Option<usize>) -> ProgressBar {
    let (bar, template) = match frames {
        Some(frames) => (ProgressBar::new(frames as u64), "{msg} [{bar:40}] {pos}/{len} frames, {eta} left"),
        None => (ProgressBar::new_spinner(), "{msg} {spinner} {pos} frames, {per_sec}"),
    };
    let style = ProgressStyle::with_template(template);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_message(name.to_owned())
}

/// Entries of a record, of which nobody knows the number.
pub fn entries(name: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {spinner} {pos} entries, {per_sec}");
    ProgressBar::new_spinner()
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(name.to_owned())
}
