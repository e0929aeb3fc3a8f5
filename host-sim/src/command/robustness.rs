//! The measurement of robustness as commands run it: starts from the command line, progress on a terminal, failures named.

use super::recording_options::RecordingOptions;
use super::{Outcome, progress, told};
use anyhow::{Error, Result, bail};
use smr_evaluation::Variant;
use smr_evaluation::robustness::{self, Progress, Robustness, Starts};
use smr_recordings::cleanup;
use smr_recordings::output::complain;
use std::path::{Path, PathBuf};

/// Measures `variants` for `command` on what is at `paths`, names what fails, and tells how much that is.
/// Errors: No recording is there, or the only thing that was asked for failed.
pub fn measure(
    command: &clap::Command,
    paths: &[PathBuf],
    recording: &RecordingOptions,
    variants: &[Variant],
    starts: Starts,
) -> Result<(Robustness, usize)> {
    let found = recording.find(paths)?;
    let bar = progress::bar(command.get_name(), Some(0));
    let open = |path: &Path| recording.open(path);
    let expected = progress::Expected::of(&bar, found.len());
    cleanup::stop_first();
    let progress = |progress| match progress {
        Progress::Expected { frames, recordings } => expected.add(frames, recordings),
        Progress::Done => bar.inc(1),
    };
    let mut robustness = robustness::measure(&found, open, variants, starts, &progress);
    bar.finish_and_clear();
    if cleanup::is_stopped() {
        complain("stopped: these are the results until now");
    }
    let failed = count_failures(std::mem::take(&mut robustness.failures), robustness.is_empty(), command)?;
    Ok((robustness, failed))
}

/// Names what failed, and tells how much that is.
/// Errors: All that was asked for is one thing, which failed: one line says it all.
pub fn count_failures(mut failures: Vec<Error>, all: bool, command: &clap::Command) -> Result<usize> {
    if all && failures.len() == 1 { Err(failures.remove(0)) } else { Ok(say_what_failed(&failures, command)) }
}

/// One line on standard error for everything that could not be measured; how many there are.
pub fn say_what_failed<'a>(errors: impl IntoIterator<Item = &'a Error>, command: &clap::Command) -> usize {
    let say = |error: &Error| {
        cleanup::yield_to_signal();
        complain(&format!("error: {}", told(error, command)));
    };
    errors.into_iter().map(say).count()
}

/// The end of a command of which so many parts failed.
/// Errors: one part or more failed.
pub fn end(failed: usize) -> Result<Outcome> {
    if let Some(signal) = cleanup::stopped_by() {
        return Ok(Outcome::Stopped(signal));
    }
    if failed > 0 {
        bail!("{failed} of what was asked for could not be measured (see above); results are of the rest");
    }
    Ok(Outcome::Holds)
}
