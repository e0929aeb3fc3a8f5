//! Tests that a refused call changes nothing, also between the steps of an update or a lock.

use super::*;
use crate::Quality;
use crate::robust::Size;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

pub(super) trait Refusing: Target<Config: Settings> {
    /// A configuration that the tracker refuses.
    fn invalid() -> Self::Config;

    /// A valid configuration in which one setting differs from `config`.
    fn other(config: Self::Config) -> Self::Config;

    /// A box inside the frame that the tracker refuses; an empty one if there is none.
    const TOO_LARGE: Rect;
}

impl Refusing for SmallPaper {
    const TOO_LARGE: Rect = Rect::new(3, 3, 60, 60);

    fn invalid() -> paper::Config {
        paper::Config { window_limit: paper::Radius { x: 1, y: 1 }, ..small_paper() }
    }

    fn other(config: paper::Config) -> paper::Config {
        paper::Config { growth: config.growth + 1, ..config }
    }
}

impl<S: Size> Refusing for Robust<S> {
    const TOO_LARGE: Rect = Rect::new(0, 0, 0, 0);

    fn invalid() -> robust::Config {
        robust::Config { reach: 3, ..most_parts() }
    }

    fn other(config: robust::Config) -> robust::Config {
        robust::Config { patience: config.patience + 1, ..config }
    }
}

/// The arguments of the calls in [`refuse`].
struct Wrong {
    /// A picture, turned by 90 degrees and cut.
    pixels: Vec<u8>,
    /// Bytes that `restore` refuses: none, other text, cut off, with a changed bit, of another configuration.
    saved: [Vec<u8>; 5],
}

impl Wrong {
    fn of<T: Refusing>(config: T::Config) -> Self {
        let whole = saved(of_scene::<T>(config).target());
        let mut damaged = whole.clone();
        damaged[40] ^= 1;
        let cut = whole[..whole.len() - 1].to_vec();
        let other = saved(of_scene::<T>(T::other(config)).target());
        Self { pixels: picture(TARGET.x, TARGET.y), saved: [vec![], b"SMRxxxx".to_vec(), cut, damaged, other] }
    }
}

/// The number of calls in [`refuse`].
const KINDS: usize = 16;

/// Makes the refused call with index `kind`, for a tracker in any state.
fn refuse<T: Refusing>(tracker: &mut Tracker<T>, kind: usize, wrong: &Wrong) {
    let (frame, turned) = (whole(&wrong.pixels), of_size(&wrong.pixels, (SIZE.1, SIZE.0)));
    let corner = cut(&frame, Rect::new(0, 0, 1, 1));
    let locked = tracker.bbox().is_some();
    let [size, window] = [UpdateError::FrameSizeChanged, UpdateError::WindowNotInMemory]
        .map(|error| if locked { error } else { UpdateError::NotLocked });
    let mut place = [0_u8; 13];
    match kind {
        0 => assert_eq!(tracker.update(&turned), Err(size)),
        1 => assert_eq!(tracker.update(&corner), Err(window)),
        2 => assert_eq!(tracker.update_step(&turned, 9), Err(size)),
        3 => assert_eq!(tracker.update_step(&corner, 9), Err(window)),
        4 => assert_eq!(tracker.update_step_until(&turned, || false), Err(size)),
        5 => assert_eq!(tracker.lock(&frame, Rect::new(10, 10, 0, 20)), Err(LockError::BoxEmpty)),
        6 => assert_eq!(tracker.lock(&frame, Rect::new(150, 110, 24, 20)), Err(LockError::BoxOutsideFrame)),
        7 => assert_eq!(tracker.lock(&corner, TARGET), Err(LockError::LockWindowNotInMemory)),
        8 => assert!(tracker.lock(&frame, T::TOO_LARGE).is_err()),
        9 => assert_eq!(tracker.lock_step(&turned, Rect::new(-1, 0, 9, 9), 9), Err(LockError::BoxOutsideFrame)),
        10 => assert_eq!(tracker.lock_step(&corner, TARGET, 9), Err(LockError::LockWindowNotInMemory)),
        11 => assert!(tracker.configure(T::invalid()).is_err()),
        12 => {
            assert!(tracker.save(&mut place).is_err());
            assert_eq!(place, [0; 13]);
        }
        13 => {
            let mut written = 0;
            let mut recorder = Recorder::resume(1, |bytes: &[u8]| {
                written += bytes.len();
                Ok::<(), ()>(())
            });
            recorder.window(tracker.target(), &turned).unwrap_or_default();
            assert_eq!((recorder.entries(), written), (1, 0));
        }
        _ => wrong.saved.iter().skip(kind - 14).step_by(2).for_each(|bytes| assert!(tracker.restore(bytes).is_err())),
    }
}

/// Repeats `step` until the call is done, with the refused calls of `plan`, in turn, after each step. Returns the result
/// and the work after each step.
fn stepped<T: Refusing, A>(
    tracker: &mut Tracker<T>,
    step: impl Fn(&mut Tracker<T>) -> Option<A>,
    mut plan: impl Iterator<Item = Vec<usize>>,
    wrong: &Wrong,
) -> (A, Vec<u32>) {
    let mut works = vec![];
    loop {
        let done = step(tracker);
        works.push(tracker.work());
        assert!(works.len() < 10_000, "a call in steps ends");
        plan.next().unwrap_or_default().iter().for_each(|&kind| refuse(tracker, kind, wrong));
        assert_eq!(works.last(), Some(&tracker.work()));
        if let Some(done) = done {
            return (done, works);
        }
    }
}

/// A run of a tracker in steps.
#[derive(Debug, PartialEq)]
struct Run {
    /// The work after each step of the lock and of each update.
    works: Vec<Vec<u32>>,
    quality: Quality,
    /// Each answer, and the target as it is saved after it.
    answers: Vec<(Answer, Vec<u8>)>,
}

/// Runs a tracker in steps, with the refused calls of `plan`.
fn run<T: Refusing>(config: T::Config, (locking, updating): (u32, u32), plan: &[Vec<usize>], wrong: &Wrong) -> Run {
    let mut tracker = Box::new(Tracker::<T>::with(config).unwrap());
    let mut plan = plan.iter().cycle().cloned();
    let first = picture(TARGET.x, TARGET.y);
    let lock = |tracker: &mut Tracker<T>| tracker.lock_step(&whole(&first), TARGET, locking).unwrap();
    let (quality, work) = stepped(&mut tracker, lock, &mut plan, wrong);
    let (mut works, mut answers) = (vec![work], vec![]);
    for pixels in frames().iter().step_by(3) {
        let update = |tracker: &mut Tracker<T>| tracker.update_step(&whole(pixels), updating).unwrap();
        let (answer, work) = stepped(&mut tracker, update, &mut plan, wrong);
        works.push(work);
        answers.push((answer, saved(tracker.target())));
    }
    Run { works, quality, answers }
}

/// Steps, answers and saved bytes do not depend on refused calls between the steps.
pub(super) fn refused_calls_change_nothing_between_steps<T: Refusing>(config: T::Config) {
    let wrong = Wrong::of::<T>(config);
    let most = T::most_work(&config, TARGET.width, TARGET.height);
    let [lock, update] = [most.lock, most.update].map(|most| u32::try_from(most).unwrap());
    let plan = prop::collection::vec(prop::collection::vec(0..KINDS, 0..4), 1..12);
    let cases = (lock / 40..=lock / 2, update / 40..=update / 2, plan);
    let numbers =
        ProptestConfig { failure_persistence: None, max_shrink_time: 20_000, ..ProptestConfig::with_cases(8) };
    let ran = TestRunner::new(numbers).run(&cases, |(locking, updating, plan)| {
        let grants = (locking, updating);
        let with = run::<T>(config, grants, &plan, &wrong);
        prop_assert!(with == run::<T>(config, grants, &[], &wrong), "other steps or answers");
        Ok(())
    });
    ran.unwrap();
    // Each call alone.
    let grants = (lock / 20, update / 20);
    let without = run::<T>(config, grants, &[], &wrong);
    for kind in 0..KINDS {
        assert!(run::<T>(config, grants, &[vec![kind]], &wrong) == without, "call {kind}");
    }
}
