//! The early template: a mean of patches that learns so slowly that what slips in is noticed before it is learned.

use super::MOST_PIXELS;
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

    /// Begins with `patch`, or with as much of it as there is room for.
    pub(super) fn start(&mut self, patch: impl Iterator<Item = u8>) {
        self.fine.clear();
        for pixel in patch.take(MOST_PIXELS) {
            let _ = self.fine.push(u16::from(pixel) << 8);
        }
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
    pub(super) fn learn(&mut self, patch: impl Iterator<Item = u8>, rate: u16) {
        for (fine, new) in self.fine.iter_mut().zip(patch) {
            let difference = (i32::from(new) << 8) - i32::from(*fine);
            let moved = i32::from(*fine) + ((difference * i32::from(rate) + (1 << 9)) >> 10);
            // Between two numbers of 16 bits.
            *fine = u16::try_from(moved).unwrap_or(*fine);
        }
    }

    /// Rounded to gray levels.
    pub(super) fn pixels(&self) -> impl ExactSizeIterator<Item = u8> + Clone {
        self.fine.iter().map(|&fine| u8::try_from((u32::from(fine) + 128) >> 8).unwrap_or(u8::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_comes_within_two_gray_levels_of_what_it_learns() {
        let mut early = Early::new();
        early.start([0, 255].into_iter());
        assert!(early.pixels().eq([0, 255]));
        for _ in 0..20_000 {
            early.learn([255, 0].into_iter(), 1);
        }
        assert!(early.pixels().eq([253, 2]));
        early.learn([255, 0].into_iter(), 1024);
        assert!(early.pixels().eq([255, 0]));
    }
}
