//! How a command ends: the exit code, and the one line on standard error that says what, where, what was expected.
//!
//! | exit code | |
//! |---|---|
//! | 0 | it holds |
//! | 1 | a check failed |
//! | 2 | bad usage or input |
//! | 128 and more | a signal came, of this number less 128 ([`cleanup`]) |

use anyhow::{Context, Result, anyhow};
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind as Usage};
use smr_evaluation::Refused;
use smr_recordings::output::complain;
use smr_recordings::{Damaged, cleanup, messages};
use std::error::Error;
use std::ffi::OsString;
use std::io::{self, ErrorKind};
use std::process::ExitCode;

/// What a command has to say at its end, if nothing went wrong on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Holds,
    CheckFailed,
    /// A signal of this number has asked to stop.
    Stopped(i32),
}

/// Runs another program, of one command: signals, errors and exit codes are those of host-sim.
pub fn program<T: Parser>(run: impl FnOnce(T) -> Result<Outcome>) -> ExitCode {
    obey(std::env::args_os().collect(), run)
}

pub(super) fn obey<T: Parser>(arguments: Vec<OsString>, run: impl FnOnce(T) -> Result<Outcome>) -> ExitCode {
    let all = T::command();
    if let Err(error) = cleanup::heed_signals().context("cannot wait for signals") {
        return refused(&error, &all);
    }
    let matches = all.clone().try_get_matches_from(arguments);
    let name = matches.as_ref().ok().and_then(|matches| matches.subcommand_name()).unwrap_or("");
    let command = all.find_subcommand(name).unwrap_or(&all).clone();
    let line = match matches.and_then(|matches| T::from_arg_matches(&matches)) {
        Ok(line) => line,
        Err(error) => {
            return match bad_value(&error) {
                Some(said) => refused(&anyhow!(said), &command),
                None => misused(error),
            };
        }
    };
    let done = run(line);
    cleanup::yield_to_signal();
    match done {
        Ok(Outcome::Holds) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Ok(Outcome::Stopped(signal)) => ExitCode::from(u8::try_from(128 + signal).unwrap_or(u8::MAX)),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => refused(&error, &command),
    }
}

/// A value that an option does not take, in one line; `None` of other bad usage, of which clap says more.
fn bad_value(error: &clap::Error) -> Option<String> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let (argument, value) = (text(ContextKind::InvalidArg)?, text(ContextKind::InvalidValue)?);
    // `--window <XxY>` is called by its name alone.
    let name = argument.split(' ').next().filter(|name| name.starts_with('-')).unwrap_or(argument);
    let shown =
        if value.is_empty() || value.contains(char::is_whitespace) { format!("{value:?}") } else { value.to_owned() };
    let expected = match (error.kind(), error.get(ContextKind::ValidValue)) {
        (Usage::ValueValidation, _) => error.source()?.to_string(),
        (Usage::InvalidValue, Some(ContextValue::Strings(known))) if known.is_empty() => "expected a value".to_owned(),
        (Usage::InvalidValue, Some(ContextValue::Strings(known))) => format!("expected one of {}", known.join(", ")),
        _ => return None,
    };
    Some(format!("{name} {shown}: {expected}"))
}

/// Prints other bad usage as clap does, or the help that was asked for. Without the advice to put `--` before an option that there is not.
fn misused(mut error: clap::Error) -> ExitCode {
    if !error.use_stderr() {
        error.exit();
    }
    if let Some(ContextValue::StyledStrs(mut advice)) = error.remove(ContextKind::Suggested) {
        advice.retain(|advice| !advice.to_string().starts_with("to pass "));
        if !advice.is_empty() {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(advice));
        }
    }
    error.render().to_string().trim_end().lines().for_each(complain);
    ExitCode::from(2)
}

/// What is printed of an error of this command; a box that is refused and damage come with what the command has against them.
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
    cleanup::yield_to_signal();
    complain(&format!("error: {}", told(error, command)));
    ExitCode::from(2)
}

/// `host-sim track ... | head` is not an error.
pub(super) fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
}
