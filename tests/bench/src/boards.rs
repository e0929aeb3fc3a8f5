//! Instructions of an update on the emulated boards: the firmware in QEMU, smr with its window of +-16, on the recordings' own
//! boxes. Where the fastest backend is that of words of four pixels, the plain loops are measured beside it.

use anyhow::Result;
use host_sim::emulator::firmware;
use host_sim::emulator::protocol::TooBig;
use host_sim::emulator::qemu::{Qemu, Setup};
use host_sim::emulator::{Follow, Recording};
use host_sim::percentiles::Spread;
use serde::{Serialize, Serializer};
use smr_core::similarity::Backend;
use smr_evaluation::{CoreKind, Origin};
use smr_recordings::Sequence;
use smr_recordings::output::Exchange;
use std::process::Stdio;

/// What was measured on a board.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    #[serde(flatten)]
    pub origin: Origin,
    pub machine: &'static str,
    #[serde(serialize_with = "by_name")]
    pub backend: Backend,
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

/// Builds the firmware, and runs it on recordings, in whole.
/// Errors: it does not build, QEMU fails, or a recording cannot be read. A box that is too big for the firmware is not an error: it is noted.
pub fn measure(
    setup: &Setup,
    (method, backend): (CoreKind, Backend),
    sequences: impl Iterator<Item = Result<Sequence>>,
) -> Result<Figures> {
    let elf = firmware::build("replay", setup.machine, if backend == Backend::Scalar { "plain" } else { "" })?;
    let (mut counts, mut recordings) = (Vec::new(), Vec::new());
    let (mut skipped, mut differences) = (Vec::new(), Vec::new());
    for sequence in sequences {
        let sequence = sequence?;
        let target = sequence.start()?;
        let folder = Exchange::create()?;
        let Sequence { name, frames, .. } = sequence;
        let recording =
            Recording::write(&name, Follow { method, refiner: false, step: 0 }, frames, target, folder.path())?;
        let mut qemu = Qemu::start(setup, &elf, folder.path(), Stdio::null())?;
        let report = match recording.compare(&mut qemu, folder.path()) {
            Err(error) if error.is::<TooBig>() => {
                skipped.push(format!("{name}: {error}"));
                continue;
            }
            report => report?,
        };
        if let Some(difference) = &report.difference {
            differences.push(format!("{name}, frame {}: {}", difference.frame, difference.what));
        }
        counts.extend(&report.counts);
        let target = [target.width, target.height];
        let (frames, instructions) = (report.frames, report.instructions);
        recordings.push(Measured { sequence: name, target, frames, instructions });
    }
    let (origin, machine) = (Origin::new(method.into(), serde_json::Map::new()), setup.machine.name());
    Ok(Figures { origin, machine, backend, instructions: Spread::of(&counts), recordings, skipped, differences })
}

fn by_name<S: Serializer>(backend: &Backend, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(&format_args!("{backend:?}"))
}
