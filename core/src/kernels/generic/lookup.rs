//! The similarity table in registers.

use super::vector::Vector;
use crate::kernels::cut_table::CutTable;
use crate::kernels::scores::Effort;
use core::marker::PhantomData;

/// A similarity table in registers, with zeroes from the threshold on.
pub(crate) trait LookUp {
    type Vector: Vector;

    /// Returns the low bytes and the high bytes of the table entries for the lanes of `difference`.
    fn look_up(&self, difference: Self::Vector) -> (Self::Vector, Self::Vector);
}

/// Table entries below the threshold as two byte planes (low, high). Each plane consists of segments of `SEGMENT`
/// entries, because a lookup instruction covers no more.
pub(crate) struct Lookup<V, const SEGMENT: usize, const SEGMENTS: usize> {
    pub(crate) low: [[u8; SEGMENT]; SEGMENTS],
    pub(crate) high: [[u8; SEGMENT]; SEGMENTS],
    pub(crate) segments: usize,
    /// The largest difference below the threshold, if there is one.
    pub(crate) last: Option<u8>,
    pub(crate) candidates: Effort,
    vector: PhantomData<V>,
}

impl<V, const SEGMENT: usize, const SEGMENTS: usize> Lookup<V, SEGMENT, SEGMENTS> {
    /// # Safety
    /// The processor has the instruction set of `V`.
    pub(crate) unsafe fn new(table: &CutTable) -> Self {
        let threshold = table.threshold();
        let (mut low, mut high) = ([[0; SEGMENT]; SEGMENTS], [[0; SEGMENT]; SEGMENTS]);
        let places = low.as_flattened_mut().iter_mut().zip(high.as_flattened_mut());
        // Entries from the threshold on are 0.
        let filled = if cfg!(smr_small) { table.entries().len() } else { threshold.into() };
        for ((low, high), entry) in places.zip(table.entries()).take(filled) {
            [*low, *high] = entry.to_le_bytes();
        }
        let segments = usize::from(threshold).div_ceil(SEGMENT).max(1);
        let last = threshold.checked_sub(1).and_then(|last| u8::try_from(last).ok());
        Self { low, high, segments, last, candidates: Effort::NEW, vector: PhantomData }
    }
}
