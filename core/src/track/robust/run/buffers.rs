//! Scratch memory of an update or a lock. Stages use it in turn: the filter, for example, borrows the extractor's sums.
//!
//! | stage | `extractor` | `large` | `responses` | `coded` | `sums` | `small` | `comparison` |
//! |---|---|---|---|---|---|---|---|
//! | begin | | | | writes the weights | | | measures the template |
//! | features | samples, sums cells | writes features | | | | | |
//! | response | lends its sums | reads | writes | reads | scratch | | |
//! | verification | samples the view | | | | | | writes |
//! | refinement | | | | | | | reads |
//! | scale | samples, lends its sums | | | reads | scratch; responses at a scale | features at a scale | |
//! | learning | lends its sums | reads | reads | writes the direction | errors, gradient | | |
//! | refiner | samples the crop | its patches and layers | | | | | |
//! | end of an update | | | | reads the direction | | | reads the view |
//! | lock: first crop | samples it | | | | | writes it, until the end of the lock | |
//!
//! Redetection and the refiner overwrite what learning reads, so they come after it. Redetection codes the weights again
//! if the refiner has refused a frame that was learned.

use super::super::constants::{CHANNELS, MAX_CELLS, MAX_SIDE, REACH, WEIGHTS};
use super::super::features::Extractor;
use super::super::filter::{Coded, Responses, Sums, scale};
use super::super::verification::Comparison;
use heapless::Vec;

/// Bytes of the largest search window: that of the longest filter, whose margin has the most cells.
const LARGE: usize = (MAX_SIDE + 2 * REACH) as usize * (MAX_CELLS / MAX_SIDE as usize + 2 * REACH as usize) * CHANNELS;

/// The scratch memory of the stages. The table of the [module](self) has the uses of each field.
// Keep this order: vectors after fields with padding. Otherwise an unoptimised build builds the value on the stack.
#[repr(C)]
pub(crate) struct Buffers {
    /// The features of a search window, or the refiner's patches and layers.
    pub(crate) large: Vec<i8, LARGE>,
    pub(crate) responses: Responses,
    /// The filter's coded weights, or the direction of the present step of learning.
    pub(crate) coded: Coded<WEIGHTS>,
    pub(crate) sums: Sums,
    /// The features at one scale, or the refiner's crop of the first frame.
    pub(crate) small: scale::Cells,
    pub(crate) extractor: Extractor,
    pub(crate) comparison: Comparison,
}

impl Buffers {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        // A constant, so that the extractor is not built on the stack.
        Self {
            extractor: const { Extractor::new() },
            large: Vec::new(),
            responses: Responses::new(),
            small: Vec::new(),
            coded: Coded::new(),
            sums: Sums::new(),
            comparison: Comparison::new(),
        }
    }
}
