//! Compares every answer of as many frames as there is time for: `cargo run --release -p smr-tests --bin soak -- --method robust`.

mod sessions;
mod video;

use anyhow::{Result, ensure};
use host_sim::command::number::from;
use host_sim::command::{Outcome, program, progress, say, tell};
use serde::Serialize;
use serde_json::Map;
use sessions::{Report, Settings, peak_memory};
use smr_evaluation::{CoreKind, Origin};
use smr_pages::export::{Format, Writer};
use std::io::{self, Write};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use video::Video;

/// Run a tracker over a long generated video in two different ways, and compare every answer
///
/// The generated video has motion, jumps of the light, things in front of the target, faults of the camera, turns of the camera, and targets that
/// are saved and restored. One tracker has the fastest backend and whole frames. The other has the plain loops, sees only the parts of a frame that
/// it asks for, and updates in steps of any size.
#[derive(Debug, clap::Parser)]
#[command(name = "soak", version, max_term_width = 120)]
struct Soak {
    /// Which tracker
    #[arg(long, value_enum, default_value = "smr")]
    method: CoreKind,
    /// How many frames; each session of 500 has a scene and a lock of its own
    #[arg(long, value_name = "N", default_value = "100000", value_parser = from::<NonZeroU64>(1))]
    frames: NonZeroU64,
    /// Compare 50 frames of every N-th session with the float reference, too; 0 compares none
    #[arg(long, value_name = "N", default_value = "20", value_parser = from::<u64>(0))]
    reference_every: u64,
    /// The seed of the first scene; each further scene adds one
    #[arg(long, default_value = "0", value_parser = from::<u64>(0))]
    seed: u64,
    /// Compare nothing; write a scene of this many frames as a recording into this new folder, to feed to firmware
    #[arg(long, value_name = "DIR", conflicts_with_all = ["method", "reference_every", "json"])]
    write: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// All that is printed.
#[derive(Serialize)]
struct Soaked<'a> {
    #[serde(flatten)]
    origin: Origin,
    seed: u64,
    #[serde(flatten)]
    report: &'a Report,
    /// The most memory that this process has taken, in KiB; null where the system does not tell.
    peak_kib: Option<u64>,
}

fn main() -> ExitCode {
    program(Soak::run)
}

impl Soak {
    fn run(self) -> Result<Outcome> {
        let frames = self.frames.get();
        if let Some(folder) = &self.write {
            return write(folder, frames, self.seed);
        }
        let Self { method, reference_every, seed, .. } = self;
        let bar = progress::bar("soak", usize::try_from(frames).ok());
        let report = sessions::soak(Settings { method, frames, reference_every, seed }, |done| bar.inc(done))?;
        bar.finish_and_clear();
        let origin = Origin::new(method.into(), Map::new());
        let soaked = Soaked { origin, seed, report: &report, peak_kib: peak_memory() };
        tell(self.json, &soaked, |soaked, out| describe(soaked, out))?;
        Ok(if report.difference.is_none() { Outcome::Holds } else { Outcome::CheckFailed })
    }
}

fn describe(soaked: &Soaked<'_>, out: &mut impl Write) -> io::Result<()> {
    let Report { frames, sessions, reference_frames, states, found_again, faults, turns, restored, seconds, .. } =
        soaked.report;
    let method = soaked.origin.method;
    let equal = if soaked.report.difference.is_none() { "every answer the same" } else { "FAILED" };
    writeln!(out, "{method}: {frames} frames in {sessions} sessions, {seconds:.0} s: {equal}")?;
    writeln!(out, "  fastest backend, whole frames, at once; plain loops, parts, steps, restored {restored} times")?;
    writeln!(out, "  {reference_frames} of the frames against the float reference, too")?;
    let [tracking, leaving, uncertain, lost] = states;
    writeln!(
        out,
        "  {tracking} tracking, {leaving} leaving, {uncertain} uncertain, {lost} lost; found again {found_again} times"
    )?;
    writeln!(out, "  {faults} faults of the camera, {turns} turns of it")?;
    if let Some(kib) = soaked.peak_kib {
        writeln!(out, "  at most {} MiB of memory", kib.div_ceil(1024))?;
    }
    let Some(difference) = &soaked.report.difference else { return Ok(()) };
    writeln!(out, "  session {}, frame {}: {}", difference.session, difference.frame, difference.what)?;
    writeln!(out, "    fast:  {}", difference.fast)?;
    writeln!(out, "    plain: {}", difference.plain)
}

fn write(folder: &Path, frames: u64, seed: u64) -> Result<Outcome> {
    ensure!(frames > 1, "--frames {frames}: a recording to follow a target in has at least 2");
    let mut video = Video::new(seed);
    let (first, target) = video.first();
    let mut writer = Writer::in_folder(folder, Format::Y4m, "soak", Some(target.into()))?;
    writer.frame(first)?;
    for _ in 1..frames {
        writer.frame(&video.frame())?;
    }
    writer.finish(None)?;
    say(|out| writeln!(out, "{}: {frames} frames; init.txt", folder.display()))?;
    Ok(Outcome::Holds)
}
