//! Scratch memory of all stages.

use super::constants::{CHANNELS, MOST_CELLS, MOST_SIDE, REACH, WEIGHTS};
use super::gradients::Extractor;
use super::learning;
use super::response::Responses;
use super::scale;
use super::verification;
use crate::correlation::Coded;
use heapless::Vec;

/// Bytes of the largest search window: the longest filter has the longest margin.
const CELLS: usize =
    (MOST_SIDE + 2 * REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * REACH as usize) * CHANNELS;

/// What the stages fill and read.
// Fields with padding come before a vector. In the other order a build without optimisation builds the value on the
// stack and copies it.
#[repr(C)]
pub(super) struct Buffers {
    /// Features of the search window.
    pub(super) cells: Vec<i8, CELLS>,
    /// The filter's responses to them.
    pub(super) responses: Responses,
    /// The filter's weights; while it learns, the direction of its step.
    pub(super) coded: Coded<WEIGHTS>,
    pub(super) learning: learning::Scratch,
    /// Features at another scale.
    pub(super) scale_cells: scale::Cells,
    pub(super) extractor: Extractor,
    pub(super) verification: verification::Scratch,
}

impl Buffers {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        // Constants, so that they are not built on the stack.
        Self {
            extractor: const { Extractor::new() },
            cells: Vec::new(),
            responses: Responses::new(),
            scale_cells: Vec::new(),
            coded: Coded::new(),
            learning: learning::Scratch::new(),
            verification: verification::Scratch::new(),
        }
    }
}
