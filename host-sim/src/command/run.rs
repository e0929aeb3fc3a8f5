//! `host-sim run`: any firmware in QEMU, its log decoded; what `cargo run` of an example does.

use super::qemu_options::QemuOptions;
use super::{Outcome, estimates, tell};
use crate::emulator::qemu::Qemu;
use crate::emulator::{cycles, firmware};
use anyhow::{Context, Result, anyhow, bail};
use defmt_decoder::{DecodeError, Table};
use smr_recordings::input;
use std::io::{self, ErrorKind, StdoutLock, Write};
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

#[derive(Debug, clap::Args)]
pub struct Run {
    /// The firmware
    #[arg(value_name = "ELF")]
    elf: PathBuf,
    /// Estimate cycles instead of printing the log: of a lock, then of updates, each between two calls of `smr_ticks`; needs LLVM (Debian: llvm-19)
    #[arg(long)]
    cycles: bool,
    /// Print the estimate as JSON
    #[arg(long, requires = "cycles")]
    json: bool,
    #[command(flatten)]
    qemu: QemuOptions,
}

impl Run {
    pub fn run(self) -> Result<Outcome> {
        let name = self.elf.display().to_string();
        let elf = input::bytes(&self.elf, &input::FIRMWARE);
        let elf = elf.with_context(|| format!("cannot open the firmware {name}"))?;
        // An estimate says first which machines have one.
        firmware::check(&name, &elf, Some(self.qemu.machine).filter(|_| !self.cycles))?;
        if self.cycles {
            return self.estimate();
        }
        let table = Table::parse(&elf)
            .map_err(|_| anyhow!("{name}: what describes its log is damaged: expected firmware as it was linked"))?;
        // Firmware may write files where it runs: here.
        let mut qemu = Qemu::start(&self.qemu.setup(), &self.elf, ".".as_ref(), Stdio::piped())?;
        let log = qemu.log().context("QEMU's standard output is piped")?;
        print(&mut qemu, &input::chunks(|| Ok(log)), table.as_ref())?;
        Ok(if qemu.verdict()? { Outcome::Holds } else { Outcome::CheckFailed })
    }

    fn estimate(&self) -> Result<Outcome> {
        let machine = self.qemu.machine;
        let program = cycles::program(machine, &self.elf)?;
        let mut qemu = Qemu::start(&self.qemu.setup().tracing(true), &self.elf, ".".as_ref(), Stdio::piped())?;
        let reader = cycles::reader(&mut qemu, &program)?;
        let holds = qemu.verdict()?;
        let estimates = cycles::estimates(machine, &program, &reader.spans()?)?;
        tell(self.json, &estimates, |estimates, out| estimates::describe(estimates, out))?;
        Ok(if holds { Outcome::Holds } else { Outcome::CheckFailed })
    }
}

/// Where the log goes. That nobody reads it any more (`| head`) does not end the firmware: its verdict is still wanted.
struct Log {
    out: StdoutLock<'static>,
    is_read: bool,
}

impl Log {
    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        if !self.is_read {
            return Ok(());
        }
        match self.out.write_all(bytes).and_then(|()| self.out.flush()) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => self.is_read = false,
            written => written.context("cannot write to standard output")?,
        }
        Ok(())
    }
}

fn print(qemu: &mut Qemu, log: &Receiver<io::Result<Vec<u8>>>, table: Option<&Table>) -> Result<()> {
    let mut decoder = table.map(Table::new_stream_decoder);
    let mut out = Log { out: io::stdout().lock(), is_read: true };
    let mut last = Instant::now();
    loop {
        let bytes = match log.recv_timeout(Duration::from_millis(50)) {
            Ok(Ok(bytes)) => bytes,
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {
                qemu.check_patience(last, "a word of the firmware")?;
                continue;
            }
        };
        last = Instant::now();
        let Some(decoder) = &mut decoder else {
            out.write(&bytes)?;
            continue;
        };
        decoder.received(&bytes);
        loop {
            match decoder.decode() {
                Ok(frame) => {
                    let level = frame.level().map_or("", |level| level.as_str());
                    out.write(format!("{level:5} {}\n", frame.display_message()).as_bytes())?;
                }
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => bail!("the firmware's log is not defmt's"),
            }
        }
    }
}
