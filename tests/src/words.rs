//! The words of a line of the vectors.

use smr_core::paper::{Fraction, Margins, Radius};
use smr_core::{Rect, State};

/// The values of a line, one after the other.
pub struct Words<'a>(core::str::Split<'a, char>);

impl<'a> Words<'a> {
    pub(crate) fn new(values: &'a str) -> Self {
        Self(values.split(' '))
    }

    pub(crate) fn number<T: core::str::FromStr>(&mut self) -> Option<T> {
        self.0.next()?.parse().ok()
    }

    pub(crate) fn pair<T: core::str::FromStr>(&mut self) -> Option<(T, T)> {
        Some((self.number()?, self.number()?))
    }

    pub(crate) fn rect(&mut self) -> Option<Rect> {
        Some(Rect::new(self.number()?, self.number()?, self.number()?, self.number()?))
    }

    pub(crate) fn fraction(&mut self) -> Option<Fraction> {
        self.pair().map(|(numerator, denominator)| Fraction::new(numerator, denominator))
    }

    pub(crate) fn radius(&mut self) -> Option<Radius> {
        self.pair().map(|(x, y)| Radius { x, y })
    }

    pub(crate) fn margins(&mut self) -> Option<Margins> {
        let ((left, top), (right, bottom)) = (self.pair()?, self.pair()?);
        Some(Margins { left, top, right, bottom })
    }

    pub(crate) fn switch(&mut self) -> Option<bool> {
        match self.number::<u8>()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    pub(crate) fn state(&mut self) -> Option<State> {
        crate::state(self.0.next()?)
    }

    pub(crate) fn hash(&mut self) -> Option<u32> {
        u32::from_str_radix(self.0.next()?, 16).ok()
    }

    pub(crate) fn hex(&mut self) -> Option<Hex<'a>> {
        self.0.next().map(Hex)
    }
}

/// Pixels as hexadecimal digits.
#[derive(Clone, Copy, Debug)]
pub struct Hex<'a>(&'a str);

impl<'a> Hex<'a> {
    pub(crate) const fn new(digits: &'a str) -> Self {
        Self(digits)
    }

    /// The bytes, written to the start of `buffer`; `None` if they are not hexadecimal or do not fit.
    pub fn decode<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let digits = self.0.as_bytes().chunks_exact(2);
        let length = digits.len();
        if !digits.remainder().is_empty() || length > buffer.len() {
            return None;
        }
        for (byte, pair) in buffer.iter_mut().zip(digits) {
            *byte = u8::from_str_radix(core::str::from_utf8(pair).ok()?, 16).ok()?;
        }
        buffer.get(..length)
    }
}
