//! The levels of 16-bit pictures: the values that become black and white in the 8 bits that trackers see.

use super::images::Picture;
use anyhow::{Context, Error, Result, ensure};
use std::fmt;
use std::str::FromStr;

/// A range of values of 16 bits that is stretched over 0 to 255; what lies outside becomes black or white. As text `7600..8366`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    black: u16,
    white: u16,
}

impl Levels {
    pub(super) fn of(self, value: u16) -> u8 {
        let (above, span) = (u32::from(value.saturating_sub(self.black)), u32::from(self.white - self.black));
        u8::try_from((255 * above + span / 2) / span).unwrap_or(255)
    }
}

impl FromStr for Levels {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let ends = text.split_once("..").and_then(|(black, white)| Some((black.parse().ok()?, white.parse().ok()?)));
        let expected = "expected two values from 0 to 65535, black..white, like 7600..8366";
        let (black, white) = ends.context(expected)?;
        ensure!(black < white, "{expected}: the smaller one first");
        Ok(Self { black, white })
    }
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.black, self.white)
    }
}

/// The number of levels (of 256) below which a note is given: 14 bits leave as many in 16.
const FEW: usize = 64;

/// The number of pixels of which one may be dead.
const DEAD: u64 = 10_000;

/// Says which levels the first, the middle and the last of `pictures` use, if they have 16 bits and use few. One pixel in 10,000 at each end
/// is not counted: sensors have dead ones.
pub(super) fn note(pictures: &[Picture]) -> Option<String> {
    let mut counts = vec![0_u64; 1 << 16];
    let mut all = 0;
    for at in [0, pictures.len() / 2, pictures.len().saturating_sub(1)] {
        let samples = pictures.get(at).filter(|picture| picture.is_file())?.samples().ok()?;
        for value in samples.values()? {
            counts[usize::from(value)] += 1;
            all += 1;
        }
    }
    let mut below = 0;
    let mut used = (0..=u16::MAX).zip(counts).filter_map(|(value, count)| {
        below += count;
        (below > all / DEAD && below - count < all - all / DEAD).then_some(value)
    });
    let first = used.next()?;
    let last = used.last().unwrap_or(first);
    let levels = pictures.first()?.levels;
    let [low, high] = [first, last].map(|value| levels.map_or(value.to_be_bytes()[0], |levels| levels.of(value)));
    if usize::from(high - low) >= FEW {
        return None;
    }
    let margin = ((last - first) / 4).max(8);
    let wanted = Levels { black: first.saturating_sub(margin), white: last.saturating_add(margin) };
    Some(format!(
        "of its 16-bit values only {first} to {last} occur: trackers see levels {low} to {high} of 256; --levels {wanted} stretches them"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_stretched_and_clamped() {
        let levels: Levels = "7600..8365".parse().unwrap();
        let values = [0, 7600, 7601, 7602, 7982, 8365, 8366, 65535].map(|value| levels.of(value));
        assert_eq!((values, levels.to_string().as_str()), ([0, 0, 0, 1, 127, 255, 255, 255], "7600..8365"));
        assert_eq!("0..65535".parse::<Levels>().unwrap().of(257 * 99), 99);
        for text in ["", "5", "5..", "..5", "5..5", "6..5", "0..65536", "-1..5", "a..b", "1...5"] {
            let error = text.parse::<Levels>().unwrap_err().to_string();
            assert!(error.starts_with("expected two values"), "{text}");
            assert_eq!(error.ends_with("the smaller one first"), ["5..5", "6..5"].contains(&text), "{text}");
        }
    }
}
