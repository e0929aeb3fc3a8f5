//! A record, run through a tracker again.

use super::Recorded;
use super::read::{Begin, Damage, Entry, Found, entries};
use crate::image::{Frame, Rect};
use crate::track::{Answer, ConfigError, LockError, RestoreError, Target, Tracker, UpdateError};
use core::fmt;

/// Counts of what was replayed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Replayed {
    /// Beginnings.
    pub flights: u32,
    /// Locks.
    pub locks: u32,
    /// Answers, all as they were recorded.
    pub answers: u32,
}

/// The reason why a replay ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stop {
    /// The record is damaged.
    Damage(Damage),
    /// Something else happened than was recorded.
    Difference {
        /// The first byte of the entry.
        at: usize,
        /// The number of the entry since the last beginning.
        number: u32,
        /// The difference.
        difference: Difference,
    },
}

errors! {
    /// A difference between the record and the replay.
    Difference {
        /// The configuration is not one of this tracker and version, or has another table.
        Numbers => "the configuration is not one of this tracker and version, or its table is another",
        /// The configuration is refused.
        Config(error: ConfigError) => "configuration: {error}",
        /// A lock reads other pixels: recorded, replayed.
        LockWindow(recorded: Rect, replayed: Rect) => "lock window: recorded {recorded:?}, replayed {replayed:?}",
        /// A lock fails.
        Lock(error: LockError) => "lock: {error}",
        /// An update reads other pixels: recorded, replayed.
        Window(recorded: Option<Rect>, replayed: Option<Rect>) => "window: recorded {recorded:?}, replayed {replayed:?}",
        /// An update has another second window: recorded, replayed.
        SweepWindow(recorded: Option<Rect>, replayed: Option<Rect>) => "sweep window: recorded {recorded:?}, replayed {replayed:?}",
        /// An update fails.
        Update(error: UpdateError) => "update: {error}",
        /// Another answer: recorded, replayed.
        Answer(recorded: Answer, replayed: Answer) => "answer: recorded {recorded:?}, replayed {replayed:?}",
        /// An answer without a window before it.
        NoWindow => "an answer without a window before it",
        /// A saved target is refused.
        Restored(error: RestoreError) => "saved target: {error}",
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damage(damage) => damage.fmt(f),
            Self::Difference { number, difference, .. } => write!(f, "entry {number}: {difference}"),
        }
    }
}

impl core::error::Error for Stop {}

/// Runs `record` through `tracker` and compares every answer with the recorded one.
///
/// `update` does each update: by [`Tracker::update`], in steps, or restored from a saved target before it. Each
/// beginning in the record gives the tracker the recorded configuration (see [`Begin::config`](super::Begin::config)).
/// The [module](super) has an example.
///
/// # Errors
/// The first difference, or the damage. The tracker is then where the record was left.
pub fn replay<T: Recorded>(
    record: &[u8],
    tracker: &mut Tracker<T>,
    mut update: impl FnMut(&mut Tracker<T>, &Frame<'_>) -> Result<Answer, UpdateError>,
) -> Result<Replayed, Stop> {
    let (mut player, mut replayed) = (Player::new(*tracker.config()), Replayed::default());
    for found in entries(record) {
        let Found { at, number, entry, .. } = found.map_err(Stop::Damage)?;
        let played = player.play(tracker, &entry, &mut update);
        played.map_err(|difference| Stop::Difference { at, number, difference })?;
        match entry {
            Entry::Begin(_) => replayed.flights += 1,
            Entry::Lock { .. } => replayed.locks += 1,
            Entry::Answer(_) => replayed.answers += 1,
            _ => {}
        }
    }
    Ok(replayed)
}

/// Runs entries through a tracker, one after the other: [`replay`], for a caller who wants to see each.
#[derive(Debug)]
pub struct Player<'a, T: Target> {
    rest: T::Config,
    /// The frame of an update that has no answer so far.
    window: Option<Frame<'a>>,
}

impl<'a, T: Recorded> Player<'a, T> {
    /// A player of trackers with the `rest` of a configuration: see [`Begin::config`](super::Begin::config).
    pub const fn new(rest: T::Config) -> Self {
        Self { rest, window: None }
    }

    /// The frame of the update that was begun and has no answer yet.
    #[must_use]
    pub const fn window(&self) -> Option<&Frame<'a>> {
        self.window.as_ref()
    }

    /// Does with `tracker` what the entry says, and compares what follows.
    ///
    /// # Errors
    /// Something else follows than was recorded.
    pub fn play(
        &mut self,
        tracker: &mut Tracker<T>,
        entry: &Entry<'a>,
        update: impl FnOnce(&mut Tracker<T>, &Frame<'_>) -> Result<Answer, UpdateError>,
    ) -> Result<(), Difference> {
        let window = self.window.take();
        match *entry {
            Entry::Begin(begin) => configure(tracker, &begin, &self.rest)?,
            Entry::Lock { ref frame, window, bbox } => {
                let replayed = tracker.lock_window(frame.bounds(), bbox);
                same(window, replayed, Difference::LockWindow)?;
                tracker.lock(frame, bbox).map_err(Difference::Lock)?;
            }
            Entry::Moved { right, down } => tracker.moved(right, down),
            Entry::Window { frame, window, sweep } => {
                same(Some(window), tracker.window(), Difference::Window)?;
                same(sweep, tracker.sweep_window(), Difference::SweepWindow)?;
                self.window = Some(frame);
            }
            Entry::Answer(recorded) => {
                let answer = update(tracker, &window.ok_or(Difference::NoWindow)?).map_err(Difference::Update)?;
                same(recorded, answer, Difference::Answer)?;
            }
            Entry::Restored(saved) => restore(tracker, saved)?,
        }
        Ok(())
    }
}

#[inline(never)] // else the stack of an update would have that of this, too
fn configure<T: Recorded>(tracker: &mut Tracker<T>, begin: &Begin<'_>, rest: &T::Config) -> Result<(), Difference> {
    let config = begin.config(rest).ok_or(Difference::Numbers)?;
    tracker.configure(config).map_err(Difference::Config)
}

#[inline(never)] // as above
fn restore<T: Recorded>(tracker: &mut Tracker<T>, saved: &[u8]) -> Result<(), Difference> {
    tracker.restore(saved).map_err(Difference::Restored)
}

fn same<V: PartialEq>(recorded: V, replayed: V, or: fn(V, V) -> Difference) -> Result<(), Difference> {
    if recorded == replayed { Ok(()) } else { Err(or(recorded, replayed)) }
}
