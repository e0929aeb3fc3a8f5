//! A rate of frames, and when the frames of a video are shown: at their own times, or at a steady rate.

use anyhow::{Error, Result, ensure};
use smr_recordings::Moment;
use std::str::FromStr;

/// Frames in so many seconds, a fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    frames: u32,
    seconds: u32,
}

impl Rate {
    /// Of recordings that know no times.
    const DEFAULT: Self = Self { frames: 25, seconds: 1 };

    /// How long a frame is shown, in seconds, as a fraction.
    const fn interval(self) -> (u32, u32) {
        (self.seconds, self.frames)
    }
}

/// `25`, `29.97` or `30000/1001`.
impl FromStr for Rate {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "expected frames a second like 25, 29.97 or 30000/1001, from 1/1000 to 1000";
        let number = |text: &str| text.parse::<u32>().ok().filter(|&number| number > 0);
        let rate = match (text.split_once('/'), text.split_once('.')) {
            (Some((frames, seconds)), _) => number(frames).zip(number(seconds)),
            (_, Some(_)) => of_decimal(text),
            _ => number(text).map(|frames| (frames, 1)),
        };
        let (frames, seconds) = rate.ok_or_else(|| Error::msg(expected))?;
        let a_second = f64::from(frames) / f64::from(seconds);
        ensure!((0.001..=1000.0).contains(&a_second), expected);
        Ok(Self { frames, seconds })
    }
}

/// The rates of television are written with few digits.
fn of_decimal(text: &str) -> Option<(u32, u32)> {
    let rate = text.parse::<f64>().ok().filter(|rate| (0.0..=1e6).contains(rate))?;
    let television = [24, 30, 60, 120].map(|frames| (frames * 1000, 1001));
    let near = |&(frames, seconds): &(u32, u32)| (f64::from(frames) / f64::from(seconds) - rate).abs() < 0.006;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the range is checked
    let thousandths = (rate * 1000.0).round() as u32;
    television.into_iter().find(near).or((thousandths > 0).then_some((thousandths, 1000)))
}

/// The times of the frames of a film, one after the other.
pub(super) struct Timeline {
    /// `None`: frames have times of their own.
    rate: Option<Rate>,
    frames: u64,
    first: Option<Moment>,
    /// Of the last frame, in microseconds, and how long after the one before it.
    last: u64,
    interval: u64,
}

impl Timeline {
    pub const fn new(rate: Option<Rate>) -> Self {
        Self { rate, frames: 0, first: None, last: 0, interval: 40_000 }
    }

    /// When the next frame is shown, in microseconds from the first one.
    pub fn next(&mut self, moment: Option<Moment>) -> u64 {
        if self.frames == 0 && self.rate.is_none() {
            self.first = moment;
            self.rate = moment.is_none().then_some(Rate::DEFAULT);
        }
        let time = match (self.rate, self.first, moment) {
            (Some(Rate { frames, seconds }), ..) => {
                (self.frames * u64::from(seconds) * 1_000_000 + u64::from(frames) / 2) / u64::from(frames)
            }
            (_, Some(first), Some(moment)) => microseconds(moment.seconds() - first.seconds()),
            _ => self.last + self.interval,
        };
        if self.frames > 0 {
            // Times must grow: a file that says otherwise is damaged.
            self.interval = time.saturating_sub(self.last).max(1);
            self.last += self.interval;
        }
        self.frames += 1;
        self.last
    }

    /// What the times are whole multiples of, in seconds, as a fraction.
    pub fn base(&self) -> (u32, u32) {
        self.first.map_or_else(|| self.rate.unwrap_or(Rate::DEFAULT).interval(), |first| first.base)
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

    fn rate(text: &str) -> Rate {
        text.parse().unwrap()
    }

    #[test]
    fn rates_as_they_are_typed() {
        for (text, frames, seconds) in [
            ("25", 25, 1),
            ("30000/1001", 30000, 1001),
            ("29.97", 30000, 1001),
            ("23.976", 24000, 1001),
            ("59.94", 60000, 1001),
            ("12.5", 12500, 1000),
            ("1/60", 1, 60),
        ] {
            assert_eq!(rate(text), Rate { frames, seconds }, "{text}");
        }
        for refused in ["", "0", "-5", "1/0", "0/1", "0.0001", "2000", "1e3.", "25fps", "NaN", "inf.", "1/2/3"] {
            let error = refused.parse::<Rate>().unwrap_err().to_string();
            assert!(error.starts_with("expected frames a second"), "{refused}: {error}");
        }
    }

    #[test]
    fn a_steady_rate_does_not_drift() {
        let mut timeline = Timeline::new(Some(rate("30000/1001")));
        let times: Vec<u64> = (0..30_001).map(|_| timeline.next(None)).collect();
        assert_eq!((times[1], times[30], times[30_000]), (33_367, 1_001_000, 1_001_000_000));
        assert_eq!((timeline.base(), timeline.start()), ((1001, 30000), None));
    }

    #[test]
    fn times_of_frames_are_kept() {
        let at = |time| Some(Moment { time, base: (1, 1000), aspect: (1, 1) });
        let mut timeline = Timeline::new(None);
        let times = [at(500), at(533), at(600), None, at(590), at(700)].map(|moment| timeline.next(moment));
        assert_eq!(times, [0, 33_000, 100_000, 167_000, 167_001, 200_000]);
        assert_eq!((timeline.base(), timeline.start()), ((1, 1000), Some(0.5)));
        let mut unknown = Timeline::new(None);
        assert_eq!([None, at(5), None].map(|moment| unknown.next(moment)), [0, 40_000, 80_000]);
    }
}
