//! The early template: a running mean of the target's pixels. It learns so slowly that verification notices a wrong
//! target before the template resembles it.
//!
//! ```text
//! t' = t + rate / 1024 * (patch - t), in units of 1/256 gray level, rounded
//! ```

use crate::image::Image;
use crate::kernels::rolled;
use heapless::{Vec, VecView};

/// `V` is a vector, or by default a view of one with any capacity.
pub(crate) struct Template<V: ?Sized = VecView<u16>> {
    mean: V,
}

impl<const N: usize> Template<Vec<u16, N>> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        Self { mean: Vec::new() }
    }
}

impl Template {
    /// Starts the mean with `patch`, which has no more pixels than the template has room for.
    pub(crate) fn start(&mut self, patch: Image<'_>) {
        self.mean.clear();
        let _ = self.mean.resize_default(usize::from(patch.width()) * usize::from(patch.height()));
        self.learn(patch, 1024);
    }

    pub(crate) fn restore(&mut self, mean: impl Iterator<Item = u16>) {
        self.mean.clear();
        for pixel in mean.take(self.mean.capacity()) {
            let _ = self.mean.push(pixel);
        }
    }

    /// All pixels in units of 1/256 gray level, row by row.
    pub(crate) fn mean(&self) -> &[u16] {
        &self.mean
    }

    /// Moves the mean by `rate` / 1024 of the way to `patch`. With a rate of 1, differences below 2 gray levels stay.
    #[inline(never)]
    pub(crate) fn learn(&mut self, patch: Image<'_>, rate: u16) {
        let columns = usize::from(patch.width());
        for y in 0..patch.height() {
            let mean = self.mean.iter_mut().skip(usize::from(y) * columns);
            for (mean, &new) in rolled(mean.zip(patch.row(y))) {
                let difference = (i32::from(new) << 8) - i32::from(*mean);
                let moved = i32::from(*mean) + ((difference * i32::from(rate) + (1 << 9)) >> 10);
                // Fits in 16 bits, because it lies between the old and the new pixel.
                *mean = u16::try_from(moved).unwrap_or(*mean);
            }
        }
    }

    /// All pixels, rounded to gray levels.
    pub(crate) fn pixels(&self) -> impl ExactSizeIterator<Item = u8> {
        self.mean.iter().map(|&mean| u8::try_from((u32::from(mean) + 128) >> 8).unwrap_or(u8::MAX))
    }

    #[inline(never)]
    pub(super) fn copy_to(&self, out: &mut VecView<u8>) {
        // Cannot fail: both vectors have the same capacity.
        let _ = out.resize_default(self.mean.len());
        rolled(out.iter_mut().zip(self.pixels())).for_each(|(out, pixel)| *out = pixel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_comes_within_two_gray_levels_of_what_it_learns() {
        let template: &mut Template = &mut Template::<Vec<u16, 2>>::new();
        let image = |pixels| Image::new(pixels, 2, 1).unwrap();
        template.start(image(&[0, 255]));
        assert!(template.pixels().eq([0, 255]));
        for _ in 0..20_000 {
            template.learn(image(&[255, 0]), 1);
        }
        assert!(template.pixels().eq([253, 2]));
        template.learn(image(&[255, 0]), 1024);
        assert!(template.pixels().eq([255, 0]));
    }
}
