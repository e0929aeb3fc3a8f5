//! The instructions of a program, as `llvm-objdump` writes them.

use super::trace::{Block, MARK};
use anyhow::{Context, Result, bail, ensure};
use smr_recordings::cleanup::Process;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The ends of the names of LLVM's programs: Debian's have the version.
const VERSIONS: [&str; 5] = ["-19", "-20", "-21", "-18", ""];

/// Functions and instructions by address.
pub struct Program {
    functions: BTreeMap<u32, String>,
    instructions: BTreeMap<u32, String>,
}

impl Program {
    /// Reads the firmware; `processor` is what LLVM calls the one that it is for.
    /// Errors: there is no `llvm-objdump`, or it refuses.
    pub fn of(elf: &Path, processor: &str) -> Result<Self> {
        let mut arguments = ["-d", "--demangle", "--no-show-raw-insn"].map(str::to_owned).to_vec();
        arguments.extend([format!("--mcpu={processor}"), elf.display().to_string()]);
        let output = llvm("llvm-objdump", &arguments)?;
        Ok(Self::read(&String::from_utf8_lossy(&output.stdout)))
    }

    fn read(listing: &str) -> Self {
        let mut program = Self { functions: BTreeMap::new(), instructions: BTreeMap::new() };
        for line in listing.lines() {
            let number = |text: &str| u32::from_str_radix(text.trim(), 16).ok();
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|line| line.split_once(" <")) {
                program.functions.extend(number(address).map(|address| (address, name.to_owned())));
            } else if let Some((address, text)) = line.split_once(':') {
                let text = text.split('@').next().unwrap_or_default().split('<').next().unwrap_or_default();
                let text = text.trim().replace('\t', " ");
                program.instructions.extend(number(address).map(|address| (address, text)));
            }
        }
        program
    }

    /// The address of the function that begins and ends each measurement.
    pub fn mark(&self) -> Result<u32> {
        let found = self.functions.iter().find(|(_, name)| *name == MARK);
        Ok(*found.with_context(|| format!("the firmware has no function {MARK}: is it core/examples/replay?"))?.0)
    }

    /// The instructions of a block, in order.
    pub fn code(&self, block: Block) -> Vec<&str> {
        self.instructions.range(block.start..block.start + block.size).map(|(_, text)| text.as_str()).collect()
    }

    /// The name of the function around this address.
    pub fn function(&self, address: u32) -> &str {
        self.functions.range(..=address).next_back().map_or("", |(_, name)| name)
    }
}

/// Runs a program of LLVM to its end.
/// Errors: there is none, or it fails.
pub fn llvm(name: &str, arguments: &[String]) -> Result<Output> {
    for version in VERSIONS {
        let mut command = Command::new(format!("{name}{version}"));
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let output = match Process::start(&mut command).and_then(Process::finish) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            output => output.with_context(|| format!("cannot run {name}{version}"))?,
        };
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "{name}{version} fails: {}", said.lines().next().unwrap_or_default());
        return Ok(output);
    }
    bail!("there is no {name}: --cycles needs LLVM 18 or later (Debian: llvm-19)")
}
