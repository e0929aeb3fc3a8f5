//! Numbers of frames as they come from outside: a command line, a file with boxes, or the page of `view`.

use serde::Deserialize;
use std::str::FromStr;

/// Number of a frame, 1 to [`FrameNumber::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "u64")]
pub struct FrameNumber(usize);

impl FrameNumber {
    /// Largest number of a frame: more than a year at 60 frames a second. The sum of two fits a `usize` of 32 bits.
    pub const MAX: usize = i32::MAX as usize;

    pub const fn get(self) -> usize {
        self.0
    }
}

impl TryFrom<u64> for FrameNumber {
    type Error = String;

    fn try_from(number: u64) -> Result<Self, String> {
        let number = usize::try_from(number).ok().filter(|number| (1..=Self::MAX).contains(number));
        number.map(Self).ok_or_else(|| format!("expected the number of a frame, 1 to {}", Self::MAX))
    }
}

impl FromStr for FrameNumber {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().unwrap_or(0).try_into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_a_frame_is_bounded() {
        for (text, number) in [("1", 1), ("007", 7), ("2147483647", FrameNumber::MAX)] {
            assert_eq!(text.parse::<FrameNumber>().unwrap().get(), number);
        }
        for text in ["", "0", "-1", "1.5", "1e3", "2147483648", "18446744073709551615", "18446744073709551616", "x"] {
            let error = text.parse::<FrameNumber>().unwrap_err();
            assert_eq!(error, "expected the number of a frame, 1 to 2147483647", "{text}");
        }
        let most = FrameNumber::MAX;
        assert_eq!(i32::try_from(most).ok(), Some(i32::MAX));
        assert!(serde_json::from_str::<FrameNumber>("2147483648").is_err());
        assert_eq!(serde_json::from_str::<FrameNumber>("3").unwrap().get(), 3);
    }
}
