//! The similarity table that kernels look up: entries by gray-level difference, 0 from the threshold on.

#[cfg(any(smr_dsp, smr_helium))]
use super::arm::points::Points;
use super::unrolling::rolled;

/// Number of entries: 256, or 511 without vectors, where it costs less to index by the signed difference than to
/// compute its absolute value.
const ENTRIES: usize = if cfg!(smr_swar) { 511 } else { 256 };

/// Similarity by gray-level difference, 0 from a threshold on (step 2 of the paper), so kernels need no comparison.
///
/// A [`Scorer`](crate::similarity::Scorer) borrows it. It takes half a kilobyte, or one where
/// [`Backend::Swar`](crate::similarity::Backend) is the fastest, and is recomputed when the threshold changes.
#[derive(Clone, Debug)]
pub struct CutTable {
    /// The entries from difference 0 on, or from -255 on if there are 511.
    entries: [u16; ENTRIES],
    threshold: u16,
    #[cfg(any(smr_dsp, smr_helium))]
    points: Points,
}

impl CutTable {
    pub(crate) const EMPTY: Self = Self {
        entries: [0; ENTRIES],
        threshold: 0,
        #[cfg(any(smr_dsp, smr_helium))]
        points: Points::NONE,
    };

    /// Copies the entries below `threshold` and sets all others to 0.
    #[cfg_attr(smr_small, inline(never))]
    pub(crate) fn cut(&mut self, entries: &[u16; 256], threshold: u16) {
        // Entries from the previous threshold on are 0 already.
        let changing = usize::from(self.threshold.max(threshold)).min(256);
        let (mirrored, differences) = self.entries.split_at_mut_checked(ENTRIES - 256).unwrap_or_default();
        let to = differences.get_mut(..changing).unwrap_or_default();
        for (d, (to, &from)) in rolled(to.iter_mut().zip(entries)).enumerate() {
            *to = if d < threshold.into() { from } else { 0 };
        }
        rolled(mirrored.iter_mut().rev().zip(differences.iter().skip(1))).for_each(|(to, &from)| *to = from);
        self.threshold = threshold;
        #[cfg(any(smr_dsp, smr_helium))]
        self.points.set(&self.entries, threshold);
    }

    /// Similarity p of two pixels that differ by `difference` gray levels, in units of 1/65535.
    #[must_use]
    #[inline]
    #[allow(clippy::indexing_slicing)] // a u8 cannot be out of the bounds of 256 entries
    pub const fn similarity(&self, difference: u8) -> u16 {
        self.entries[ENTRIES - 256 + difference as usize]
    }

    #[inline(always)]
    #[cfg_attr(target_arch = "arm", allow(dead_code))] // not by DSP and Helium
    pub(super) fn of_pixels(&self, f: u8, g: u8) -> u16 {
        #[cfg(smr_swar)]
        // SAFETY: a signed difference is -255 to 255, and entry 255 of 511 is that of the difference 0.
        return unsafe { *self.entries.as_ptr().add(255).offset(isize::from(f) - isize::from(g)) };
        #[cfg(not(smr_swar))]
        self.similarity(f.abs_diff(g))
    }

    /// The threshold in gray levels, 0 to 256: only smaller differences have a similarity above 0.
    #[must_use]
    #[inline]
    pub const fn threshold(&self) -> u16 {
        self.threshold
    }

    #[inline]
    #[allow(dead_code)] // some targets have no backend that needs it
    pub(super) const fn entries(&self) -> &[u16; ENTRIES] {
        &self.entries
    }

    #[cfg(any(smr_dsp, smr_helium))]
    #[inline]
    pub(super) const fn points(&self) -> &Points {
        &self.points
    }
}
