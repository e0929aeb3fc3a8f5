//! The command line, one file a command. Each file holds the command's arguments and what it does with them.

mod ablate;
#[cfg(feature = "bench")]
mod bench;
mod check;
mod eval;
mod frame;
#[cfg(any(test, not(feature = "bench")))]
mod not_built;
#[cfg(feature = "emulator")]
mod qemu_options;
mod recording_options;
mod recordings;
mod report;
mod robustness;
#[cfg(feature = "emulator")]
mod run;
mod synth;
#[cfg(feature = "emulator")]
mod target;
mod track;
mod tracker_options;
mod vectors;

use crate::output::print;
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
    /// Write one frame with a grid of coordinates as a picture, to choose or check a box
    Frame(frame::Frame),
    /// Print the target's box in every frame
    Track(track::Track),
    /// Compare smr-core with the float reference, score by score
    Check(check::Check),
    /// Measure against ground truth, by the protocol of the recordings
    Eval(eval::Eval),
    /// Measure what each part of the robust tracker is worth: the tracker without it, against ground truth
    Ablate(ablate::Ablate),
    #[cfg(feature = "bench")]
    /// Measure how fast it is, here and on the emulated boards, beside OpenCV and a plain SAD search
    Bench(bench::Bench),
    #[cfg(not(feature = "bench"))]
    /// Measure how fast it is (not built in: --features bench)
    Bench(not_built::NotBuilt),
    /// Show a recording: one HTML page with frames, plots and differences, or a picture
    Report(report::Report),
    /// Write the synthetic recording out as files
    Synth(synth::Synth),
    #[cfg(feature = "emulator")]
    /// Run the firmware in QEMU on a recording, and compare every answer with the host's
    Target(target::Target),
    #[cfg(not(feature = "emulator"))]
    /// Run the firmware in QEMU on a recording (not built in: --features emulator)
    Target(not_built::NotBuilt),
    #[cfg(feature = "emulator")]
    /// Run any firmware in QEMU, and print its log
    Run(run::Run),
    #[cfg(not(feature = "emulator"))]
    /// Run any firmware in QEMU (not built in: --features emulator)
    Run(not_built::NotBuilt),
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
            Command::Frame(frame) => frame.run(),
            Command::Track(track) => track.run(),
            Command::Check(check) => check.run(),
            Command::Eval(eval) => eval.run(),
            Command::Ablate(ablate) => ablate.run(),
            #[cfg(feature = "bench")]
            Command::Bench(bench) => bench.run(),
            #[cfg(not(feature = "bench"))]
            Command::Bench(bench) => bench.run("bench", "bench"),
            Command::Report(report) => report.run(),
            Command::Synth(synth) => synth.run(),
            #[cfg(feature = "emulator")]
            Command::Target(target) => target.run(),
            #[cfg(not(feature = "emulator"))]
            Command::Target(target) => target.run("target", "emulator"),
            #[cfg(feature = "emulator")]
            Command::Run(run) => run.run(),
            #[cfg(not(feature = "emulator"))]
            Command::Run(run) => run.run("run", "emulator"),
            Command::Vectors(vectors) => vectors.run(),
        }
    }
}

/// Writes a report to standard output. That its reader has gone away (`| head`) ends no check: the verdict is still wanted.
fn say(report: impl FnOnce(&mut StdoutLock<'_>) -> io::Result<()>) -> Result<()> {
    match print(report) {
        Err(error) if !is_closed_pipe(&error) => Err(error),
        _ => Ok(()),
    }
}

/// `host-sim track ... | head` is not an error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    io.is_some_and(|io| io.kind() == ErrorKind::BrokenPipe)
}
