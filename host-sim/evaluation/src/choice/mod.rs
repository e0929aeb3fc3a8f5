//! Choice of a tracker for a chip: accuracy on recordings, clean and under faults of the camera, beside the memory and
//! the time that each tracker takes there.

mod candidate;
mod chip;
mod decision;
mod measurement;
mod tables;

pub use candidate::Tracker;
pub use chip::{CHIPS, CYCLES, Chip, Processor, Wanted};

use crate::matrix::{self, Measured, Progress};
use crate::{Tables, Variant};
use anyhow::Result;
use candidate::Candidate;
use decision::Row;
use measurement::{Choice, Measurement};
use smr_files::signals;
use smr_recordings::Sequence;
use smr_recordings::fault::Fault;
use std::path::{Path, PathBuf};

/// Faults that are inserted if none are given: those that every camera has.
pub const FAULTS: &str = "dropped:5,black:3,gain:150,noise:20";

/// Frames a second, if none are given.
pub const FPS: u16 = 30;

/// Runs the candidates over the recordings, and chooses one of them for the chip.
pub fn measure(
    paths: &[PathBuf],
    open: impl Fn(&Path) -> Result<Sequence> + Sync,
    wanted: &Wanted,
    faults: &[Fault],
    progress: &(dyn Fn(Progress) + Sync),
) -> Measured {
    let candidates = Candidate::all();
    let variants: Vec<Variant> = candidates.iter().map(|candidate| candidate.variant.clone()).collect();
    let open = |place: usize| open(&paths[place]);
    let (records, failures) = matrix::measure(&Choice { faults }, paths.len(), open, &variants, progress);
    let is_empty = records.is_empty();
    let mut measured: Vec<Vec<Measurement>> = candidates.iter().map(|_| Vec::new()).collect();
    for record in records {
        let at = variants.iter().position(|variant| variant.name == record.variant.name);
        if let Some(own) = at.and_then(|at| measured.get_mut(at)) {
            own.push(Measurement::of(record, faults));
        }
    }
    let most = measured.iter().map(Vec::len).max().unwrap_or(0);
    let whole = measured.iter().find(|own| own.len() == most).map_or(&[][..], Vec::as_slice);
    // A candidate that failed on a recording is not compared with the others: its error says why.
    let names = |own: &[Measurement]| own.iter().map(|one| one.sequence.clone()).collect::<Vec<_>>();
    let is_complete = |own: &[Measurement]| !is_empty && names(own) == names(whole);
    let (complete, others): (Vec<_>, Vec<_>) = candidates.iter().zip(&measured).partition(|(_, own)| is_complete(own));
    let mut notes: Vec<String> = whole.iter().filter_map(|one| one.without(faults)).collect();
    if !others.is_empty() && !is_empty {
        let others: Vec<&str> = others.iter().map(|(candidate, _)| candidate.variant.name.as_str()).collect();
        notes.push(format!("not measured on every recording, and not in the table: {}", others.join("; ")));
    }
    let rows: Result<Vec<Row<'_>>> =
        complete.into_iter().map(|(candidate, own)| Row::of(candidate, own, wanted)).collect();
    let is_stopped = signals::is_stopped();
    Measured { tables: rows.map(|rows| tables(&rows, wanted, faults, is_stopped)), failures, notes, is_empty }
}

fn tables(rows: &[Row<'_>], wanted: &Wanted, faults: &[Fault], is_stopped: bool) -> Tables {
    if rows.is_empty() { Tables::default() } else { tables::of(rows, wanted, faults, is_stopped) }
}
