//! The firmware as a file: how it is built, and what it takes of a chip.

use super::qemu::Machine;
use anyhow::{Context, Result, anyhow, bail, ensure};
use object::elf::{EM_ARM, EM_RISCV, SHF_ALLOC, SHF_WRITE, SHT_NOBITS};
use object::read::elf::{ElfFile32, SectionHeader};
use serde::Serialize;
use smr_recordings::cleanup::Process;
use smr_recordings::input;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What the linker has placed, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// Statics. The stack comes to it.
    pub static_ram: u32,
    /// Code, constants, the vector table, and what statics start with.
    pub flash: u32,
}

impl Sizes {
    pub fn of(elf: &Path) -> Result<Self> {
        let name = || elf.display().to_string();
        let data = input::bytes(elf, &input::FIRMWARE);
        let data = data.with_context(|| format!("cannot open the firmware {}", name()))?;
        let file = ElfFile32::<object::Endianness>::parse(data.as_slice());
        let file = file.map_err(|_| anyhow!("{} is not firmware: expected an ELF file of 32 bits", name()))?;
        let endian = file.endian();
        let mut sizes = Self::default();
        let sections = file.elf_section_table();
        for section in sections.iter() {
            // riscv-rt makes a section of the memory that is left.
            if sections.section_name(endian, section).is_ok_and(|name| name == b".stack") {
                continue;
            }
            let (flags, size) = (section.sh_flags(endian), section.sh_size(endian));
            let placed = flags & SHF_ALLOC != 0;
            if placed && flags & SHF_WRITE != 0 {
                sizes.static_ram = sizes.static_ram.saturating_add(size);
            }
            if placed && section.sh_type(endian) != SHT_NOBITS {
                sizes.flash = sizes.flash.saturating_add(size);
            }
        }
        ensure!(sizes.flash > 0, "{} holds no code for flash", name());
        Ok(sizes)
    }
}

/// Errors: The file called `name` is no firmware, or not for the processor of `machine`. QEMU would end without a word.
pub fn check(name: &str, elf: &[u8], machine: Option<Machine>) -> Result<()> {
    let file = ElfFile32::<object::Endianness>::parse(elf);
    let file = file.map_err(|_| anyhow!("{name} is not firmware: expected an ELF file of 32 bits"))?;
    let Some(machine) = machine else { return Ok(()) };
    let (processor, called) = if machine == Machine::Virt { (EM_RISCV, "RISC-V") } else { (EM_ARM, "Arm") };
    let is_for = file.elf_header().e_machine.get(file.endian()) == processor;
    ensure!(is_for, "{name} is for another processor than {called}, which --machine {} has", machine.name());
    Ok(())
}

/// What `cargo` for microcontrollers is in smr's sources.
const CARGO: &str = ".ci/target-cargo";

/// Builds the firmware `example` for `machine` with `features`; the working folder lies in smr's sources.
pub fn build(example: &str, machine: Machine, features: &str) -> Result<PathBuf> {
    let sources = sources()?;
    let (target, processor) = machine.target();
    let mut cargo = Command::new(sources.join(CARGO));
    cargo.args([target, "build", "--package", "smr-examples", "--profile", "firmware", "--bin", example]);
    cargo.args(["--features", features, "--quiet", "--message-format", "json-render-diagnostics"]);
    if let Some(processor) = processor {
        let variable = target.replace(['-', '.'], "_").to_uppercase();
        cargo.env(format!("CARGO_TARGET_{variable}_RUSTFLAGS"), format!("-Ctarget-cpu={processor}"));
    }
    cargo.current_dir(&sources).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit());
    let output = Process::start(&mut cargo)
        .and_then(Process::finish)
        .with_context(|| format!("cannot start {CARGO}, which builds the firmware: give --elf"))?;
    let elf = executable(&String::from_utf8_lossy(&output.stdout));
    match elf {
        Some(elf) if output.status.success() => Ok(elf),
        _ => bail!("the firmware {example} does not build for {target}: see above, or give --elf"),
    }
}

fn sources() -> Result<PathBuf> {
    let here = std::env::current_dir().context("cannot find out the working folder")?;
    let found = here.ancestors().find(|folder| folder.join("memory.x").is_file() && folder.join(CARGO).is_file());
    found.map(Path::to_owned).context("the firmware is built from smr's sources: run this there, or give --elf")
}

/// The file in cargo's messages, one JSON object a line.
fn executable(messages: &str) -> Option<PathBuf> {
    let of_message = |line: &str| {
        let message = serde_json::from_str::<serde_json::Value>(line).ok()?;
        message.get("executable")?.as_str().map(PathBuf::from)
    };
    messages.lines().rev().find_map(of_message)
}
