//! Command line of host-sim, one file for each command. Test programs reuse its options ([`program`]).

mod check;
mod convert;
mod eval;
mod events;
mod exit_code;
mod names;
mod paths;
mod progress;
pub mod recording_options;
mod replay;
mod report;
mod session;
mod shell;
mod steady;
mod track;
mod tracker_options;
mod usage;
mod video;
mod view;

use anyhow::{Context, Result, anyhow};
use clap::{CommandFactory, Parser, Subcommand};
pub use exit_code::{Outcome, program};
use exit_code::{is_closed_pipe, obey, told};
use serde::Serialize;
use smr_files::output::print;
use smr_recordings::{BUILT_IN, is_live, street};
use std::ffi::OsString;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::path::Path;
use std::process::ExitCode;
use std::str::FromStr;

/// Replays recordings through smr-core: tracks, checks, measures, shows. `host-sim SEQ` opens a recording in the viewer. `host-sim` alone
/// follows the target of a built-in recording and shows it on a page.
///
/// A SEQ is a folder of pictures (PNG, JPEG, PGM, PPM, PAM), a Y4M file, a video that ffmpeg decodes, a raw 8-bit dump (with --size), `-`
/// (Y4M from standard input), or a built-in recording: `street`, `synthetic`, `synthetic:SEED` (another such scene, without an end: give
/// --frames), `periodic` (a pattern in which positions tie), `border` (a target at the edge), `noise` (the most work) or `tiles` (which
/// firmware draws as well). `track` and `view` also open /dev/video0 and addresses such as rtsp://...
///
/// Without --init, the initial box comes from init.txt, gt.txt (both x1,y1,x2,y2), groundtruth_rect.txt (OTB) or groundtruth.txt (VOT,
/// GOT-10k) beside the recording. `track` and `report` first take the targets that `view` keeps there (SEQ.smr.json).
///
/// Limits: 64 MiB for a file of boxes or of earlier results, 512 MiB for a picture.
///
/// Exit codes: 0 success, 1 a check failed, 2 bad usage or input. After INT, TERM or HUP: 128 plus the signal's number, or 0 if the source
/// was live.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 120)]
pub struct HostSim {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Open a recording in the browser: draw a box, watch the tracker follow it, go to any frame, correct the box, export the result
    ///
    /// Only this machine can open the page (127.0.0.1, with a random token in the address). Any frame of a long video can be reached at
    /// once. host-sim serves the page until you end it (Ctrl-C).
    #[command(after_help = "Examples:
  host-sim view clip.mp4
  host-sim view day1.mp4 day2.mp4 day3.mp4
  host-sim view sequences/car --no-open")]
    View(view::View),
    /// Print the target's box in every frame
    #[command(after_help = "Examples:
  host-sim track clip.mp4 --init 142,125,90,39 --method robust -o boxes.mp4
  host-sim track sequences/car --frames 20..80 --resize 1/2 --format csv --out boxes.csv
  host-sim track day1.mp4 day2.mp4 day3.mp4 -o mice.csv
  host-sim track rtsp://camera.local/stream --init 280,200,80,80 -o boxes.csv
  ffmpeg -v error -f v4l2 -i /dev/video0 -pix_fmt gray -f yuv4mpegpipe -strict -1 - | host-sim track - --init 280,200,80,80")]
    Track(track::Track),
    /// Compare smr-core with the float reference, score by score
    #[command(after_help = "Examples:
  host-sim check
  host-sim check sequences/car --config camera")]
    Check(check::Check),
    /// Measure trackers against ground truth
    #[command(after_help = "Examples:
  host-sim eval sequences --method paper,robust
  host-sim eval sequences --fault all --config camera")]
    Eval(eval::Eval),
    /// Write a recording as files that other programs read and firmware replays
    ///
    /// If OUT ends in .y4m, .raw, .gray, .bin, .y8 or .h, it is one file with the frames alone. Otherwise it is a folder, with the frames
    /// and the boxes: init.txt and gt.txt as in TLD, or the files of a toolkit (--format vot, otb, got10k).
    #[command(after_help = "Examples:
  host-sim convert clip.mp4 --frames 1..60 --resize 160x120 -o clip.h
  host-sim convert synthetic --format vot -o workspace/sequences/synthetic
  host-sim convert sequences/car --format pgm -o frames")]
    Convert(convert::Convert),
    /// Show a recording: one HTML page with frames, plots and differences, or the paper's figures
    #[command(after_help = "Examples:
  host-sim report sequences/car --out report.html
  host-sim report sequences/car --figures figures --frame 180 --hidden 45..60")]
    Report(report::Report),
    /// Run a flight record of firmware again, and print the first answer that differs
    ///
    /// If a record was cut off, for example because the power failed, host-sim replays it up to the last complete entry and says so. If the
    /// record has no answer to its last update, host-sim prints the replayed one. Firmware that restarts appends to the record: each start
    /// is a flight of its own. Damage in the middle is an error; the entries before it are replayed. A record must fit in memory, and must
    /// begin within the first 64 MiB of its file.
    #[command(after_help = "Examples:
  host-sim replay flight.smr
  smr-qemu record.elf | host-sim replay -

Exit codes: 0 all answers are the recorded ones, 1 one differs, 2 the record cannot be read.")]
    Replay(replay::Replay),
}

const FIRST_PAGE: &str = "smr-demo.html";

pub fn run() -> ExitCode {
    let mut arguments: Vec<_> = std::env::args_os().collect();
    let is_first = arguments.len() <= 1;
    if is_first {
        arguments = ["host-sim", "report", street::NAME, "--out", FIRST_PAGE].map(OsString::from).to_vec();
    } else if is_recording(&arguments) {
        arguments.insert(1, "view".into());
    }
    obey(arguments, |line: HostSim| {
        let outcome = line.run()?;
        if is_first {
            say(say_what_to_type)?;
        }
        Ok(outcome)
    })
}

fn say_what_to_type(out: &mut Vec<u8>) -> io::Result<()> {
    // Path by which the program was started (such as target/release/host-sim with `cargo run`), so that users can copy
    // the examples.
    let program = std::env::args().next().unwrap_or_else(|| "host-sim".to_owned());
    writeln!(
        out,
        "The trackers were locked on a car of the built-in recording `{}`: it passes behind a tree, turns, and meets\n\
         another like it. Open {FIRST_PAGE} in a browser to see which of them follows it.\n\n\
         Your own video, in the browser or with an initial box (left, top, width, height):\n  \
         {program} view video.mp4    # drag a box, and it is followed\n  \
         {program} track video.mp4 --init 150,100,40,48 --video boxes.mp4\n  \
         {program} report video.mp4 --init 150,100,40,48 --out report.html\n\n\
         All commands: {program} --help",
        street::NAME,
    )
}

/// True if the arguments have a recording but no command; then the command is `view`.
fn is_recording(arguments: &[OsString]) -> bool {
    let first = &arguments[1];
    let all = HostSim::command();
    let is_command = |word: &OsString| word == "help" || all.find_subcommand(word).is_some();
    let is_recording = |word: &OsString| {
        Path::new(word).exists() || is_live(Path::new(word)) || BUILT_IN.iter().any(|name| word == name)
    };
    let begins = first.as_encoded_bytes().starts_with(b"--") && !arguments[1..].iter().any(is_command);
    let is_view = first == "-" || if begins { arguments[2..].iter().any(is_recording) } else { is_recording(first) };
    is_view && !is_command(first)
}

impl HostSim {
    fn run(self) -> Result<Outcome> {
        match self.command {
            Command::View(view) => view.run(),
            Command::Track(track) => track.run(),
            Command::Check(check) => check.run(),
            Command::Eval(eval) => eval.run(),
            Command::Convert(convert) => convert.run(),
            Command::Report(report) => report.run(),
            Command::Replay(replay) => replay.run(),
        }
    }
}

/// Returns a parser of whole numbers in `range`; a number must also fit `T`.
pub fn whole<T: FromStr>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number: &u64| range.contains(number));
        let number = number.and_then(|number| number.to_string().parse().ok());
        number.ok_or_else(|| match (range.start(), range.end()) {
            (first, &u64::MAX) => anyhow!("expected a whole number, {first} or more"),
            (first, last) => anyhow!("expected a whole number from {first} to {last}"),
        })
    }
}

fn from<T: FromStr>(first: u64) -> impl Fn(&str) -> Result<T> + Clone {
    whole(first..=u64::MAX)
}

pub fn tell<T: Serialize>(
    json: bool,
    result: &T,
    words: impl FnOnce(&T, &mut Vec<u8>) -> io::Result<()>,
) -> Result<()> {
    let json = json.then(|| serde_json::to_string_pretty(result)).transpose()?;
    say(|out| match json {
        Some(json) => writeln!(out, "{json}"),
        None => words(result, out),
    })
}

/// Prints to standard output. A closed pipe (`| head`) is no error, because the exit code still tells the result.
pub fn say(report: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Result<()> {
    match print(report) {
        Err(error) if !is_closed_pipe(&error) => Err(error),
        _ => Ok(()),
    }
}

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))
}
