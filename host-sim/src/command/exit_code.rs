//! Exit codes of a command: 0 success, 1 a check failed, 2 bad usage or input, 128 + N ended by signal N. An error is
//! printed as one line on standard error: what is wrong, where, and what was expected.

use super::usage;
use anyhow::{Context, Result, anyhow};
use clap::Parser;
use smr_evaluation::Refused;
use smr_files::output::{ReaderGone, complain};
use smr_files::{messages, signals};
use smr_recordings::Damaged;
use std::ffi::OsString;
use std::process::ExitCode;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Holds,
    CheckFailed,
    /// Stopped by the signal of this number.
    Stopped(i32),
}

/// Runs a program that is a single command, with the signal handling, errors and exit codes of host-sim.
pub fn program<T: Parser>(run: impl FnOnce(T) -> Result<Outcome>) -> ExitCode {
    obey(std::env::args_os().collect(), run)
}

pub(super) fn obey<T: Parser>(arguments: Vec<OsString>, run: impl FnOnce(T) -> Result<Outcome>) -> ExitCode {
    let all = T::command();
    // Messages use the program's own name, even if its executable file is renamed.
    let all = all.clone().bin_name(all.get_name().to_owned());
    if let Err(error) = signals::heed().context("cannot wait for signals") {
        return refused(&error, &all);
    }
    let arguments = usage::joined(arguments);
    let matches = all.clone().try_get_matches_from(&arguments);
    let name = matches.as_ref().ok().and_then(|matches| matches.subcommand_name()).unwrap_or("");
    let command = all.find_subcommand(name).unwrap_or(&all).clone();
    let line = match matches.and_then(|matches| T::from_arg_matches(&matches)) {
        Ok(line) => line,
        Err(error) if !error.use_stderr() => error.exit(),
        Err(error) => return refused(&anyhow!(usage::explained(&error, &all, &arguments)), &command),
    };
    let done = run(line);
    signals::yield_to_signal();
    match done {
        Ok(Outcome::Holds) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Ok(Outcome::Stopped(signal)) => ExitCode::from(u8::try_from(128 + signal).unwrap_or(u8::MAX)),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => refused(&error, &command),
    }
}

/// Returns the message of an error; for a refused box or a damaged recording also names options of `command` that help.
pub(super) fn told(error: &anyhow::Error, command: &clap::Command) -> String {
    let said = messages::of(error);
    let has = |name: &str| command.get_arguments().any(|option| option.get_long() == Some(name));
    if let Some(box_) = error.downcast_ref::<Refused>() {
        return format!("{said}: {}", box_.way_out(has));
    }
    match error.downcast_ref::<Damaged>().and_then(Damaged::whole_part) {
        Some(part) if has("frames") => format!("{said} (--frames {part} takes the frames before it)"),
        _ => said,
    }
}

fn refused(error: &anyhow::Error, command: &clap::Command) -> ExitCode {
    signals::yield_to_signal();
    complain(&format!("error: {}", told(error, command)));
    ExitCode::from(2)
}

/// True if the reader of standard output is gone (`host-sim track ... | head`), which is no error.
pub(super) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.is::<ReaderGone>()
}
