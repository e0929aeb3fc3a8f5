//! The measure of a filter: its responses to a window of cells, and the gradient of its error.
//!
//! ```text
//! response   r[d]    = sum over cells c and channels k of  w[c, k] * x[c + d, k]
//! gradient   g[c, k] = sum over offsets d of               e[d] * x[c + d, k]
//! ```
//!
//! | symbol | what | unit | bound |
//! |---|---|---|---|
//! | `x` | feature | 1/127 | -128 to 127 |
//! | `w` | coded weight ([`Coded`]) | 2^shift of a weight's 2^-16 / 16384 | +-8191 |
//! | `r` | response | 1/16384 of the label | +-2^24 |
//! | `e` | coded error | 2^shift / 16384 | +-16,383 |
//!
//! At most 2000 weights and 289 offsets keep every sum below 2^31: 2000 * 8191 * 128 and 289 * 16,383 * 128.
//! Cost: one product for each weight and offset.

mod coded;
mod filter;

pub(crate) use coded::{Coded, LARGEST, shift_below};
pub(crate) use filter::Filter;

use crate::kernels::{Layout, Packed, Products};

/// Cells, and the layout of the filter on them.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a> {
    pub(crate) cells: &'a [i8],
    pub(crate) layout: Layout,
}

/// Adds one piece of the gradient. Returns true after the last piece. `packed` and `spare` are scratch memory.
pub(crate) fn add_gradient<const S: usize>(
    products: Products,
    packed: &mut Packed,
    spare: &mut [i32],
    Window { cells, layout }: Window<'_>,
    errors: &[[i16; S]],
    piece: usize,
    gradient: &mut [i32],
) -> bool {
    products.gather(piece..piece + 1, packed, spare, cells, layout, errors, gradient);
    piece + 1 >= products.gather_parts(layout, gradient.len())
}
