//! `host-sim vectors`: the conformance vectors, made anew.

use super::Outcome;
use super::places::Places;
use crate::vectors;
use anyhow::{Result, bail};
use smr_evaluation::CoreKind;
use smr_recordings::output;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Vectors {
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

impl Vectors {
    /// What is read and written.
    pub fn places(&self) -> Places<'_> {
        Places::default().writes("--out", self.out.as_ref())
    }

    pub fn run(self) -> Result<Outcome> {
        let text = match self.method {
            CoreKind::Smr if self.refiner => bail!("--refiner is an option of robust, not of smr"),
            CoreKind::Smr => vectors::text(),
            CoreKind::Robust if self.refiner => vectors::robust::refined_text(),
            CoreKind::Robust => vectors::robust::text(),
        };
        match &self.out {
            Some(file) => output::write(file, text.as_bytes())?,
            None => output::print(|out| out.write_all(text.as_bytes()))?,
        }
        Ok(Outcome::Holds)
    }
}
