//! Whole numbers on the command line: what is refused is told which ones are expected.

use anyhow::{Result, anyhow};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Reads a whole number of this range, which `T` must be able to hold.
pub fn whole<T: FromStr>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number: &u64| range.contains(number));
        let number = number.and_then(|number| number.to_string().parse().ok());
        number.ok_or_else(|| match (range.start(), range.end()) {
            (first, &u64::MAX) => anyhow!("expected a whole number, {first} or more"),
            (first, last) => anyhow!("expected a whole number from {first} to {last}"),
        })
    }
}

/// The same without an upper limit but that of the machine.
pub fn from<T: FromStr>(first: u64) -> impl Fn(&str) -> Result<T> + Clone {
    whole(first..=u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::num::NonZeroU16;

    #[test]
    fn what_is_refused_is_told_the_range() {
        let read = whole::<NonZeroU16>(1..=65535);
        assert_eq!(read("65535").unwrap(), NonZeroU16::MAX);
        for text in ["", "0", "-1", "a", "1.5", "65536", "99999999999999999999999", " 5"] {
            assert_eq!(read(text).unwrap_err().to_string(), "expected a whole number from 1 to 65535", "{text}");
        }
        assert_eq!(from::<u64>(1)("0").unwrap_err().to_string(), "expected a whole number, 1 or more");
    }
}
