//! Decides how often a bound is worth its time.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Decides how often a bound is computed. While it excludes nothing, it is computed less and less often, in the end one
/// time in 64. So a bound that never helps costs 1/64 of its time. The fields are atomic, so that a scorer can be
/// shared. No result depends on them.
pub(crate) struct Effort {
    /// How many more times to go on without the bound.
    without: AtomicU8,
    /// One set bit for each successive time that the bound excluded nothing, at most six.
    in_vain: AtomicU8,
}

impl Effort {
    #[allow(clippy::declare_interior_mutable_const)] // each use is a new one
    pub(crate) const NEW: Self = Self { without: AtomicU8::new(0), in_vain: AtomicU8::new(0) };

    /// True if the bound is to be computed this time.
    #[inline(always)]
    pub(crate) fn is_worth_it(&self) -> bool {
        let left = self.without.load(Relaxed).checked_sub(1);
        if let Some(without) = left {
            self.without.store(without, Relaxed);
        }
        left.is_none()
    }

    #[inline(always)]
    pub(crate) fn note(&self, excluded: bool) {
        let in_vain = if excluded { 0 } else { (self.in_vain.load(Relaxed) << 1 | 1) & 63 };
        self.in_vain.store(in_vain, Relaxed);
        self.without.store(in_vain, Relaxed);
    }
}
