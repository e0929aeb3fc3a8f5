//! `host-sim vectors`: the conformance vectors, made anew from the reference.

use super::Outcome;
use super::tracker_options::PaperOnly;
use crate::vectors;
use anyhow::{Context, Result};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct Vectors {
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    tracker: PaperOnly,
}

impl Vectors {
    pub fn run(self) -> Result<Outcome> {
        self.tracker.check("vectors")?;
        let text = vectors::text();
        match &self.out {
            Some(path) => std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?,
            None => std::io::stdout().lock().write_all(text.as_bytes())?,
        }
        Ok(Outcome::Holds)
    }
}
