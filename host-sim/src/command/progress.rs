//! How far a command has got: on standard error, and only if it is a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use smr_recordings::messages;

/// A bar of so many frames; without their number they are counted.
pub fn bar(name: &str, frames: Option<usize>) -> ProgressBar {
    of(name, frames, "frames")
}

/// A progress bar that counts something else than frames.
pub fn of(name: &str, count: Option<usize>, what: &str) -> ProgressBar {
    let (bar, template) = match count {
        Some(count) => {
            (ProgressBar::new(count as u64), format!("{{msg}} [{{bar:40}}] {{pos}}/{{len}} {what}, {{eta}} left"))
        }
        None => (ProgressBar::new_spinner(), format!("{{msg}} {{spinner}} {{pos}} {what}, {{per_sec}}")),
    };
    let style = ProgressStyle::with_template(&template);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_message(messages::line(name))
}
