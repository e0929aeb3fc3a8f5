//! QEMU as a process: started with firmware, watched, and ended whatever happens.

use super::cycles::trace;
use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::ValueEnum;
use smr_core::similarity::Backend;
use smr_recordings::cleanup::Process;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::{Duration, Instant};

/// The boards that firmware runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Machine {
    /// Cortex-M3, with firmware for Cortex-M0+
    #[value(name = "mps2-an385")]
    Mps2An385,
    /// Cortex-M4
    #[value(name = "mps2-an386")]
    Mps2An386,
    /// Cortex-M7
    #[value(name = "mps2-an500")]
    Mps2An500,
    /// Cortex-M55, with Helium
    #[value(name = "mps3-an547")]
    Mps3An547,
    /// RV32IMAC
    Virt,
}

impl Machine {
    /// As QEMU calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mps2An385 => "mps2-an385",
            Self::Mps2An386 => "mps2-an386",
            Self::Mps2An500 => "mps2-an500",
            Self::Mps3An547 => "mps3-an547",
            Self::Virt => "virt",
        }
    }

    /// The QEMU that has it, and Debian's package of that.
    pub const fn emulator(self) -> (&'static str, &'static str) {
        match self {
            Self::Mps2An385 | Self::Mps2An386 | Self::Mps2An500 | Self::Mps3An547 => {
                ("qemu-system-arm", "qemu-system-arm")
            }
            Self::Virt => ("qemu-system-riscv32", "qemu-system-misc"),
        }
    }

    /// The backends to measure on it: the fastest one, and beside words of four pixels the plain loops.
    pub const fn backends(self) -> &'static [Backend] {
        match self {
            Self::Mps2An385 | Self::Virt => &[Backend::Swar, Backend::Scalar],
            Self::Mps2An386 | Self::Mps2An500 => &[Backend::Dsp],
            Self::Mps3An547 => &[Backend::Helium],
        }
    }

    /// The compiler's target for it, and the processor where that is more than the target says.
    pub const fn target(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Mps2An385 => ("thumbv6m-none-eabi", None),
            Self::Mps2An386 | Self::Mps2An500 => ("thumbv7em-none-eabihf", None),
            Self::Mps3An547 => ("thumbv8m.main-none-eabihf", Some("cortex-m55")),
            Self::Virt => ("riscv32imac-unknown-none-elf", None),
        }
    }
}

/// How QEMU is to be run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The emulator's name or path.
    pub program: String,
    pub machine: Machine,
    /// How long nothing may happen.
    pub patience: Duration,
    /// Writes a trace of what runs to its standard output. It is then far slower.
    pub traces: bool,
}

impl Setup {
    /// With a trace, or without. A trace takes up to ten times as long.
    pub fn tracing(self, traces: bool) -> Self {
        let patience = if traces { 10 * self.patience } else { self.patience };
        Self { traces, patience, ..self }
    }
}

/// A running QEMU. Dropped, it is ended and reaped.
pub struct Qemu {
    process: Process,
    said: Receiver<String>,
    setup: Setup,
}

impl Qemu {
    /// Starts `elf` with `folder` as the place for the firmware's files; what it logs goes to `log`. An instruction is a
    /// nanosecond of the emulated time.
    pub fn start(setup: &Setup, elf: &Path, folder: &Path, log: Stdio) -> Result<Self> {
        let elf = elf.canonicalize().with_context(|| format!("cannot open the firmware {}", elf.display()))?;
        let program = &setup.program;
        let mut command = Command::new(program);
        command.args(["-machine", setup.machine.name(), "-icount", "shift=0"]);
        command.args(["-display", "none", "-monitor", "none", "-serial", "null", "-chardev", "stdio,id=log"]);
        if setup.machine == Machine::Virt {
            // Without firmware of its own before ours.
            command.args(["-bios", "none"]);
        }
        if setup.traces {
            command.args(trace::OPTIONS);
        }
        command.args(["-semihosting-config", "enable=on,target=native,chardev=log", "-kernel"]).arg(elf);
        command.current_dir(folder).stdin(Stdio::null()).stdout(log).stderr(Stdio::piped());
        let process = match Process::start(&mut command) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let package = setup.machine.emulator().1;
                bail!("there is no {program}: install QEMU (Debian: {package}), or name it with --qemu")
            }
            other => other.with_context(|| format!("cannot start {program}"))?,
        };
        let said = process.said();
        Ok(Self { process, said, setup: setup.clone() })
    }

    /// What the firmware logs, or the trace, if that was piped.
    pub fn log(&mut self) -> Option<ChildStdout> {
        self.process.output()
    }

    /// Asks `there` again and again until it says yes. `what` is what is waited for.
    /// Errors: QEMU has ended before, or it took longer than the setup's patience.
    pub fn wait_for(&mut self, what: &str, mut there: impl FnMut() -> Result<bool>) -> Result<()> {
        let start = Instant::now();
        loop {
            // First whether it has ended, then what it has left behind: nothing is missed in between.
            let ended = self.process.ended().context("cannot wait for QEMU")?;
            if there()? {
                return Ok(());
            }
            if let Some(status) = ended {
                return Err(self.ended(status)).with_context(|| format!("while waiting for {what}"));
            }
            self.check_patience(start, what)?;
            thread::sleep(Duration::from_millis(2));
        }
    }

    pub fn check_patience(&self, start: Instant, what: &str) -> Result<()> {
        ensure!(start.elapsed() <= self.setup.patience, self.hangs(what));
        Ok(())
    }

    fn hangs(&self, what: &str) -> String {
        let Setup { program, patience, .. } = &self.setup;
        format!("{program} hangs: {what} has not come within {} s (see --timeout)", patience.as_secs())
    }

    /// Waits for the end of firmware that has nothing more to say.
    pub fn finish(&mut self) -> Result<()> {
        let status = self.exit_status()?;
        if status.success() { Ok(()) } else { Err(self.ended(status)) }
    }

    /// The firmware's verdict: true if it ended with 0.
    /// Errors: It does not end, or it is QEMU itself that has failed.
    pub fn verdict(&mut self) -> Result<bool> {
        let status = self.exit_status()?;
        let words = self.last_words();
        ensure!(status.success() || words.is_empty() && status.code().is_some(), self.failed(status, &words));
        Ok(status.success())
    }

    fn exit_status(&mut self) -> Result<ExitStatus> {
        let ended = self.process.wait_while(|waited| waited <= self.setup.patience);
        ended.context("cannot wait for QEMU")?.with_context(|| self.hangs("the end of the firmware"))
    }

    fn ended(&self, status: ExitStatus) -> anyhow::Error {
        let words = self.last_words();
        anyhow!(self.failed(status, &words))
    }

    fn failed(&self, status: ExitStatus, words: &str) -> String {
        let reason = if words.is_empty() { String::new() } else { format!(": {words}") };
        format!("{} with {} ended ({status}){reason}", self.setup.program, self.setup.machine.name())
    }

    /// The last line of QEMU, which has ended, that is not blank.
    fn last_words(&self) -> String {
        let said = self.said.recv_timeout(Duration::from_secs(1)).unwrap_or_default();
        said.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default().to_owned()
    }
}
