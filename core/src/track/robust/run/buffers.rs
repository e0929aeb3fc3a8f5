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

use super::super::constants::{CHANNELS, Limits, MAX_SIDE};
use super::super::features::Extractor;
use super::super::filter::{Coded, Responses, Sums};
use super::super::verification::{Comparison, Measures};
use heapless::{Vec, VecView};

/// Bytes of the largest search window: that of the longest filter, whose margin has the most cells.
pub(super) const fn most_bytes(Limits { cells, reach, .. }: Limits) -> usize {
    (MAX_SIDE + 2 * reach) as usize * (cells / MAX_SIDE + 2 * reach) as usize * CHANNELS
}

/// The scratch memory of the stages, of any size. The table of the [module](self) has the uses of each field.
pub(crate) struct Buffers<'a> {
    /// The features of a search window, or the refiner's patches and layers.
    pub(crate) large: &'a mut VecView<i8>,
    pub(crate) responses: &'a mut Responses,
    /// The filter's coded weights, or the direction of the present step of learning.
    pub(crate) coded: &'a mut Coded,
    pub(crate) sums: &'a mut Sums,
    /// The features at one scale, or the refiner's crop of the first frame.
    pub(crate) small: &'a mut VecView<i8>,
    pub(crate) extractor: &'a mut Extractor,
    pub(crate) comparison: Comparison<'a>,
}

/// The memory behind [`Buffers`], in vectors of one size.
// Keep this order: vectors after fields with padding. Otherwise an unoptimised build builds the value on the stack.
#[repr(C)]
pub(crate) struct Scratch<
    const WEIGHTS: usize,
    const PIXELS: usize,
    const LARGE: usize,
    const SMALL: usize,
    const VIEW: usize,
> {
    large: Vec<i8, LARGE>,
    responses: Responses,
    coded: Coded<Vec<i16, WEIGHTS>>,
    sums: Sums<[i32; WEIGHTS]>,
    small: Vec<i8, SMALL>,
    extractor: Extractor,
    measures: Measures,
    view: Vec<u8, VIEW>,
    relit: Vec<u8, PIXELS>,
}

impl<const WEIGHTS: usize, const PIXELS: usize, const LARGE: usize, const SMALL: usize, const VIEW: usize>
    Scratch<WEIGHTS, PIXELS, LARGE, SMALL, VIEW>
{
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
            measures: Measures::new(),
            view: Vec::new(),
            relit: Vec::new(),
        }
    }

    pub(crate) fn buffers(&mut self) -> Buffers<'_> {
        let Self { large, responses, coded, sums, small, extractor, measures, view, relit } = self;
        Buffers { large, responses, coded, sums, small, extractor, comparison: Comparison { measures, view, relit } }
    }
}
