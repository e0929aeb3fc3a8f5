//! `host-sim replay`: replays a flight record of firmware through smr-core and prints the first difference.

use super::{Outcome, progress, tell};
use crate::replay::{self, Flight, ReplayedRecord};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use std::fs::File;
use std::io::{self, Read, Write, stdin};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub struct Replay {
    /// The record that firmware wrote with `smr_core::record`: bytes, or a text log with them; `-` is standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Replayed<'a> {
    version: &'static str,
    file: String,
    #[serde(flatten)]
    report: &'a ReplayedRecord,
}

impl Replay {
    pub fn run(self) -> Result<Outcome> {
        let name = self.file.display().to_string();
        let source: Box<dyn Read> = if self.file == Path::new("-") {
            Box::new(stdin())
        } else {
            Box::new(
                File::open(&self.file)
                    .with_context(|| format!("cannot open the record {name}: expected what firmware wrote"))?,
            )
        };
        let bar = progress::of(&name, None, "entries");
        let report = replay::replay(source, self.json, || bar.inc()).with_context(|| name.clone())?;
        bar.clear();
        let replayed = Replayed { version: env!("CARGO_PKG_VERSION"), file: name.clone(), report: &report };
        tell(self.json, &replayed, |replayed, out| describe(replayed, out))?;
        if let Some(damage) = &report.damage {
            bail!("{name}: {damage}; the entries before it were replayed");
        }
        Ok(if report.difference.is_none() { Outcome::Holds } else { Outcome::CheckFailed })
    }
}

fn describe(Replayed { file, report, .. }: &Replayed<'_>, out: &mut impl Write) -> io::Result<()> {
    let all = report.flights.len();
    for (number, flight) in (1..).zip(&report.flights) {
        let which = if all > 1 { format!(", flight {number} of {all}") } else { String::new() };
        let Flight { method, answers, locks, bytes, pixels, .. } = flight;
        let locked = if *locks == 1 { "1 lock".to_owned() } else { format!("{locks} locks") };
        writeln!(out, "{file}{which}, {method}: {locked}, {answers} answers as recorded, bit for bit")?;
        let [tracking, leaving, uncertain, lost] = flight.states;
        writeln!(out, "  {tracking} frames tracking, {leaving} leaving, {uncertain} uncertain, {lost} lost")?;
        writeln!(out, "  {bytes} bytes, {pixels} of them pixels")?;
        for (count, what) in [
            (flight.moved, "turns of the camera"),
            (flight.restored, "saved targets restored"),
            (flight.given_up, "updates given up"),
        ] {
            if count > 0 {
                writeln!(out, "  {count} {what}")?;
            }
        }
        if flight.cut_off > 0 {
            writeln!(out, "  cut off: the last {} bytes are an incomplete entry", flight.cut_off)?;
        }
        if let Some(last) = &flight.unanswered {
            writeln!(
                out,
                "  the record ends before the answer to frame {}; replayed: {}, box in 1/256 pixel {}",
                last.frame, last.state, last.bbox
            )?;
        }
    }
    if report.cut_off > 0 {
        writeln!(out, "  cut off: the last {} bytes are an incomplete entry", report.cut_off)?;
    }
    if let Some(difference) = &report.difference {
        let which = if all > 1 { format!("flight {}, ", difference.flight) } else { String::new() };
        writeln!(out, "  DIFFERS in {which}frame {}: {}", difference.frame, difference.field)?;
        writeln!(out, "    recorded: {}", difference.recorded)?;
        writeln!(out, "    replayed: {}", difference.replayed)?;
    }
    Ok(())
}
