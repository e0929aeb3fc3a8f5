//! The length of a pixel, by which positions and speeds are printed in metres.

use anyhow::{Context, Error, Result, ensure};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Pixels of the recording that are a metre long. A metre has the same number of pixels across and down, everywhere in
/// the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "f64")]
pub struct PixelsPerMetre(f64);

const EXPECTED: &str = "expected a number from 0.000001 to 1000000, such as 120.5";

impl PixelsPerMetre {
    /// Returns the numbers across and down in frames that were resized by these factors.
    pub fn resized(self, (across, down): (f64, f64)) -> (f64, f64) {
        (self.0 * across, self.0 * down)
    }
}

impl TryFrom<f64> for PixelsPerMetre {
    type Error = Error;

    fn try_from(number: f64) -> Result<Self> {
        ensure!((1e-6..=1e6).contains(&number), EXPECTED);
        Ok(Self(number))
    }
}

impl FromStr for PixelsPerMetre {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        text.parse::<f64>().ok().context(EXPECTED)?.try_into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_has_a_positive_number_of_pixels() {
        assert_eq!("120.5".parse::<PixelsPerMetre>().unwrap().resized((0.5, 2.0)), (60.25, 241.0));
        for refused in ["", "0", "-0", "-3", "nan", "inf", "1e7", "1e-7", "1e999", "120,5", "120 px"] {
            assert_eq!(refused.parse::<PixelsPerMetre>().unwrap_err().to_string(), EXPECTED, "{refused}");
        }
        assert_eq!(serde_json::from_str::<PixelsPerMetre>("120").unwrap(), PixelsPerMetre(120.0));
        assert!(serde_json::from_str::<PixelsPerMetre>("0").is_err());
    }
}
