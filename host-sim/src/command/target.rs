//! `host-sim target`: the real firmware in QEMU on a recording, every answer compared with the host's.

use super::number::whole;
use super::qemu_options::QemuOptions;
use super::recording_options::RecordingOptions;
use super::{Outcome, estimates, tell};
use crate::emulator::cycles::{self, Estimate, program::Program, trace};
use crate::emulator::firmware::{self, Sizes};
use crate::emulator::qemu::Qemu;
use crate::emulator::{Follow, Recording, Report};
use anyhow::{Result, ensure};
use serde::Serialize;
use smr_evaluation::CoreKind;
use smr_recordings::output::Exchange;
use std::io::{self, Write};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::process::Stdio;

#[derive(Debug, clap::Args)]
pub struct Target {
    /// The recording
    #[arg(value_name = "SEQ")]
    sequence: PathBuf,
    /// Which tracker; smr is that of --config camera, with a window of +-16
    #[arg(long, value_enum, default_value = "smr")]
    method: CoreKind,
    /// Update in steps of so much work, as firmware with a deadline does [default: all at once]
    #[arg(long, value_name = "WORK", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    step: Option<NonZeroU32>,
    /// The robust tracker with its refiner
    #[arg(long)]
    refiner: bool,
    /// Estimate cycles, updates a second on some chips, and where the cycles go; needs LLVM (Debian: llvm-19)
    #[arg(long, conflicts_with = "step")]
    cycles: bool,
    /// The firmware, built from core/examples/replay [default: built now, with .ci/target-cargo]
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    qemu: QemuOptions,
    #[command(flatten)]
    recording: RecordingOptions,
}

/// The instructions that the firmware's timer may miss.
const A_TICK: u64 = 100;

#[derive(Serialize)]
struct Measured<'a> {
    machine: &'static str,
    #[serde(flatten)]
    report: &'a Report,
    #[serde(flatten)]
    sizes: Sizes,
    /// Statics and stack.
    ram: Option<u32>,
    /// On each processor that this firmware is for.
    #[serde(skip_serializing_if = "Option::is_none")]
    cycles: Option<Vec<Estimate>>,
}

impl Target {
    pub fn run(self) -> Result<Outcome> {
        let Self { method, refiner, .. } = self;
        let follow = Follow { method, refiner, step: self.step.map_or(0, NonZeroU32::get) };
        follow.check()?;
        let sequence = self.recording.open(&self.sequence)?;
        let target = sequence.start()?;
        let elf = match &self.elf {
            Some(elf) => elf.clone(),
            None => firmware::build("replay", self.qemu.machine, if refiner { "refiner" } else { "" })?,
        };
        let sizes = Sizes::of(&elf)?;
        let program = self.cycles.then(|| cycles::program(self.qemu.machine, &elf)).transpose()?;
        let folder = Exchange::create()?;
        let recording = Recording::write(&sequence.name, follow, sequence.frames, target, folder.path())?;
        let (report, spans) = self.compare(&recording, &elf, program.as_ref(), folder.path())?;
        // The first measurement is the calibration. After a difference the firmware was ended.
        let spans = spans.get(1..).filter(|_| report.difference.is_none());
        let cycles = program.zip(spans).map(|(program, spans)| cycles::estimates(self.qemu.machine, &program, spans));
        let cycles = cycles.transpose()?;
        let (counted, traced) = (report.instructions.median, cycles.iter().flatten().map(|of| of.traced.median).next());
        let is_whole = traced.is_none_or(|traced| traced.abs_diff(counted) <= counted / 1000 + A_TICK);
        ensure!(is_whole, "QEMU counts {counted} instructions of an update, its trace has {}", traced.unwrap_or(0));
        let ram = report.stack.map(|stack| sizes.static_ram.saturating_add(stack.used));
        let measured = Measured { machine: self.qemu.machine.name(), report: &report, sizes, ram, cycles };
        tell(self.json, &measured, |measured, out| describe(measured, out))?;
        Ok(if report.difference.is_none() { Outcome::Holds } else { Outcome::CheckFailed })
    }

    /// Runs the firmware; with `traced`, its program, it also tells what ran in each measurement.
    fn compare(
        &self,
        recording: &Recording,
        elf: &Path,
        traced: Option<&Program>,
        folder: &Path,
    ) -> Result<(Report, Vec<trace::Span>)> {
        let setup = self.qemu.setup().tracing(traced.is_some());
        let output = if traced.is_some() { Stdio::piped() } else { Stdio::null() };
        let mut qemu = Qemu::start(&setup, elf, folder, output)?;
        let reader = traced.map(|program| cycles::reader(&mut qemu, program)).transpose()?;
        let report = recording.compare(&mut qemu, folder)?;
        // Ends the trace, too.
        drop(qemu);
        let spans = reader.map_or(Ok(Vec::new()), cycles::Reader::spans)?;
        Ok((report, spans))
    }
}

fn describe(measured: &Measured<'_>, out: &mut impl Write) -> io::Result<()> {
    let Measured { machine, report, sizes, ram, cycles } = measured;
    let Report { origin, sequence, frames, instructions, longest_step, work, .. } = report;
    let Report { target_bytes, workspace_bytes, buffer_bytes, .. } = report;
    writeln!(out, "{sequence} on {machine}, {}: {frames} frames answered as on the host, bit for bit", origin.method)?;
    if let Some(difference) = &report.difference {
        writeln!(out, "  FAILED in frame {}: {}", difference.frame, difference.what)?;
        writeln!(out, "    target: {}", difference.target)?;
        writeln!(out, "    host:   {}", difference.host)?;
    }
    if let (Some(ram), Some(stack)) = (ram, report.stack) {
        writeln!(
            out,
            "  RAM:   {ram} bytes: {} of statics, {} of stack (there are {}); in it a target of {target_bytes}, a workspace of \
             {workspace_bytes}, {buffer_bytes} for pixels",
            sizes.static_ram, stack.used, stack.room
        )?;
    }
    writeln!(out, "  flash: {} bytes, with both trackers", sizes.flash)?;
    let [median, p95, max] = [instructions.median, instructions.p95, instructions.max];
    if let Some(lock) = report.lock_instructions {
        writeln!(out, "  instructions of the lock: {lock}")?;
    }
    writeln!(out, "  instructions of an update: median {median}, 95 % below {p95}, at most {max}")?;
    if longest_step != instructions {
        writeln!(
            out,
            "  instructions of its longest step: median {}, at most {}",
            longest_step.median, longest_step.max
        )?;
    }
    writeln!(out, "  work of an update: median {}, at most {}", work.median, work.max)?;
    let Some(estimates) = cycles else { return Ok(()) };
    estimates::describe(estimates, out)?;
    writeln!(
        out,
        "  for this, memory without waits must hold: target {target_bytes} bytes, workspace {workspace_bytes}, pixels of the \
         window up to {buffer_bytes}, stack {}, code and constants up to {}",
        // The firmware has all three on its stack.
        report.stack.map_or(0, |stack| stack.used.saturating_sub(target_bytes + workspace_bytes + buffer_bytes)),
        sizes.flash
    )
}
