//! How long something takes, on a machine that does other things as well.

use anyhow::Result;
use std::time::{Duration, Instant};

/// How often the same thing is timed.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// At most so many times.
    pub repeats: u32,
    /// Not again, once all times together are more than this.
    pub enough: Duration,
}

/// The shortest of several times of the same work: whatever else the machine does can only make it longer. `once` does
/// the work and tells how long it took, without what it has to prepare.
///
/// # Errors
/// Those of `once`.
pub fn shortest(patience: Patience, mut once: impl FnMut() -> Result<Duration>) -> Result<Duration> {
    let mut least = once()?;
    let mut sum = least;
    for _ in 1..patience.repeats {
        if sum > patience.enough {
            break;
        }
        let time = once()?;
        sum += time;
        least = least.min(time);
    }
    Ok(least)
}

/// What `work` gives, and how long it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

/// A share of the time for one kind of work, spent evenly over all that is to be done: what is slow is done for fewer
/// cases, which lie as far apart as they can.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    all: Duration,
    spent: Duration,
    /// Cases that will come, as far as is known.
    expected: u32,
    asked: u32,
}

impl Budget {
    #[must_use]
    pub fn new(all: Duration, expected: u32) -> Self {
        Self { all, spent: Duration::ZERO, expected: expected.max(1), asked: 0 }
    }

    /// Whether the next case may be done: always, as long as no more was spent than its share.
    pub fn allows(&mut self) -> bool {
        let share = self.all * self.asked.min(self.expected) / self.expected;
        self.asked += 1;
        self.spent <= share
    }

    pub fn spend(&mut self, time: Duration) {
        self.spent += time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_counts_and_patience_ends() {
        let mut times = [5, 3, 4, 1].map(Duration::from_millis).into_iter();
        let mut next = || Ok(times.next().expect("asked too often"));
        let patience = |repeats| Patience { repeats, enough: Duration::from_millis(6) };
        assert_eq!(shortest(patience(2), &mut next).unwrap(), Duration::from_millis(3));
        assert_eq!(shortest(patience(9), || Ok(Duration::from_millis(7))).unwrap(), Duration::from_millis(7));
        assert_eq!(shortest(patience(2), &mut next).unwrap(), Duration::from_millis(1));
    }

    #[test]
    fn what_is_slow_is_done_at_equal_distances() {
        let mut budget = Budget::new(Duration::from_secs(4), 100);
        let done: Vec<usize> = (0..100)
            .filter(|_| {
                let allowed = budget.allows();
                if allowed {
                    budget.spend(Duration::from_secs(1));
                }
                allowed
            })
            .collect();
        assert_eq!(done, [0, 25, 50, 75]);
    }

    #[test]
    fn what_is_fast_is_always_done() {
        let mut budget = Budget::new(Duration::from_secs(4), 2);
        assert!((0..10).all(|_| budget.allows()));
    }
}
