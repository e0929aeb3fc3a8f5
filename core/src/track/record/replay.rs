//! Replays a record through a tracker.

use super::Recorded;
use super::read::{Begin, Damage, Entry, Found, entries};
use crate::image::{Frame, Rect};
use crate::track::{Answer, ConfigError, LockError, RestoreError, Target, Tracker, UpdateError};
use core::fmt;

/// The counts of replayed entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Replayed {
    /// Entries that begin a record.
    pub flights: u32,
    /// Locks on a box.
    pub locks: u32,
    /// Answers, all equal to the recorded ones.
    pub answers: u32,
}

/// The reason why a replay ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stop {
    /// The record is damaged.
    Damage(Damage),
    /// The replay differs from the record.
    Difference {
        /// Offset of the entry in the record, in bytes.
        at: usize,
        /// Sequence number of the entry. It starts again from 0 at each beginning of a record.
        number: u32,
        /// The difference.
        difference: Difference,
    },
}

errors! {
    /// A difference between the record and the replay.
    Difference {
        /// The record is of a tracker of another kind or size. Contains its letter.
        OtherTracker(tracker: char) => "the record is of the tracker {tracker} (P: Paper, R: Robust, S: Robust<Small>)",
        /// The recorded configuration is not valid for this tracker in this version, or its similarity table is neither
        /// the paper's nor the one in the `rest` of `Player::new`.
        Numbers => "the configuration is not one of this tracker and version, or its table is another",
        /// The configuration is refused.
        Config(error: ConfigError) => "configuration: {error}",
        /// A lock reads other pixels: (recorded window, replayed window).
        LockWindow(recorded: Rect, replayed: Rect) => "lock window: recorded {recorded:?}, replayed {replayed:?}",
        /// A lock fails.
        Lock(error: LockError) => "lock: {error}",
        /// An update reads other pixels: (recorded window, replayed window).
        Window(recorded: Option<Rect>, replayed: Option<Rect>) => "window: recorded {recorded:?}, replayed {replayed:?}",
        /// An update has another sweep window: (recorded, replayed).
        SweepWindow(recorded: Option<Rect>, replayed: Option<Rect>) => "sweep window: recorded {recorded:?}, replayed {replayed:?}",
        /// An update fails.
        Update(error: UpdateError) => "update: {error}",
        /// The answers differ: (recorded, replayed).
        Answer(recorded: Answer, replayed: Answer) => "answer: recorded {recorded:?}, replayed {replayed:?}",
        /// The record has an answer without a window before it.
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

/// Runs `record` through `tracker` and compares every answer with the recorded one. `update` computes each answer, for
/// example by [`Tracker::update`] or in steps. Each beginning in the record configures the tracker anew: see
/// [`Begin::config`](super::Begin::config). The [module](super) has an example.
///
/// # Errors
/// [`Stop`]: the first difference or damage. The tracker keeps the state that it has reached.
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

/// Replays single entries, for a caller that needs to see each of them. [`replay`] replays all entries of a record.
#[derive(Debug)]
pub struct Player<'a, T: Target> {
    rest: T::Config,
    window: Option<Frame<'a>>,
}

impl<'a, T: Recorded> Player<'a, T> {
    /// A player. `rest` supplies the settings that a record lacks: see [`Begin::config`](super::Begin::config).
    pub const fn new(rest: T::Config) -> Self {
        Self { rest, window: None }
    }

    /// The frame of the update that has begun and has no answer yet.
    #[must_use]
    pub const fn window(&self) -> Option<&Frame<'a>> {
        self.window.as_ref()
    }

    /// Applies `entry` to `tracker`, and compares the result with the recorded one.
    ///
    /// # Errors
    /// [`Difference`] if the result is not the recorded one.
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

#[inline(never)] // keeps its stack out of that of an update
fn configure<T: Recorded>(tracker: &mut Tracker<T>, begin: &Begin<'_>, rest: &T::Config) -> Result<(), Difference> {
    if begin.tracker != T::TRACKER {
        return Err(Difference::OtherTracker(begin.tracker.into()));
    }
    let config = begin.config(rest).ok_or(Difference::Numbers)?;
    tracker.configure(config).map_err(Difference::Config)
}

#[inline(never)] // as `configure`
fn restore<T: Recorded>(tracker: &mut Tracker<T>, saved: &[u8]) -> Result<(), Difference> {
    tracker.restore(saved).map_err(Difference::Restored)
}

fn same<V: PartialEq>(recorded: V, replayed: V, or: fn(V, V) -> Difference) -> Result<(), Difference> {
    if recorded == replayed { Ok(()) } else { Err(or(recorded, replayed)) }
}
