//! The budget of a step: how much work it may still do. A unit is about one instruction of a Cortex-M4, or for the
//! paper's tracker a comparison of two bytes.
//!
//! Every piece of work spends its units. The sum over all steps is only reported.

/// The work that the present step may still do, and that of all steps so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    granted: u32,
    /// Saturates.
    done: u32,
}

impl Budget {
    pub(super) const NOTHING: Self = Self { granted: 0, done: 0 };

    pub(super) const fn granted(&self) -> u32 {
        self.granted
    }

    pub(super) const fn done(&self) -> u32 {
        self.done
    }

    pub(super) const fn is_spent(&self) -> bool {
        self.granted == 0
    }

    /// Counts work done. It may exceed the grant, because a piece of work cannot be divided.
    #[cfg_attr(smr_small, inline(never))]
    pub(super) const fn spend(&mut self, work: u32) {
        self.granted = self.granted.saturating_sub(work);
        self.done = self.done.saturating_add(work);
    }

    /// Grants a step its work. 0 counts as 1, so that every step makes progress.
    pub(super) const fn grant(&mut self, work: u32) {
        self.granted = if work == 0 { 1 } else { work };
    }
}

/// A count as units of work.
pub(super) fn units(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// The largest of some amounts of work.
pub(super) const fn largest(of: &[u32]) -> u32 {
    let (mut rest, mut largest) = (of, 0);
    while let [work, others @ ..] = rest {
        largest = if *work > largest { *work } else { largest };
        rest = others;
    }
    largest
}
