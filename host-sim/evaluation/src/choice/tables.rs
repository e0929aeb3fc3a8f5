//! The tables of a choice, and the sentence with its reason.

use super::candidate::Tracker;
use super::chip::Wanted;
use super::decision::{Decision, Fit, Mean, Row, choose};
use crate::table::{Head, Table, TableName, Tables};
use serde_json::Value;
use smr_recordings::fault::Fault;
use std::fmt::Write;

/// Recordings below which the text says how little they are.
const FEW: usize = 5;

/// Makes the tables. After a stop there is no choice, because not all was measured.
pub(super) fn of(rows: &[Row<'_>], wanted: &Wanted, faults: &[Fault], is_stopped: bool) -> Tables {
    let decision = choose(rows, wanted).filter(|_| !is_stopped);
    let mut candidates = Table::new(TableName::Candidates, 1, heads(wanted, faults));
    for at in 0..rows.len() {
        candidates.row(cells(rows, at, decision, wanted));
    }
    let sentence = if is_stopped {
        "none, because the measurement was stopped.".to_owned()
    } else {
        sentence(rows, decision, wanted)
    };
    let remarks = remarks(rows, decision, wanted, &sentence);
    Tables { tables: vec![candidates, choice(rows, decision, wanted, sentence)], remarks }
}

fn heads(wanted: &Wanted, faults: &[Fault]) -> Vec<Head> {
    let accuracy = [
        ("tracker", "tracker"),
        ("recordings", ""),
        ("right", "right"),
        ("right_standard_error", "+-"),
        ("clean", "clean"),
    ];
    let cost = [
        ("difference", ""),
        ("difference_standard_error", ""),
        ("", "to the best"),
        ("cycles", ""),
        ("most_cycles", ""),
        ("", "Mcycles; most"),
        ("frames_per_second", "frames/s"),
        ("ram", ""),
        ("", "KB"),
        ("fit", ""),
        ("", wanted.chip.name),
        ("rust", ""),
        ("c", ""),
        ("python", ""),
        ("options", ""),
    ];
    let head = |&(key, title): &(&str, &str)| Head::new(key, title, 3);
    let under = faults.iter().map(|fault| Head::new(&fault.to_string(), &fault.to_string(), 3));
    accuracy.iter().map(head).chain(under).chain(cost.iter().map(head)).collect()
}

fn cells(rows: &[Row<'_>], at: usize, decision: Option<Decision>, wanted: &Wanted) -> Vec<Value> {
    let row = &rows[at];
    let Mean { value, error } = row.right();
    let accuracy = [
        row.candidate.variant.name.as_str().into(),
        row.own.len().into(),
        value.into(),
        error.into(),
        mean(row.own.iter().map(|one| one.clean)).into(),
    ];
    let faults = row.own.first().map_or(0, |one| one.faults.len());
    let under = (0..faults).map(|fault| mean(row.own.iter().filter_map(|one| one.faults[fault])).into());
    let difference = decision.map(|Decision { best, .. }| row.minus(&rows[best]));
    let is_best = decision.is_some_and(|Decision { best, .. }| best == at);
    let is_chosen = decision.is_some_and(|Decision { chosen, .. }| chosen == at);
    let fit = match row.fit(wanted) {
        Fit::Fits => "fits",
        Fit::TooSlow => "too slow",
        Fit::TooLarge => "too large",
    };
    let cost = [
        difference.map(|mean| mean.value).into(),
        difference.and_then(|mean| mean.error).into(),
        difference.filter(|_| !is_best).map(shown).into(),
        whole(row.cycles).into(),
        whole(row.most_cycles).into(),
        format!("{:.2}; {:.2}", row.cycles / 1e6, row.most_cycles / 1e6).into(),
        whole(row.fps(wanted)).into(),
        row.ram.into(),
        kb(row.ram).into(),
        fit.into(),
        if is_chosen { "CHOSEN" } else { fit }.into(),
        row.candidate.rust(row.area).into(),
        row.candidate.c(row.area).into(),
        row.candidate.python.into(),
        row.candidate.options.into(),
    ];
    accuracy.into_iter().chain(under).chain(cost).collect()
}

/// The table of one row that only programs read: the text has its words below the candidates.
fn choice(rows: &[Row<'_>], decision: Option<Decision>, wanted: &Wanted, sentence: String) -> Table {
    let keys = ["chip", "processor", "clock_mhz", "chip_ram", "wanted_frames_per_second", "tracker", "sentence"];
    let mut table = Table::new(TableName::Choice, 0, Head::list(&keys.map(|key| (key, ""))));
    let chip = wanted.chip;
    table.row(vec![
        chip.name.into(),
        chip.processor.name().into(),
        chip.clock_mhz.into(),
        chip.ram().into(),
        wanted.fps.into(),
        decision.map(|decision| rows[decision.chosen].candidate.variant.name.as_str()).into(),
        sentence.into(),
    ]);
    table
}

fn sentence(rows: &[Row<'_>], decision: Option<Decision>, wanted: &Wanted) -> String {
    let (chip, fps) = (wanted.chip.name, wanted.fps);
    let name = |row: &Row<'_>| row.candidate.variant.name.clone();
    let Some(Decision { chosen, best }) = decision else {
        let fastest = rows.iter().max_by(|a, b| a.fps(wanted).total_cmp(&b.fps(wanted)));
        let smallest = rows.iter().min_by_key(|row| row.ram);
        let facts = fastest.zip(smallest).map(|(fastest, smallest)| {
            let rate = whole(fastest.fps(wanted));
            format!(
                ": the fastest, {}, reaches {rate}, and the smallest, {}, needs {} KB",
                name(fastest),
                name(smallest),
                kb(smallest.ram)
            )
        });
        let facts = facts.unwrap_or_default();
        return format!(
            "No tracker reaches {fps} frames a second within the {} KB of {chip}{facts}.",
            wanted.chip.ram_kb
        );
    };
    let is_best = chosen == best;
    let (chosen, best) = (&rows[chosen], &rows[best]);
    let right = plain(chosen.right());
    let mut text = if is_best {
        format!("{}, the most accurate tracker that fits: right in {right} of the frames, with", name(chosen))
    } else {
        let less = plain(best.minus(chosen));
        format!(
            "{}, right in {right} of the frames. The most accurate tracker that fits, {}, is better by {less}, within one \
             standard error, so the cheaper one wins:",
            name(chosen),
            name(best)
        )
    };
    let (rate, ram, most) = (whole(chosen.fps(wanted)), kb(chosen.ram), wanted.chip.ram_kb);
    let _ = write!(text, " {rate} frames a second ({fps} wanted) and {ram} of {most} KB on {chip}.");
    let first = rows.iter().max_by(|a, b| a.right().value.total_cmp(&b.right().value));
    if let Some(first) = first.filter(|first| first.right().value > best.right().value) {
        let (rate, ram) = (whole(first.fps(wanted)), kb(first.ram));
        let _ = write!(text, " The most accurate of all, {} ({}),", name(first), plain(first.right()));
        let _ = match first.fit(wanted) {
            Fit::TooLarge => write!(text, " needs {ram} KB."),
            Fit::TooSlow | Fit::Fits => write!(text, " reaches only {rate} frames a second."),
        };
    }
    text
}

fn remarks(rows: &[Row<'_>], decision: Option<Decision>, wanted: &Wanted, sentence: &str) -> String {
    let mut text = format!("Choice: {sentence}\n");
    if let Some(row) = decision.map(|decision| &rows[decision.chosen]) {
        let candidate = row.candidate;
        let _ = write!(
            text,
            "\n  Rust:     {}\n  C:        {}\n  Python:   tracker = {}\n  host-sim: {}\n",
            candidate.rust(row.area),
            candidate.c(row.area),
            candidate.python,
            candidate.options
        );
        if candidate.tracker == Tracker::Refined {
            text += "  In Rust and C this needs the feature `refiner`.\n";
        }
    }
    text += &format!("\n{}\n", little(rows.first().map_or(0, |row| row.own.len())));
    let processor = wanted.chip.processor;
    let by = if processor.is_compared() { ", and by the ratio of instructions to the Cortex-M4's" } else { "" };
    let _ = write!(
        text,
        "right: mean of clean runs (5 starts) and of the faults. Mcycles: of 19 of 20 updates, and the most; work of these runs\n\
         times the estimated cycles of a unit of work on a {}{by}.\n\
         KB: target, workspace and the most pixels that an update read; not the stack (2 KB), a whole frame or the camera's buffers.\n",
        processor.name()
    );
    text
}

/// Says how much the number of recordings tells.
fn little(recordings: usize) -> String {
    let end = "The choice holds for recordings like these: measure at least five of yours.";
    match recordings {
        0 | 1 => format!("One recording has no standard error, so any difference decides. {end}"),
        2..FEW => {
            let uncertain = 100.0 / (2.0 * (recordings as f64 - 1.0)).sqrt();
            format!(
                "{recordings} recordings are few: their standard errors are themselves uncertain by {uncertain:.0} %. {end}"
            )
        }
        _ => format!(
            "{recordings} recordings; +- is the standard error of the mean over them. It is too small if some are parts of one clip."
        ),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn shown(Mean { value, error }: Mean) -> String {
    error.map_or_else(|| format!("{value:+.3}"), |error| format!("{value:+.3} +- {error:.3}"))
}

fn plain(mean: Mean) -> String {
    shown(mean).trim_start_matches('+').to_owned()
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // cycles and rates are not negative
const fn whole(value: f64) -> u64 {
    value as u64
}

const fn kb(bytes: usize) -> usize {
    bytes.div_ceil(1024)
}
