//! The templates: the last patch, a running mean of patches, and a slower one.

use heapless::Vec;

/// A running mean of patches, in units of 1/256 gray level.
pub(super) struct Mean<const PIXELS: usize> {
    fine: Vec<u16, PIXELS>,
    pixels: Vec<u8, PIXELS>,
}

impl<const PIXELS: usize> Mean<PIXELS> {
    pub(super) const fn new() -> Self {
        Self { fine: Vec::new(), pixels: Vec::new() }
    }

    /// Begins with `patch`, or with as much of it as there is room for.
    pub(super) fn start(&mut self, patch: &[u8]) {
        self.fine.clear();
        self.pixels.clear();
        for &pixel in patch.iter().take(PIXELS) {
            let _ = (self.fine.push(u16::from(pixel) << 8), self.pixels.push(pixel));
        }
    }

    /// Moves a 2^-`rate` part of the way to `patch`, rounded.
    pub(super) fn learn(&mut self, patch: &[u8], rate: u32) {
        for ((fine, pixel), &new) in self.fine.iter_mut().zip(&mut self.pixels).zip(patch) {
            let difference = (i32::from(new) << 8) - i32::from(*fine);
            let moved = i32::from(*fine) + ((difference + (1 << (rate - 1))) >> rate);
            // Between two numbers of 16 bits.
            *fine = u16::try_from(moved).unwrap_or(*fine);
            *pixel = u8::try_from((u32::from(*fine) + 128) >> 8).unwrap_or(u8::MAX);
        }
    }

    /// Rounded to gray levels.
    pub(super) fn pixels(&self) -> &[u8] {
        &self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_reaches_what_it_learns() {
        let mut mean = Mean::<2>::new();
        mean.start(&[0, 255, 9]);
        assert_eq!(mean.pixels(), [0, 255]);
        for _ in 0..400 {
            mean.learn(&[255, 0], 5);
        }
        assert_eq!(mean.pixels(), [255, 0]);
    }
}
