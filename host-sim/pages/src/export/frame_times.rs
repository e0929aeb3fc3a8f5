//! Times of the frames of a video: those of the recording, or 25 a second where it has none.

use smr_recordings::Moment;

/// The times of the frames of a film, one after the other.
pub(super) struct Timeline {
    is_begun: bool,
    first: Option<Moment>,
    /// Of the last frame, in microseconds, and how long after the one before it.
    last: u64,
    interval: u64,
}

impl Timeline {
    pub const fn new() -> Self {
        Self { is_begun: false, first: None, last: 0, interval: 40_000 }
    }

    /// When the next frame is shown, in microseconds from the first one.
    pub fn next(&mut self, moment: Option<Moment>) -> u64 {
        if !self.is_begun {
            (self.is_begun, self.first) = (true, moment);
            return 0;
        }
        let time = match (self.first, moment) {
            (Some(first), Some(moment)) => microseconds(moment.seconds() - first.seconds()),
            _ => self.last + self.interval,
        };
        // Times must grow: a file that says otherwise is damaged.
        self.interval = time.saturating_sub(self.last).max(1);
        self.last += self.interval;
        self.last
    }

    /// What the times are whole multiples of, in seconds, as a fraction.
    pub fn base(&self) -> (u32, u32) {
        self.first.map_or((1, 25), |first| first.base)
    }

    /// When the first frame is shown in the recording, in seconds; `None` if the times are not those of the recording.
    pub fn start(&self) -> Option<f64> {
        self.first.map(|first| first.seconds())
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_frames_are_kept() {
        let at = |time| Some(Moment { time, base: (1, 1000), aspect: (1, 1) });
        let mut timeline = Timeline::new();
        let times = [at(500), at(533), at(600), None, at(590), at(700)].map(|moment| timeline.next(moment));
        assert_eq!(times, [0, 33_000, 100_000, 167_000, 167_001, 200_000]);
        assert_eq!((timeline.base(), timeline.start()), ((1, 1000), Some(0.5)));
        let mut unknown = Timeline::new();
        assert_eq!([None, at(5), None].map(|moment| unknown.next(moment)), [0, 40_000, 80_000]);
        assert_eq!((unknown.base(), unknown.start()), ((1, 25), None));
    }
}
