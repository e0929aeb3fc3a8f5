//! Scratch memory of all stages.
//!
//! Stages share memory:
//!
//! | memory | contents |
//! |---|---|
//! | `cells` | features of the search window; then those of redetection's, or the refiner's patches and layers |
//! | `responses` | responses to `cells`; learning reads them |
//! | `coded` | the filter's weights; from the direction of a step of learning on, that direction |
//! | `learning.gradient` | scratch memory of responses; in learning, the gradient |
//! | `learning.responses` | responses at one scale; in learning, errors, scratch memory, responses to the direction |
//! | `scale_cells` | features at one scale; in a lock, the refiner's first crop until the end of the lock |
//! | `extractor` | sampling of windows, views, crops; sums of cells; between windows, unpacked bytes for products |
//! | `verification` | the view, and the relit template; at the end, the early template learns from the view |

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

/// The memory that the stages fill and read. The [module](self) says which stage uses it when.
// Fields with padding come before a vector. In the other order a build without optimisation builds the value on the
// stack and copies it.
#[repr(C)]
pub(super) struct Buffers {
    /// Features of the present window.
    pub(super) cells: Vec<i8, CELLS>,
    /// The filter's responses to `cells`.
    pub(super) responses: Responses,
    /// The filter's weights, coded; during a step of learning, from its direction on, that direction.
    pub(super) coded: Coded<WEIGHTS>,
    pub(super) learning: learning::Scratch,
    /// Features at one scale of the scale search.
    pub(super) scale_cells: scale::Cells,
    pub(super) extractor: Extractor,
    pub(super) verification: verification::Scratch,
}

impl Buffers {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        // The extractor is a constant, so that it is not built on the stack.
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
