//! The target's last appearance: a bounded store, the rule that replaces it, and alpha (steps 5 and 6 of the method).

use super::config::Config;
use crate::image::{Image, Rect};
use crate::similarity::{Contrast, Table};
use heapless::Vec;

/// Up to `PIXELS` gray pixels, their shape, and the threshold that they are compared with.
pub(crate) struct Template<const PIXELS: usize> {
    pixels: Vec<u8, PIXELS>,
    width: u16,
    height: u16,
    /// alpha, rounded up to whole gray levels. On whole gray levels d < alpha and d < ceil(alpha) are the same test, so
    /// nothing is lost by it.
    threshold: u16,
}

impl<const PIXELS: usize> Template<PIXELS> {
    #[inline(always)] // made where it stays
    pub(crate) const fn new() -> Self {
        const { assert!(PIXELS <= Table::MAX_PIXELS, "a score of so many pixels could overflow") };
        Self { pixels: Vec::new(), width: 0, height: 0, threshold: 0 }
    }

    /// True if a patch of the size of `target` has room.
    pub(crate) fn holds(target: Rect) -> bool {
        usize::try_from(target.area()).is_ok_and(|area| area <= PIXELS)
    }

    /// Takes over `patch`, of which `holds` is true, and starts with the threshold of a first frame.
    pub(crate) fn start(&mut self, patch: Image<'_>, config: &Config) {
        self.pixels.clear();
        for row in patch.rows() {
            // Cannot fail: the caller has asked `holds`.
            let _ = self.pixels.extend_from_slice(row);
        }
        (self.width, self.height) = (patch.width(), patch.height());
        self.threshold = u16::from(config.first_threshold);
    }

    /// Takes over `pixels` of a patch of this size, which has room, and their threshold.
    pub(crate) fn restore(&mut self, pixels: &[u8], (width, height): (u16, u16), threshold: u16) {
        self.pixels.clear();
        let _ = self.pixels.extend_from_slice(pixels);
        (self.width, self.height, self.threshold) = (width, height, threshold);
    }

    /// Replaces the template by `patch`, of the same size, and sets alpha = k * the largest change of a pixel.
    ///
    /// If nothing changed alpha stays: an alpha of 0 would match nothing ever after.
    pub(crate) fn update(&mut self, patch: Image<'_>, config: &Config) {
        let mut largest = 0;
        for (old, new) in self.pixels.chunks_mut(usize::from(self.width).max(1)).zip(patch.rows()) {
            // Two loops, which compilers turn into wide ones.
            largest = old.iter().zip(new).fold(largest, |largest, (old, &new)| largest.max(old.abs_diff(new)));
            old.iter_mut().zip(new).for_each(|(old, &new)| *old = new);
        }
        if largest > 0 {
            self.threshold = threshold(largest, config).max(config.least_threshold.into());
        }
    }

    /// Whether `patch`, of the same size, can show it at all: it has a part of its contrast, and not many more pixels that are cut off.
    pub(crate) fn is_shown_by(&self, patch: Image<'_>) -> bool {
        let (was, is) = (self.image().map_or(Contrast::NONE, Contrast::of), Contrast::of(patch));
        is.has_contrast_of(was) && !is.is_cut_off_beside(was)
    }

    /// The pixels; `None` before the first `start`.
    pub(crate) fn image(&self) -> Option<Image<'_>> {
        Image::new(&self.pixels, self.width, self.height).ok()
    }

    pub(crate) const fn threshold(&self) -> u16 {
        self.threshold
    }
}

/// k * `largest_change`, rounded up; 256, which lets every pixel count, is the most that it can mean.
fn threshold(largest_change: u8, config: &Config) -> u16 {
    u16::try_from(config.k.ceil_of(largest_change)).unwrap_or(256).min(256)
}
