//! A long run: video without end through a tracker as firmware calls it, every answer compared with that of the same tracker called in the
//! plainest way, and a part of all frames with the float reference.
//!
//! The video is cut into sessions of [`SESSION`] frames, each with a scene and a lock of its own. One tracker takes whole frames at once, by
//! the fastest backend. The other takes the plain loops, without pruning, in steps of any size, sees only the pixels that it asks
//! for, and is now and then saved, thrown away and restored. Both are told alike of turns of the camera.

use crate::video::Video;
use anyhow::{Context, Result, ensure};
use host_sim::check::{Check, Checked, Violation};
use rayon::prelude::*;
use serde::Serialize;
use smr_core::paper::Radius;
use smr_core::similarity::Backend;
use smr_core::{Answer, Frame, Rect, Robust, Target, Tracker, paper, robust};
use smr_evaluation::CoreKind;
use smr_recordings::GrayFrame;
use smr_recordings::random::Random;
use smr_reference::{Numbers, robust as reference};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Frames of a session.
pub const SESSION: u64 = 500;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub method: CoreKind,
    pub frames: u64,
    /// Of every so many sessions the first frames are compared with the reference; 0 compares none.
    pub reference_every: u64,
    pub seed: u64,
}

/// Frames of such a session that are compared with the reference.
const REFERENCE_FRAMES: u64 = 50;

/// What was run, and what was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    pub frames: u64,
    pub sessions: u64,
    /// Frames that were compared with the reference, too.
    pub reference_frames: u64,
    /// Answers that were tracking, leaving, uncertain, lost.
    pub states: [u64; 4],
    pub found_again: u64,
    /// Faults of the camera, turns of it, and targets that were saved and restored.
    pub faults: u64,
    pub turns: u64,
    pub restored: u64,
    pub seconds: f64,
    /// The first answer that differs, and in which session.
    pub difference: Option<Difference>,
}

/// Two answers that should be the same.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// From 0; its scene is that of the seed plus this.
    pub session: u64,
    /// The frame in it, from 1.
    pub frame: u64,
    pub what: String,
    pub fast: String,
    pub plain: String,
}

/// A tracker that can be soaked.
trait Soaked: Checked + 'static {
    fn fastest() -> Self::Config;

    fn plain() -> Self::Config;

    fn numbers() -> Self::Numbers;
}

/// The window of the paper's tracker: one that every offset of can be scored in the time that there is.
const WINDOW: Radius = Radius { x: 12, y: 10 };
const LIMIT: Radius = Radius { x: 18, y: 16 };

impl Soaked for smr_evaluation::Paper {
    fn fastest() -> paper::Config {
        let mut config = paper::Config::camera();
        (config.window, config.window_limit) = (WINDOW, LIMIT);
        config
    }

    fn plain() -> paper::Config {
        let mut config = Self::fastest();
        (config.backend, config.pruning) = (Some(Backend::Scalar), false);
        config
    }

    fn numbers() -> Numbers {
        let pair = |radius: Radius| (radius.x.into(), radius.y.into());
        Numbers { window: pair(WINDOW), window_limit: Some(pair(LIMIT)), ..Numbers::camera() }
    }
}

impl Soaked for Robust {
    fn fastest() -> robust::Config {
        robust::Config::refined()
    }

    fn plain() -> robust::Config {
        let mut config = Self::fastest();
        config.backend = Some(Backend::Scalar);
        config
    }

    fn numbers() -> reference::Numbers {
        reference::Numbers::refined()
    }
}

/// Runs it all, sessions in parallel. `progress` is called with the frames that are done.
/// Errors: A tracker refuses what it must take.
pub fn soak(settings: Settings, progress: impl Fn(u64) + Sync) -> Result<Report> {
    match settings.method {
        CoreKind::Smr => sessions::<smr_evaluation::Paper>(settings, progress),
        CoreKind::Robust => sessions::<Robust>(settings, progress),
    }
}

fn sessions<T: Soaked>(settings: Settings, progress: impl Fn(u64) + Sync) -> Result<Report> {
    let start = Instant::now();
    let over = AtomicBool::new(false);
    let one = |session: u64| {
        if over.load(Ordering::Relaxed) {
            return Ok(Report::default());
        }
        let frames = SESSION.min(settings.frames - session * SESSION);
        let report = Session::<T>::new(settings, session)?.run(frames)?;
        over.fetch_or(report.difference.is_some(), Ordering::Relaxed);
        progress(report.frames);
        Ok(report)
    };
    let number = settings.frames.div_ceil(SESSION);
    let sum = (0..number).into_par_iter().map(one).try_reduce(Report::default, |sum, more| Ok(sum.add(more)));
    sum.map(|sum: Report| Report { seconds: start.elapsed().as_secs_f64(), ..sum })
}

impl Report {
    fn add(self, more: Self) -> Self {
        let mut states = self.states;
        states.iter_mut().zip(more.states).for_each(|(sum, more)| *sum += more);
        Self {
            frames: self.frames + more.frames,
            sessions: self.sessions + more.sessions,
            reference_frames: self.reference_frames + more.reference_frames,
            states,
            found_again: self.found_again + more.found_again,
            faults: self.faults + more.faults,
            turns: self.turns + more.turns,
            restored: self.restored + more.restored,
            seconds: 0.0,
            // Sessions are added in order: the first difference stays.
            difference: self.difference.or(more.difference),
        }
    }
}

struct Session<T: Soaked> {
    number: u64,
    video: Video,
    random: Random,
    fast: Box<Tracker<T>>,
    plain: Box<Tracker<T>>,
    check: Option<Check<T>>,
    report: Report,
}

impl<T: Soaked> Session<T> {
    fn new(settings: Settings, number: u64) -> Result<Self> {
        let seed = settings.seed.wrapping_add(number);
        let video = Video::new(seed);
        let (first, target) = video.first();
        let mut fast = Box::new(Tracker::<T>::new(T::fastest())?);
        let mut plain = Box::new(Tracker::<T>::new(T::plain())?);
        fast.lock(&first.frame(), target).with_context(|| format!("session {number}"))?;
        plain.lock(&first.frame(), target)?;
        let compared = number.checked_rem(settings.reference_every) == Some(0);
        let check = compared.then(|| Check::lock("soak", (T::fastest(), T::numbers()), u32::MAX, first, target));
        let report = Report { sessions: 1, ..Report::default() };
        Ok(Self { number, random: Random(!seed), fast, plain, check: check.transpose()?, report, video })
    }

    fn run(mut self, frames: u64) -> Result<Report> {
        for frame in 1..=frames {
            let shown = self.video.frame();
            let difference = match self.turn_or_reference(&shown, frame)? {
                None => self.compare(&shown, frame)?,
                found => found,
            };
            self.report.frames = frame;
            if difference.is_some() {
                self.report.difference = difference;
                break;
            }
        }
        self.report.faults = self.video.faulty;
        Ok(self.report)
    }

    /// The reference knows nothing of turns: while it is there, there are none.
    fn turn_or_reference(&mut self, shown: &GrayFrame, frame: u64) -> Result<Option<Difference>> {
        if let Some(check) = &mut self.check {
            check.update(shown)?;
            self.report.reference_frames += 1;
            if !check.holds() || frame == REFERENCE_FRAMES {
                let violation = self.check.take().and_then(|check| check.into_report().violation);
                return Ok(violation.map(|violation| self.of_reference(violation)));
            }
        } else if self.random.below(100) == 0 {
            let (right, down) = (self.random.below(4096) - 2048, self.random.below(4096) - 2048);
            let by = |by: i64| i32::try_from(by).unwrap_or(0);
            self.fast.moved(by(right), by(down));
            self.plain.moved(by(right), by(down));
            self.report.turns += 1;
        }
        Ok(None)
    }

    fn of_reference(&self, violation: Violation) -> Difference {
        let Violation { frame, what, core, reference } = violation;
        let frame = frame as u64 - 1;
        Difference {
            session: self.number,
            frame,
            what: format!("{what}, against the reference"),
            fast: core,
            plain: reference,
        }
    }

    fn compare(&mut self, shown: &GrayFrame, frame: u64) -> Result<Option<Difference>> {
        if self.random.below(40) == 0 {
            let saved = saved(&self.plain)?;
            *self.plain = Tracker::new(T::plain())?;
            self.plain.restore(&saved)?;
            self.report.restored += 1;
        }
        let whole = shown.frame();
        let fast = self.fast.update(&whole)?;
        let least = asked_for(whole, &self.plain)?;
        let most = 1 << (4 + self.random.below(17));
        let step = u32::try_from(1 + self.random.below(most)).unwrap_or(1);
        let mut update = self.plain.begin(&least)?;
        while !update.step(step) {}
        let plain = update.finish();
        let Answer { state, found_again, .. } = fast;
        self.report.states[state as usize] += 1;
        self.report.found_again += u64::from(found_again);
        let different = |what: &str, fast: String, plain: String| {
            Some(Difference { session: self.number, frame, what: what.to_owned(), fast, plain })
        };
        if fast == plain {
            // All that is remembered, now and then: each is some kilobytes.
            if frame.is_multiple_of(25) && saved(&self.fast)? != saved(&self.plain)? {
                return Ok(different("what is remembered", "saved bytes".to_owned(), "others".to_owned()));
            }
            return Ok(None);
        }
        Ok(different("answer", format!("{fast:?}"), format!("{plain:?}")))
    }
}

fn saved<T: Target>(tracker: &Tracker<T>) -> Result<Vec<u8>> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = tracker.save(&mut bytes)?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Those pixels of the frame that the tracker asks for, and no more.
fn asked_for<'a, T: Target>(frame: Frame<'a>, tracker: &Tracker<T>) -> Result<Frame<'a>> {
    let bounds = frame.bounds();
    let part = |rect: Rect| {
        ensure!(bounds.contains(rect), "it asks for {rect:?}, outside the frame");
        let image = frame.patch(rect).context("it is inside the frame")?;
        Ok((image, u16::try_from(rect.x)?, u16::try_from(rect.y)?))
    };
    // A window wholly on the padding reads nothing, but a frame has a pixel.
    let window = tracker.window().filter(|window| !window.is_empty()).unwrap_or(Rect::new(0, 0, 1, 1));
    let (image, x, y) = part(window)?;
    let least = Frame::part(image, x, y, bounds.width, bounds.height)?;
    let Some(sweep) = tracker.sweep_window() else { return Ok(least) };
    let (image, x, y) = part(sweep)?;
    Ok(least.and_part(image, x, y)?)
}

/// The most memory that this process has taken, in KiB, where the system tells.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soaked(method: CoreKind, frames: u64) -> Report {
        soak(Settings { method, frames, reference_every: 1, seed: 0 }, |_| ()).unwrap()
    }

    #[test]
    fn both_trackers_hold() {
        for (method, frames) in [(CoreKind::Smr, 1100), (CoreKind::Robust, 600)] {
            let report = soaked(method, frames);
            assert_eq!((report.difference, report.frames), (None, frames), "{method:?}");
            assert_eq!(report.reference_frames, REFERENCE_FRAMES * report.sessions);
            assert_eq!(report.states.iter().sum::<u64>(), frames);
            assert!(report.restored > 0 && report.turns > 0 && report.faults > 0, "{method:?}");
        }
    }

    #[test]
    fn another_answer_is_a_difference() {
        let settings = Settings { method: CoreKind::Smr, frames: SESSION, reference_every: 0, seed: 5 };
        let mut session = Session::<smr_evaluation::Paper>::new(settings, 0).unwrap();
        let mut other = smr_evaluation::Paper::plain();
        other.first_threshold = 40;
        *session.plain = Tracker::new(other).unwrap();
        let (first, target) = session.video.first();
        session.plain.lock(&first.frame(), target).unwrap();
        let shown = session.video.frame();
        let difference = session.compare(&shown, 1).unwrap().expect("another threshold, another answer");
        assert_eq!((difference.frame, difference.what.as_str()), (1, "answer"));
        assert_ne!(difference.fast, difference.plain);
    }
}
