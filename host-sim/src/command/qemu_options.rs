//! How QEMU is run, the same for every command that starts it.

use super::number::whole;
use crate::emulator::qemu::{Machine, Setup};
use clap::Args;
use std::num::NonZeroU16;
use std::time::Duration;

/// For commands that run firmware on one board.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "QEMU")]
pub struct QemuOptions {
    /// The board
    #[arg(long, value_enum, default_value = "mps2-an386")]
    pub machine: Machine,
    #[command(flatten)]
    emulator: EmulatorOptions,
}

/// The emulator, whatever board it is to be.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "QEMU")]
pub struct EmulatorOptions {
    /// End QEMU, as an error, if it prints nothing for this many seconds
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = whole::<NonZeroU16>(1..=65535))]
    timeout: NonZeroU16,
    /// The emulator [default: qemu-system-arm; for virt qemu-system-riscv32]
    #[arg(long, value_name = "PROGRAM")]
    qemu: Option<String>,
}

impl QemuOptions {
    pub fn setup(&self) -> Setup {
        self.emulator.setup(self.machine)
    }
}

impl EmulatorOptions {
    pub fn setup(&self, machine: Machine) -> Setup {
        let patience = Duration::from_secs(self.timeout.get().into());
        let program = self.qemu.clone().unwrap_or_else(|| machine.emulator().0.to_owned());
        Setup { program, machine, patience, traces: false }
    }
}
