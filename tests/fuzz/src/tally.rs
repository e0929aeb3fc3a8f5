//! Counts the cases that inputs reach, by name. A test checks that the inputs reach all of them. A run prints the counts at its end.

use std::cell::Cell;

macro_rules! tally {
    ($($name:ident = $words:literal,)*) => {
        /// The cases that an input can reach.
        #[derive(Clone, Copy)]
        pub(crate) enum Reached {
            $($name,)*
        }

        const NAMES: &[&str] = &[$($words,)*];
    };
}

tally! {
    AnswerLeaving = "answer: leaving",
    AnswerLost = "answer: lost",
    AnswerTracking = "answer: tracking",
    AnswerUncertain = "answer: uncertain",
    BackendOfThisMachine = "backend: one that this machine has",
    BackendTheFastest = "backend: the fastest",
    BackendPlainLoop = "backend: the plain loop",
    FrameNotFromTheCorner = "frame: not from the corner",
    FrameRowsFarApart = "frame: rows far apart",
    FrameOnePart = "frame: one part",
    FrameTheWholeOfIt = "frame: the whole of it",
    FrameTwoParts = "frame: two parts",
    LockBoxEmpty = "lock: BoxEmpty",
    LockBoxOutsideFrame = "lock: BoxOutsideFrame",
    LockBoxTooLarge = "lock: BoxTooLarge",
    LockLockWindowNotInMemory = "lock: LockWindowNotInMemory",
    LockWindowTooLarge = "lock: WindowTooLarge",
    LockAnotherError = "lock: another error",
    LockDone = "lock: done",
    LockInSteps = "lock: in steps",
    Moved = "moved",
    NewRefused = "new: refused",
    OtherSizeFrameSizeChanged = "other size: FrameSizeChanged",
    OtherSizeNotLocked = "other size: NotLocked",
    OtherSizeWindowNotInMemory = "other size: WindowNotInMemory",
    OtherSizeAnotherError = "other size: another error",
    OtherSizeTaken = "other size: taken",
    RestoreRefusedForOneBit = "restore: refused for one bit",
    RestoreToStartWith = "restore: to start with",
    RestoreWhatWasJustSaved = "restore: what was just saved",
    PlainLoopsBesideIt = "the plain loops beside it",
    UpdateGivenUp = "update: given up",
    UpdateInSteps = "update: in steps",
    UpdateTakenUpAgainAfterEachStep = "update: taken up again after each step",
    UpdateWhole = "update: whole",
    UpdateWithoutWhatItAskedFor = "update: without what it asked for",
}

/// Numbers, not names: libFuzzer would put compared names into its dictionary.
struct Tally([Cell<u64>; NAMES.len()]);

thread_local! {
    static TALLY: Tally = const { Tally([const { Cell::new(0) }; NAMES.len()]) };
}

/// Counts one more.
pub(crate) fn count(reached: Reached) {
    TALLY.with(|Tally(all)| {
        let times = &all[reached as usize];
        times.set(times.get() + 1);
    });
}

/// The counts of this thread so far, by name; 0 for cases not reached.
pub fn reached() -> Vec<(&'static str, u64)> {
    TALLY.with(|Tally(all)| NAMES.iter().copied().zip(all.iter().map(Cell::get)).collect())
}

impl Drop for Tally {
    fn drop(&mut self) {
        for (name, times) in NAMES.iter().zip(&self.0) {
            if times.get() > 0 {
                eprintln!("reached: {:>10} {name}", times.get());
            }
        }
    }
}
