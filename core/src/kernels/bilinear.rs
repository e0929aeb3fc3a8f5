//! Bilinear sampling: the columns of a resampled row, each interpolated from two neighbouring numbers, in units of
//! 1/256.

use super::backend::native;
use super::plain::bilinear::{MixedRow, PLACES};
use heapless::Vec;

/// The places of up to `N` columns in a row.
pub(crate) struct Interpolation<const N: usize> {
    /// The byte in the row where a column's first number begins.
    from: Vec<u16, N>,
    /// The weights of the first and of the second number, 256 together.
    parts: Vec<[u16; 2], N>,
}

impl<const N: usize> Interpolation<N> {
    /// The number of places: a column's first number is at a place below this.
    pub(crate) const PLACES: usize = PLACES as usize;

    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { from: Vec::new(), parts: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.from.clear();
        self.parts.clear();
    }

    /// The number of columns.
    pub(crate) fn count(&self) -> usize {
        self.from.len()
    }

    /// Adds a column at `place + part / 256`. Does nothing if there is no room.
    pub(crate) fn push(&mut self, place: u16, part: u8) {
        let _ = self.from.push(2 * (place % PLACES));
        let _ = self.parts.push([256 - u16::from(part), part.into()]);
    }

    /// Computes the rounded gray levels of the columns in `row`, up to the length of `out`.
    #[inline(always)]
    pub(crate) fn mix(&self, row: &MixedRow, out: &mut [u8]) {
        let Self { from, parts } = self;
        // SAFETY: `push` keeps each place below PLACES.
        #[allow(unused_unsafe)] // the plain loop is safe
        unsafe {
            native::bilinear::mix(from, parts, row, out);
        }
    }
}
