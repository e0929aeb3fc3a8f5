//! The template, its update, and alpha (steps 5 and 6 of the method).

use super::config::Config;
use crate::image::Image;
use crate::kernels::{replace, rolled};
use crate::similarity::{Contrast, Table};
use heapless::Vec;

/// The template: up to `PIXELS` gray pixels, their width and height, and the threshold.
pub(crate) struct Template<const PIXELS: usize> {
    pixels: Vec<u8, PIXELS>,
    width: u16,
    height: u16,
    /// ceil(alpha), 0 to 256. For an integer d, d < alpha is the same as d < ceil(alpha).
    threshold: u16,
    /// The contrast of the pixels; [`Contrast::NONE`] until it is computed.
    pub(super) contrast: Contrast,
}

impl<const PIXELS: usize> Template<PIXELS> {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        const { assert!(PIXELS <= Table::MAX_PIXELS, "the score of a larger template could overflow") };
        Self { pixels: Vec::new(), width: 0, height: 0, threshold: 0, contrast: Contrast::NONE }
    }

    /// Copies `patch`, of at most `PIXELS` pixels, and sets the first threshold.
    pub(crate) fn start(&mut self, patch: Image<'_>, config: &Config) {
        self.restore(&[], (patch.width(), patch.height()), config.first_threshold.into());
        for y in 0..patch.height() {
            self.append(patch.row(y));
        }
    }

    /// Sets the pixels (at most `PIXELS`), their width and height, and the threshold.
    pub(crate) fn restore(&mut self, pixels: &[u8], (width, height): (u16, u16), threshold: u16) {
        self.contrast = Contrast::NONE;
        self.pixels.clear();
        self.append(pixels);
        (self.width, self.height, self.threshold) = (width, height, threshold);
    }

    /// Appends `pixels`. The callers have checked that the template stays within `PIXELS` pixels.
    #[cfg_attr(smr_small, inline(never))]
    fn append(&mut self, pixels: &[u8]) {
        if cfg!(target_os = "none") {
            // Saves flash: `extend_from_slice` needs `memcpy`, which no other code on bare metal needs.
            for &pixel in rolled(pixels.iter()) {
                let _ = self.pixels.push(pixel);
            }
        } else {
            let _ = self.pixels.extend_from_slice(pixels);
        }
    }

    /// Replaces the template G by `patch` G' of the same size, and sets alpha = k * max |G' - G|, but at least
    /// `least_threshold`. If no pixel changed, alpha stays: with an alpha of 0 no pixel would match again. `contrast`
    /// is that of `patch`, or [`Contrast::NONE`] if it was not computed.
    pub(crate) fn update(&mut self, patch: Image<'_>, contrast: Contrast, config: &Config) {
        let mut largest = 0;
        let columns = usize::from(self.width);
        for y in 0..patch.height() {
            let old = self.pixels.get_mut(usize::from(y) * columns..).and_then(|rest| rest.get_mut(..columns));
            largest = replace(old.unwrap_or_default(), patch.row(y), largest);
        }
        self.contrast = contrast;
        if largest > 0 {
            self.threshold = threshold(largest, config).max(config.least_threshold.into());
        }
    }

    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn image(&self) -> Option<Image<'_>> {
        Image::new(&self.pixels, self.width, self.height).ok()
    }

    pub(crate) const fn threshold(&self) -> u16 {
        self.threshold
    }
}

/// ceil(alpha) = ceil(k * `largest_change`); at most 256, at which every pixel matches.
fn threshold(largest_change: u8, config: &Config) -> u16 {
    u16::try_from(config.k.ceil_of(largest_change)).unwrap_or(256).min(256)
}
