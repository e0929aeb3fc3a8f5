//! Layers of a small network: chooses the loop of a backend.
//!
//! The DSP extension adds two products in an instruction, Helium sixteen. For AVX2 the plain loop is compiled with its
//! instructions. All other backends use the plain loop as it is; the compiler vectorizes it for x86-64, NEON and SIMD128.

use super::backend::{Backend, by_backend};
use super::plain::dense as plain;
use super::plain::dense::Layer;

/// Bytes of scratch memory with which every backend is fastest: the DSP extension unpacks two patches of up to 216
/// inputs to words. With less memory it takes one patch at a time.
pub(crate) const SPARE: usize = 4 * 216 + 3;

/// Layers by a backend. All backends give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dense(Backend);

impl Dense {
    /// The layers by `backend`, or by the plain loop if the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(backend.or_scalar())
    }

    /// See [`plain::outputs`]. `patches` has `layer.inputs` numbers for each patch, `out` one for each of its outputs.
    /// `spare` is scratch memory: see [`SPARE`].
    #[inline(never)]
    pub(crate) fn outputs(self, layer: Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
        // SAFETY: `new` has checked that the machine has the instruction set.
        #[allow(unused_unsafe)] // most sets need no check
        unsafe {
            by_backend!(self.0, set => set::dense::outputs(layer, patches, spare, out));
        }
    }

    /// The sums of one patch, before the shift. It serves the last layer, which is small, and always uses the plain
    /// loop.
    pub(crate) fn sums<const N: usize>(layer: Layer<'_>, patch: &[i8]) -> [i32; N] {
        core::array::from_fn(|output| plain::sum(layer, output, patch))
    }
}
