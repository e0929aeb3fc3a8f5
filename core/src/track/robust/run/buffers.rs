//! The memory of all stages in one frame. Stages share it, one after the other:
//!
//! | stage | `extractor` | `large` | `responses` | `coded` | `sums` | `small` | `comparison` |
//! |---|---|---|---|---|---|---|---|
//! | begin | | | | writes the weights | | | measures the template |
//! | features | samples, sums cells | writes features | | | | | |
//! | response | lends its sums | reads | writes | reads | spare | | |
//! | verification | samples the view | | | | | | writes |
//! | refinement | | | | | | | reads |
//! | scale | samples, lends its sums | | | reads | spare; responses at a scale | features at a scale | |
//! | learning | lends its sums | reads | reads | writes the direction | errors, gradient | | |
//! | refiner | samples the crop | its patches and layers | | | | | |
//! | end of an update | | | | reads the direction | | | reads the view |
//! | lock: first crop | samples it | | | | | writes it, until the end of the lock | |
//!
//! Redetection writes over `large`, `responses` and `comparison`; then nothing is learned.

use super::super::constants::{CHANNELS, MOST_CELLS, MOST_SIDE, REACH, WEIGHTS};
use super::super::features::Extractor;
use super::super::filter::{Coded, Responses, Sums, scale};
use super::super::verification::Comparison;
use heapless::Vec;

/// Bytes of the largest search window: the longest filter has the longest margin.
const LARGE: usize =
    (MOST_SIDE + 2 * REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * REACH as usize) * CHANNELS;

/// The memory that the stages fill and read. The [module](self) says which stage uses it when.
// Fields with padding come before a vector. In the other order a build without optimisation builds the value on the
// stack and copies it.
#[repr(C)]
pub(crate) struct Buffers {
    /// Bytes for the features of a search window, or for the refiner.
    pub(crate) large: Vec<i8, LARGE>,
    /// The filter's responses to the features in `large`.
    pub(crate) responses: Responses,
    /// The filter's weights, coded; during a step of learning, from its direction on, that direction.
    pub(crate) coded: Coded<WEIGHTS>,
    pub(crate) sums: Sums,
    /// Bytes for the features at one scale, or for the refiner's first crop.
    pub(crate) small: scale::Cells,
    pub(crate) extractor: Extractor,
    pub(crate) comparison: Comparison,
}

impl Buffers {
    #[inline(always)]
    pub(crate) const fn new() -> Self {
        // The extractor is a constant, so that it is not built on the stack.
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
