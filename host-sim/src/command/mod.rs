//! The command line, one file a command. Each file holds the command's arguments and what it does with them.

mod ablate;
mod bench;
mod check;
mod eval;
mod qemu_options;
mod recording_options;
mod recordings;
mod report;
mod robustness;
mod run;
mod synth;
mod target;
mod track;
mod tracker_options;
mod vectors;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::io::{self, ErrorKind, StdoutLock};
use std::process::ExitCode;

/// Replays recordings through smr-core: tracks, checks, measures, shows.
///
/// A SEQ is a folder of pictures (PNG, JPEG, PGM, PPM), a Y4M file, a video that ffmpeg decodes, a raw 8-bit dump (with
/// --size), or a built-in recording: `synthetic`, `periodic` (all ties), `border`, or `noise` (the worst case).
///
/// Exit codes: 0 all is well, 1 a check failed, 2 bad usage or input.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 120)]
pub struct HostSim {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Print the target's box in every frame
    Track(track::Track),
    /// Compare smr-core with the float reference, score by score
    Check(check::Check),
    /// Measure against ground truth, by the protocol of the recordings
    Eval(eval::Eval),
    /// Measure what each part of the robust tracker is worth: the tracker without it, against ground truth
    Ablate(ablate::Ablate),
    /// Measure how fast it is, here and on the emulated boards, beside OpenCV and a plain SAD search
    Bench(bench::Bench),
    /// Show a recording: one HTML page with frames, plots and differences, or a picture
    Report(report::Report),
    /// Write the synthetic recording out as files
    Synth(synth::Synth),
    /// Run the firmware in QEMU on a recording, and compare every answer with the host's
    Target(target::Target),
    /// Run any firmware in QEMU, and print its log
    Run(run::Run),
    /// Print the conformance vectors, made from the float reference
    Vectors(vectors::Vectors),
}

/// What a command has to say at its end, if nothing went wrong on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Holds,
    CheckFailed,
}

impl HostSim {
    /// Runs the command. Errors are one line on standard error: what, where, what was expected.
    pub fn run(self) -> ExitCode {
        match self.dispatch() {
            Ok(Outcome::Holds) => ExitCode::SUCCESS,
            Ok(Outcome::CheckFailed) => ExitCode::from(1),
            Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error:#}");
                ExitCode::from(2)
            }
        }
    }

    fn dispatch(self) -> Result<Outcome> {
        match self.command {
            Command::Track(track) => track.run(),
            Command::Check(check) => check.run(),
            Command::Eval(eval) => eval.run(),
            Command::Ablate(ablate) => ablate.run(),
            Command::Bench(bench) => bench.run(),
            Command::Report(report) => report.run(),
            Command::Synth(synth) => synth.run(),
            Command::Target(target) => target.run(),
            Command::Run(run) => run.run(),
            Command::Vectors(vectors) => vectors.run(),
        }
    }
}

/// Writes a report to standard output. That its reader has gone away (`| head`) ends no check: the verdict is still wanted.
fn say(report: impl FnOnce(&mut StdoutLock<'_>) -> io::Result<()>) -> Result<()> {
    match report(&mut io::stdout().lock()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// `host-sim track ... | head` is not an error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
}
