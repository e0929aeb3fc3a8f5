//! Several recordings in one call: one table of all boxes, or a file for each recording. The recordings are followed in
//! parallel, each on one thread. One that fails does not keep the results of the others.

use super::follow::{self, Outputs};
use super::lines::Lines;
use super::opened::Opened;
use super::plan::{Plan, Planned};
use super::{Track, check_names};
use crate::command::HostSim;
use crate::command::exit_code::{Outcome, told};
use crate::command::progress::{self, Bar, Expected};
use anyhow::{Error, Result, anyhow, bail};
use clap::CommandFactory;
use rayon::prelude::*;
use smr_files::messages;
use smr_files::output::{Output, complain};
use smr_files::signals;
use smr_pages::export::boxes::Format;
use std::collections::BTreeMap;
use std::fs;
use std::io::{IsTerminal, stdout};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;

/// Follows the targets of all recordings.
pub fn follow(track: &Track, found: &[PathBuf]) -> Result<Outcome> {
    let plan = Plan::of(track, found)?;
    let mut table = plan.table()?;
    let is_shown = plan.has_events || track.out.is_some() || !stdout().is_terminal();
    let name = format!("{} recordings", found.len());
    let bar = if is_shown { progress::bar(&name, Some(0)) } else { Bar::hidden() };
    let run =
        Run { plan: &plan, expected: Expected::of(&bar, found.len()), bar: &bar, is_over: AtomicBool::new(false) };
    // The results of the recordings that are done are not lost if the user stops.
    signals::stop_first();
    let (sender, results) = mpsc::channel();
    let (mut failures, done) = thread::scope(|scope| {
        let (run, all) = (&run, found.len());
        scope.spawn(move || {
            let one = |sender: &mut mpsc::Sender<_>, at| {
                if !run.is_over() {
                    // Nobody listens any more if the table cannot be written.
                    let _ = sender.send((at, run.one(at)));
                }
            };
            (0..all).par_bridge().for_each_with(sender, one);
        });
        let collected = run.collect(results, &mut table);
        run.is_over.store(true, Ordering::Relaxed);
        collected
    })?;
    bar.clear();
    for folder in &plan.made {
        // A folder with a file stays.
        let _ = fs::remove_dir(folder);
    }
    let is_stopped = signals::stopped_by();
    if is_stopped.is_some() {
        complain("stopped: the results are those of the recordings that were done");
    }
    // Without any result, the former file stays.
    if done > 0 {
        table.finish()?;
    }
    match (is_stopped, failures.len(), found.len()) {
        (Some(signal), ..) => Ok(Outcome::Stopped(signal)),
        (None, 0, _) => Ok(Outcome::Holds),
        (None, _, 1) => Err(failures.remove(0)),
        (None, failed, all) => bail!("{failed} of {all} recordings failed: see the errors above"),
    }
}

struct Run<'a> {
    plan: &'a Plan<'a>,
    expected: Expected<'a>,
    bar: &'a Bar,
    /// True if no more results can be written.
    is_over: AtomicBool,
}

/// The part of the table that a recording makes.
struct Part {
    head: String,
    lines: String,
}

impl Run<'_> {
    fn is_over(&self) -> bool {
        signals::is_stopped() || self.is_over.load(Ordering::Relaxed)
    }

    fn one(&self, at: usize) -> Result<Part> {
        let one = &self.plan.recordings[at];
        let path = one.path.display().to_string();
        let has_path = |error: &Error| messages::of(error).contains(&path);
        let named = |error| if one.is_namesake && !has_path(&error) { error.context(path.clone()) } else { error };
        self.followed(one).map_err(named)
    }

    fn followed(&self, Planned { path, name, kept, boxes, film, .. }: &Planned<'_>) -> Result<Part> {
        let &Plan { track, format, has_events, .. } = self.plan;
        let kept = kept.as_ref().map_err(|error| anyhow!("{}", messages::of(error)))?;
        let mut opened = Opened::of(track, path, kept.as_ref())?;
        opened.sequence.name.clone_from(name);
        check_names(format, opened.targets.len())?;
        self.expected.add(track.length(&opened.sequence).unwrap_or(0) as u64, 1);
        let lines = match boxes {
            Some(file) => Lines::File(Output::create(file)?),
            None if has_events => Lines::Unread,
            None => Lines::Kept(String::new()),
        };
        let has_metres = opened.pixels_per_metre.is_some() || (boxes.is_none() && self.plan.has_metres());
        let is_table = format == Format::Csv && matches!(lines, Lines::Kept(_));
        if is_table && has_metres && opened.pixels_per_metre.is_none() {
            let note = format!("note: {name}: no length in the picture: its columns in metres are empty");
            self.bar.suspend(|| complain(&note));
        }
        let printer = opened.printer(format, boxes.is_none(), has_metres);
        let head = printer.head();
        let (film, bar) = (film.clone(), self.bar);
        let outputs = Outputs { printer, lines, film, has_events, bar, is_one_of_several: true };
        let lines = follow::follow(track, opened, outputs, &|| self.is_over())?;
        Ok(Part { head, lines })
    }

    /// Writes the results into the table in the order of the recordings, each as soon as those before it are there.
    /// Returns the errors, which are reported at once if there are several recordings, and the number of results.
    fn collect(
        &self,
        results: mpsc::Receiver<(usize, Result<Part>)>,
        table: &mut Lines,
    ) -> Result<(Vec<Error>, usize)> {
        let (mut waiting, mut next, mut failures, mut done) = (BTreeMap::new(), 0, Vec::new(), 0);
        let mut take = |result: Result<Part>| match result {
            Ok(Part { head, lines }) => {
                let head = if done == 0 { head } else { String::new() };
                done += 1;
                self.bar.suspend(|| table.write(&(head + &lines)))
            }
            // A recording that was stopped is no failure.
            Err(_) if self.is_over() => Ok(()),
            Err(error) => {
                if self.plan.recordings.len() > 1 {
                    let command = HostSim::command().find_subcommand("track").cloned().unwrap_or_default();
                    self.bar.suspend(|| complain(&format!("error: {}", told(&error, &command))));
                }
                failures.push(error);
                Ok(())
            }
        };
        for (at, result) in results {
            waiting.insert(at, result);
            while let Some(result) = waiting.remove(&next) {
                take(result)?;
                next += 1;
            }
        }
        // After a stop, the results of some recordings are missing.
        waiting.into_values().try_for_each(take)?;
        Ok((failures, done))
    }
}
