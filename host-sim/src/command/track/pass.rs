//! A run through a recording: follows all targets, and writes each frame's answers to the outputs.

use super::lines::Lines;
use crate::command::events::Events;
use crate::command::progress::Bar;
use crate::command::video::{AnswersVideo, Shown};
use anyhow::{Context, Result, bail};
use smr_core::Quality;
use smr_evaluation::Follower;
use smr_files::output::{complain, print};
use smr_pages::export::boxes::{Answer, Printer};
use smr_pages::viewer::Target as Drawn;
use smr_recordings::{Arrivals, Frame};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// Warning about a target that is too similar to its surroundings.
const POOR: &str = "can hardly be told from what lies beside it: expected a box with more texture";

/// State of a run through a recording: all targets, and the outputs.
pub struct Pass<'a> {
    pub name: String,
    /// The option or the file that gave the boxes.
    pub boxes_of: String,
    /// True if lines about events begin with the name of the recording.
    pub is_one_of_several: bool,
    pub targets: Vec<Follower>,
    /// Each target as the user drew it, if it is of a session; `scale` is the size of the frames, relative to those there.
    pub drawn: Vec<Option<Drawn>>,
    pub scale: (f64, f64),
    pub printer: Printer,
    pub lines: Lines,
    pub events: Option<Events>,
    pub film: Option<(AnswersVideo, PathBuf)>,
    /// Progress of all recordings.
    pub bar: &'a Bar,
    pub live: Option<Arc<Arrivals>>,
    pub drops: bool,
    pub last: usize,
    /// Number of frames that are followed.
    pub done: usize,
}

impl Pass<'_> {
    pub fn frame(&mut self, frame: Frame) -> Result<()> {
        let (number, time, gray) = (frame.number, frame.seconds, &frame.gray);
        if self.live.as_ref().is_some_and(|live| live.dropped() > 0) && !self.drops {
            self.drops = true;
            self.warn("frames are dropped: they come faster than the target is followed (--resize 1/2 helps)");
        }
        let (mut shown, mut poor, mut happened) = (Vec::new(), Vec::new(), Vec::new());
        for (at, target) in self.targets.iter_mut().enumerate() {
            let is_due = target.next_start().is_some_and(|start| start <= number);
            let report = target.step(number, gray).with_context(|| self.name.clone())?;
            let said = |report| self.drawn[at].as_ref().map_or(report, |drawn| drawn.said(number, report, self.scale));
            let report = report.map(said);
            let locks = is_due && report.is_some();
            let quality = target.quality().filter(|_| locks);
            if quality.is_some_and(Quality::is_poor) {
                poor.push(target.name.as_deref());
            }
            let name = target.name.as_deref();
            let size = (gray.width, gray.height);
            let answer = Answer { target: at, frame: number, time, size, report: report.as_ref(), quality };
            self.lines.write(&self.printer.line(&answer)?)?;
            let told = self.events.as_mut().zip(report.as_ref());
            if let Some(event) = told.and_then(|(events, report)| events.of(at, locks, number, time, report.state)) {
                happened.push((name.map(str::to_owned), event));
            }
            shown.push(Shown { name, report });
        }
        self.film.as_mut().map_or(Ok(()), |(film, _)| film.frame(frame, &shown))?;
        let warning = warning(&poor);
        for (name, event) in happened {
            self.bar.suspend(|| print(|out| writeln!(out, "{}{event}", self.heading(name.as_deref()))))?;
        }
        if let Some(warning) = warning {
            self.warn(&warning);
        }
        self.bar.inc();
        (self.last, self.done) = (number, self.done + 1);
        Ok(())
    }

    pub fn warn(&self, what: &str) {
        self.bar.suspend(|| complain(&format!("warning: {}: {what}", self.name)));
    }

    /// Returns the beginning of a line about a target: the recording, if there are several, and the target's name.
    fn heading(&self, target: Option<&str>) -> String {
        let recording = self.is_one_of_several.then_some(&*self.name);
        recording.into_iter().chain(target).map(|name| format!("{name}: ")).collect()
    }

    fn say_end(&self, live: &Arrivals) {
        if let Some(reason) = live.ended() {
            self.warn(&format!("it has ended: {reason}"));
        }
        let (name, dropped) = (&self.name, live.dropped());
        let came = self.done + dropped;
        complain(&format!("{name}: {came} frames came, {dropped} of them were dropped"));
    }

    /// Ends the outputs, and returns the text of lines that are kept. Errors: A box is for a frame after the last frame of
    /// a recording that is not live.
    pub fn finish(mut self, first: usize) -> Result<String> {
        self.bar.clear();
        let missing = self.targets.iter_mut().find_map(|target| Some((target.next_start()?, target.name.as_ref())));
        if let Some(live) = &self.live {
            self.say_end(live);
        } else if let Some((frame, name)) = missing {
            let name = name.map_or(String::new(), |name| format!(" for {name}"));
            let (of, last) = (&self.boxes_of, self.last);
            bail!("{}: there is no frame {frame}{name} ({of}): expected {first} to {last}", self.name);
        }
        self.lines.write(&self.printer.foot()?)?;
        self.lines.settle()?;
        if let Some((film, name)) = self.film.take() {
            if let Some(note) = film.finish()? {
                self.bar.suspend(|| complain(&format!("note: {note}")));
            }
            let written = format!("{}: {} frames", name.display(), self.done);
            match &self.events {
                Some(events) => {
                    self.bar.suspend(|| print(|out| write!(out, "{written}\n{}", self.ends(events))))?;
                }
                None if !self.bar.is_hidden() => self.bar.suspend(|| complain(&written)),
                None => {}
            }
        }
        self.lines.finish()
    }

    fn ends(&self, events: &Events) -> String {
        let line =
            |(at, target): (usize, &Follower)| format!("{}{}\n", self.heading(target.name.as_deref()), events.sum(at));
        self.targets.iter().enumerate().map(line).collect()
    }
}

fn warning(poor: &[Option<&str>]) -> Option<String> {
    match poor {
        [] => None,
        [None, ..] => Some(format!("the target {POOR}")),
        [Some(one)] => Some(format!("the target {one} {POOR}")),
        several => {
            let names: Vec<&str> = several.iter().copied().flatten().collect();
            Some(format!("each of {} targets {POOR}: {}", names.len(), names.join(", ")))
        }
    }
}
