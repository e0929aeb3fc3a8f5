//! Firmware in QEMU. `smr-qemu ELF` prints the firmware's log. `smr-qemu ELF SEQ` gives the firmware
//! `tests/chip/replay` a recording and compares every answer with the host's. QEMU runs one instruction in each
//! emulated nanosecond, so the firmware's timer counts instructions.

mod replay;

use anyhow::{Context, Result, anyhow, bail, ensure};
use defmt_decoder::{DecodeError, Table};
use host_sim::command::recording_options::RecordingOptions;
use host_sim::command::{Outcome, program, say, whole};
use object::elf::{SHF_ALLOC, SHF_WRITE};
use object::{File, Object, ObjectSection, SectionFlags, SectionKind};
use replay::ReplayedRecord;
use smr_evaluation::CoreKind;
use smr_files::input;
use smr_files::process::Process;
use std::io::{ErrorKind, Read, Write};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, ExitCode, Stdio};
use std::time::Duration;

const FIRMWARE: input::Kind = input::Kind { expected: "firmware, an ELF file of 32 bits", most: 256 };

/// QEMU options for a trace: each block of code when it is translated, and its address each time it runs.
const TRACE: [&str; 4] = ["-d", "exec,nochain,in_asm", "-D", "/dev/stdout"];

/// Resolution of the firmware's timer in instructions.
const A_TICK: u64 = 100;

/// Run firmware in QEMU and print its log, or compare its answers on recordings with the host's
#[derive(Debug, clap::Parser)]
#[command(version, max_term_width = 120)]
struct Qemu {
    /// The QEMU machine; the possible values have, in order, a Cortex-M3 (for Cortex-M0+ firmware), M4, M7, M55 and RV32IMAC
    #[arg(long, default_value = "mps2-an386", overrides_with = "machine")]
    #[arg(value_parser = ["mps2-an385", "mps2-an386", "mps2-an500", "mps3-an547", "virt"])]
    machine: String,
    /// The firmware's ELF file
    #[arg(value_name = "ELF")]
    elf: PathBuf,
    /// Recordings for the firmware tests/chip/replay, folders of recordings, or flight records (.smr)
    #[arg(value_name = "SEQ")]
    paths: Vec<PathBuf>,
    /// The tracker; paper has the preset camera and a search radius of 16
    #[arg(long, value_enum, default_value = "paper")]
    method: CoreKind,
    /// Use the robust tracker's refiner
    #[arg(long)]
    refiner: bool,
    /// Also update in steps of WORK units, as firmware with a deadline does
    #[arg(long, value_name = "WORK", value_parser = whole::<NonZeroU32>(1..=u32::MAX.into()))]
    step: Option<NonZeroU32>,
    /// Estimate the cycles of the lock and of each update from a trace; needs LLVM (Debian: llvm-19)
    #[arg(long, conflicts_with = "step")]
    cycles: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

fn main() -> ExitCode {
    program(Qemu::run)
}

impl Qemu {
    fn run(self) -> Result<Outcome> {
        ensure!(!self.refiner || self.method == CoreKind::Robust, "--refiner: expected --method robust");
        let name = self.elf.display();
        let elf = input::bytes(&self.elf, &FIRMWARE);
        let elf = elf.with_context(|| format!("cannot open the firmware {name}"))?;
        let parsed = File::parse(elf.as_slice()).ok().filter(|file| matches!(file, File::Elf32(_)));
        let parsed = parsed.with_context(|| format!("{name} is not firmware: expected an ELF file of 32 bits"))?;
        // Uses the working folder, because firmware may write files there.
        let here = Path::new(".");
        let holds = if !self.paths.is_empty() {
            self.replay(sizes(&parsed))?
        } else if self.cycles {
            let (holds, (_, estimates)) = self.traced(here, 0)?;
            say(|out| out.write_all(estimates.as_bytes()))?;
            holds
        } else {
            let table = Table::parse(&elf).map_err(|_| anyhow!("{name}: what describes its log is damaged"))?;
            self.start(here, &[], |log| print(log, table.as_ref()))?.0
        };
        Ok(if holds { Outcome::Holds } else { Outcome::CheckFailed })
    }

    /// Runs the firmware on each recording and prints its cost. Returns true if all answers equal the host's.
    fn replay(&self, (flash, statics): (u64, u64)) -> Result<bool> {
        let (mut holds, mut all) = (true, Vec::new());
        let is_record = |path: &PathBuf| path.extension().is_some_and(|end| end == "smr");
        let (mut paths, others): (Vec<_>, Vec<_>) = self.paths.iter().cloned().partition(is_record);
        if !others.is_empty() {
            paths.extend(self.recording.find(&others)?);
        }
        for path in &paths {
            let (name, record) = if is_record(path) {
                let name = path.display().to_string();
                let record = std::fs::read(path).with_context(|| format!("cannot open the record {name}"))?;
                (name, record)
            } else {
                let sequence = self.recording.open(path)?;
                (sequence.name.clone(), replay::record(sequence, self.method, self.refiner)?)
            };
            let folder = smr_files::output::Exchange::create()?;
            replay::write(&record, self.step, folder.path())?;
            // The firmware's first measurement calibrates its timer; `traced` skips this measurement.
            let (_, estimated) = match self.cycles {
                true => self.traced(folder.path(), 1).map(|(holds, estimated)| (holds, Some(estimated)))?,
                false => self.start(folder.path(), &[], drained)?,
            };
            let report = ReplayedRecord::of(folder.path(), &record).with_context(|| name.clone())?;
            let (median, stack) = (report.updates[0], report.stack);
            let method = if is_record(path) { "as recorded".to_owned() } else { self.method_name() };
            let mut text = format!("{name} on {}, {method}: {report}", self.machine);
            text += &format!(
                "  RAM {} bytes: statics {statics}, stack {stack}; flash {flash}\n",
                statics + u64::from(stack)
            );
            if let Some((traced, estimates)) = estimated {
                let is_whole = traced.abs_diff(median) <= median / 1000 + A_TICK;
                ensure!(is_whole, "QEMU counts {median} instructions of an update, its trace has {traced}");
                text += &estimates;
            }
            say(|out| out.write_all(text.as_bytes()))?;
            holds &= report.difference.is_none();
            all.extend(report.counts);
        }
        let [median, p95, max] = spread(&all);
        if paths.len() > 1 {
            say(|out| writeln!(out, "all: {} updates: median {median}, 95 % below {p95}, at most {max}", all.len()))?;
        }
        Ok(holds)
    }

    fn method_name(&self) -> String {
        let refined = if self.refiner { " with refiner" } else { "" };
        format!("{}{refined}", smr_evaluation::MethodKind::from(self.method).name())
    }

    /// Runs the firmware with a trace. Returns: true if the exit code is 0; the median instructions of an update; the
    /// text of the estimated cycles. Skips the first `calibrations` measurements, which are not of the tracker.
    fn traced(&self, folder: &Path, calibrations: u32) -> Result<(bool, (u64, String))> {
        self.start(folder, &TRACE, |trace| {
            let mut python = Command::new("python3");
            python.args(["-c", include_str!("../cycles.py")]).arg(self.elf.canonicalize()?).arg(&self.machine);
            // `cycles.py` reads the trace from stdin until QEMU ends.
            let output =
                python.arg(calibrations.to_string()).stdin(trace).output().context("--cycles: cannot run python3")?;
            let [said, complaint] =
                [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
            ensure!(output.status.success(), "{}", last_line(&complaint));
            let traced = said.lines().next().and_then(|line| line.rsplit(' ').next()).context("no estimate")?;
            Ok((traced.parse()?, said))
        })
    }

    /// Runs the firmware with `folder` for its files, and passes QEMU's output to `read`. Returns true if the exit code
    /// is 0. Fails if QEMU itself does.
    fn start<T>(&self, folder: &Path, more: &[&str], read: impl FnOnce(ChildStdout) -> Result<T>) -> Result<(bool, T)> {
        let (program, package, bios) = match self.machine.as_str() {
            // No BIOS: QEMU would run its own before the firmware.
            "virt" => ("qemu-system-riscv32", "qemu-system-misc", &["-bios", "none"][..]),
            _ => ("qemu-system-arm", "qemu-system-arm", &[][..]),
        };
        let mut command = Command::new(program);
        command.args(["-machine", &self.machine, "-icount", "shift=0"]).args(bios).args(more);
        command.args(["-display", "none", "-monitor", "none", "-serial", "null", "-chardev", "stdio,id=log"]);
        command.args(["-semihosting-config", "enable=on,target=native,chardev=log", "-kernel"]);
        command.arg(self.elf.canonicalize()?).current_dir(folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let process = match Process::start(&mut command) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                bail!("there is no {program}: install QEMU (Debian: {package})")
            }
            other => other.with_context(|| format!("cannot start {program}"))?,
        };
        let said = process.said();
        let read = read(process.output().context("QEMU's standard output is piped")?)?;
        let status = process.wait_while(|_| true)?.context("QEMU has no end")?;
        let said = said.recv_timeout(Duration::from_secs(1)).unwrap_or_default();
        let words = last_line(&said);
        let is_firmware = status.success() || words.is_empty() && status.code().is_some();
        ensure!(is_firmware, "{program} with {} ended ({status}): {words}", self.machine);
        Ok((status.success(), read))
    }
}

fn last_line(text: &str) -> &str {
    text.trim_end().lines().next_back().unwrap_or_default()
}

fn drained<T>(mut log: impl Read) -> Result<Option<T>> {
    std::io::copy(&mut log, &mut std::io::sink())?;
    Ok(None)
}

/// Returns the bytes of flash and of statics. The stack is not part of the statics.
fn sizes(file: &File<'_>) -> (u64, u64) {
    let (mut flash, mut statics) = (0, 0);
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        // Skips the section `.stack` of riscv-rt, which covers all free memory.
        if sh_flags & u64::from(SHF_ALLOC) == 0 || section.name() == Ok(".stack") {
            continue;
        }
        statics += if sh_flags & u64::from(SHF_WRITE) != 0 { section.size() } else { 0 };
        flash += if section.kind() == SectionKind::UninitializedData { 0 } else { section.size() };
    }
    (flash, statics)
}

/// Prints the firmware's log line by line. If stdout is closed, reads on, because the exit code is still needed.
fn print(mut log: impl Read, table: Option<&Table>) -> Result<()> {
    let mut decoder = table.map(Table::new_stream_decoder);
    let mut bytes = [0; 4096];
    loop {
        let length = log.read(&mut bytes)?;
        let Some(decoder) = &mut decoder else {
            say(|out| out.write_all(&bytes[..length]))?;
            if length == 0 { return Ok(()) } else { continue }
        };
        decoder.received(&bytes[..length]);
        loop {
            match decoder.decode() {
                Ok(frame) => {
                    let level = frame.level().map_or("", |level| level.as_str());
                    say(|out| writeln!(out, "{level:5} {}", frame.display_message()))?;
                }
                Err(DecodeError::UnexpectedEof) if length == 0 => return Ok(()),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => bail!("the firmware's log is not defmt's"),
            }
        }
    }
}

/// Returns the median, the 95th percentile and the largest of `measurements`; zeros if there are none.
fn spread(measurements: &[u64]) -> [u64; 3] {
    let mut sorted = measurements.to_vec();
    sorted.sort_unstable();
    let last = sorted.len().saturating_sub(1);
    [sorted.len() / 2, (sorted.len() * 95).div_ceil(100).saturating_sub(1), last]
        .map(|index| sorted.get(index).copied().unwrap_or(0))
}
