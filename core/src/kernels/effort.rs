//! How often a bound is worth its time.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// How often a bound is computed: while it excludes nothing, less and less often; in the end one time in 64. So bounds in vain cost 1/64 of
/// their time. The fields are atomic, so that a scorer can be shared; no result depends on them.
pub(crate) struct Effort {
    /// How often to go on without the bound.
    without: AtomicU8,
    /// One set bit for each successive time that the bound excluded nothing.
    in_vain: AtomicU8,
}

impl Effort {
    #[allow(clippy::declare_interior_mutable_const)] // each use is a new one
    pub(crate) const NEW: Self = Self { without: AtomicU8::new(0), in_vain: AtomicU8::new(0) };

    /// Whether to compute the bound this time.
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
