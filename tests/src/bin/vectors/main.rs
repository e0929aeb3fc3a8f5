//! Makes the conformance vectors anew: `cargo run --release -p smr-tests --bin vectors -- --out tests/vectors/conformance.txt`.

mod paper;
mod robust;

use anyhow::{Result, bail};
use host_sim::command::{Outcome, program};
use smr_evaluation::CoreKind;
use smr_recordings::output;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Print the conformance vectors, made from the float reference
#[derive(Debug, clap::Parser)]
#[command(name = "vectors", version)]
struct Vectors {
    /// Which tracker's
    #[arg(long, value_enum, default_value = "smr")]
    method: CoreKind,
    /// Those with the refiner
    #[arg(long)]
    refiner: bool,
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn main() -> ExitCode {
    program(Vectors::run)
}

impl Vectors {
    fn run(self) -> Result<Outcome> {
        let text = match self.method {
            CoreKind::Smr if self.refiner => bail!("--refiner is an option of robust, not of smr"),
            CoreKind::Smr => paper::text(),
            CoreKind::Robust if self.refiner => robust::refined_text(),
            CoreKind::Robust => robust::text(),
        };
        match &self.out {
            Some(file) => output::write(file, text.as_bytes())?,
            None => output::print(|out| out.write_all(text.as_bytes()))?,
        }
        Ok(Outcome::Holds)
    }
}
