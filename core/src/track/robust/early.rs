//! The early template: a mean of patches that learns so slowly that what slips in is noticed before it is learned.

use super::MOST_PIXELS;
use crate::image::Image;
use crate::kernels::rolled;
use heapless::Vec;

/// A running mean of patches, in units of 1/256 gray level.
pub(super) struct Early {
    fine: Vec<u16, MOST_PIXELS>,
}

impl Early {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        Self { fine: Vec::new() }
    }

    /// Begins with `patch`, which has at most `MOST_PIXELS`.
    pub(super) fn start(&mut self, patch: Image<'_>) {
        self.fine.clear();
        let _ = self.fine.resize_default(usize::from(patch.width()) * usize::from(patch.height()));
        self.learn(patch, 1024);
    }

    /// Goes on with these numbers, as many as there is room for.
    pub(super) fn restore(&mut self, fine: impl Iterator<Item = u16>) {
        self.fine.clear();
        for number in fine.take(MOST_PIXELS) {
            let _ = self.fine.push(number);
        }
    }

    /// All numbers.
    pub(super) fn fine(&self) -> &[u16] {
        &self.fine
    }

    /// Moves `rate` 1024ths of the way to `patch`, rounded: by one of them a pixel that differs by less than 2 gray levels stays.
    #[inline(never)] // one copy in flash
    pub(super) fn learn(&mut self, patch: Image<'_>, rate: u16) {
        let columns = usize::from(patch.width());
        for y in 0..patch.height() {
            let fine = self.fine.iter_mut().skip(usize::from(y) * columns);
            for (fine, &new) in rolled(fine.zip(patch.row(y))) {
                let difference = (i32::from(new) << 8) - i32::from(*fine);
                let moved = i32::from(*fine) + ((difference * i32::from(rate) + (1 << 9)) >> 10);
                // Between two numbers of 16 bits.
                *fine = u16::try_from(moved).unwrap_or(*fine);
            }
        }
    }

    /// Rounded to gray levels.
    pub(super) fn pixels(&self) -> impl ExactSizeIterator<Item = u8> {
        self.fine.iter().map(|&fine| u8::try_from((u32::from(fine) + 128) >> 8).unwrap_or(u8::MAX))
    }

    /// The same in `out`.
    #[inline(never)] // one copy in flash
    pub(super) fn copy_to(&self, out: &mut Vec<u8, MOST_PIXELS>) {
        // Cannot fail: there is room for as many.
        let _ = out.resize_default(self.fine.len());
        rolled(out.iter_mut().zip(self.pixels())).for_each(|(out, pixel)| *out = pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_comes_within_two_gray_levels_of_what_it_learns() {
        let mut early = Early::new();
        let image = |pixels| Image::new(pixels, 2, 1).unwrap();
        early.start(image(&[0, 255]));
        assert!(early.pixels().eq([0, 255]));
        for _ in 0..20_000 {
            early.learn(image(&[255, 0]), 1);
        }
        assert!(early.pixels().eq([253, 2]));
        early.learn(image(&[255, 0]), 1024);
        assert!(early.pixels().eq([255, 0]));
    }
}
