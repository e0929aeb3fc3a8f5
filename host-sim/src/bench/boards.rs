//! Instructions of an update on the emulated boards: the firmware in QEMU, smr with its window of +-16, on the recordings' own
//! boxes.

use crate::emulator::Recording;
use crate::emulator::firmware;
use crate::emulator::protocol::TooBig;
use crate::emulator::qemu::{Qemu, Setup};
use crate::evaluate::{CoreKind, Origin};
use crate::output::Exchange;
use crate::sequence::Sequence;
use crate::spread::Spread;
use anyhow::Result;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// A board.
pub struct Board {
    setup: Setup,
    method: CoreKind,
    elf: PathBuf,
    counts: Vec<u64>,
    figures: Figures,
}

/// What was measured on a board.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    #[serde(flatten)]
    pub origin: Origin,
    pub machine: &'static str,
    /// Instructions of each update, over all frames of all recordings.
    pub instructions: Spread<u64>,
    pub recordings: Vec<Measured>,
    /// Recordings that the firmware has no room for, and why.
    pub skipped: Vec<String>,
    /// Recordings that it did not answer as the host does.
    pub differences: Vec<String>,
}

/// One recording on a board.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    pub sequence: String,
    /// Width and height of the box.
    pub target: [u16; 2],
    pub frames: u32,
    pub instructions: Spread<u64>,
}

impl Board {
    /// Builds the firmware.
    ///
    /// # Errors
    /// It does not build.
    pub fn new(setup: Setup, method: CoreKind) -> Result<Self> {
        let elf = firmware::build("replay", setup.machine)?;
        let figures = Figures {
            origin: Origin::new(method.into(), serde_json::Map::new()),
            machine: setup.machine.name(),
            instructions: Spread::default(),
            recordings: vec![],
            skipped: vec![],
            differences: vec![],
        };
        Ok(Self { setup, method, elf, counts: vec![], figures })
    }

    /// Runs it on a recording, in whole.
    ///
    /// # Errors
    /// QEMU fails, or the recording cannot be read. A box that is too big for the firmware is not an error: it is noted.
    pub fn add(&mut self, sequence: Sequence) -> Result<()> {
        let target = sequence.start()?;
        let folder = Exchange::create()?;
        let Sequence { name, frames, .. } = sequence;
        let recording = Recording::write(&name, (self.method, 0), frames, target, folder.path())?;
        let report = match self.run(&recording, folder.path()) {
            Err(error) if error.is::<TooBig>() => {
                self.figures.skipped.push(format!("{name}: {error}"));
                return Ok(());
            }
            report => report?,
        };
        if let Some(difference) = &report.difference {
            self.figures.differences.push(format!("{name}, frame {}: {}", difference.frame, difference.what));
        }
        self.counts.extend(&report.counts);
        self.figures.recordings.push(Measured {
            sequence: name,
            target: [target.width, target.height],
            frames: report.frames,
            instructions: report.instructions,
        });
        Ok(())
    }

    fn run(&self, recording: &Recording, folder: &Path) -> Result<crate::emulator::Report> {
        let mut qemu = Qemu::start(&self.setup, &self.elf, folder, Stdio::null())?;
        recording.compare(&mut qemu, folder)
    }

    /// What was measured so far.
    #[must_use]
    pub fn figures(&self) -> Figures {
        Figures { instructions: Spread::of(&self.counts), ..self.figures.clone() }
    }
}
