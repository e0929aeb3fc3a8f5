//! Layers of a small network: chooses the loop of a backend.
//!
//! The DSP extension adds two products in an instruction, Helium sixteen. For AVX2 the plain loop is compiled with its
//! instructions. All other backends use the plain loop as it is; the compiler vectorizes it for SSE2, NEON and SIMD128.

#[cfg(smr_dsp)]
use super::arm::dsp::dense as dsp;
#[cfg(smr_helium)]
use super::arm::helium::dense as helium;
use super::backend::Backend;
use super::plain::dense as plain;
use super::plain::dense::Layer;
#[cfg(target_arch = "x86_64")]
use super::x86::avx2::dense as avx2;

/// Bytes of scratch memory with which every backend is fastest: the DSP extension unpacks two patches of up to 216
/// inputs to words. With less memory it takes one patch at a time.
pub(crate) const SPARE: usize = 4 * 216 + 3;

/// Layers by a backend. All backends give the same integers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dense(Backend);

impl Dense {
    /// The layers by `backend`, or by the plain loop if the machine does not have it.
    pub(crate) fn new(backend: Backend) -> Self {
        Self(if backend.is_available() { backend } else { Backend::Scalar })
    }

    /// See [`plain::outputs`]. `patches` has `layer.inputs` numbers for each patch, `out` one for each of its outputs.
    /// `spare` is scratch memory: see [`SPARE`].
    #[inline(never)]
    pub(crate) fn outputs(self, layer: Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
        #[cfg(not(smr_dsp))]
        let _ = spare;
        // The bytes that a backend does not write must stay.
        #[cfg(any(test, feature = "verify"))]
        let mut expected: heapless::Vec<i8, 1024> = out.iter().copied().collect();
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `new` has checked that the machine has AVX2.
            Backend::Avx2 => unsafe { avx2::outputs(layer, patches, out) },
            #[cfg(smr_dsp)]
            Backend::Dsp => dsp::outputs(layer, patches, spare, out),
            #[cfg(smr_helium)]
            Backend::Helium => helium::outputs(layer, patches, out),
            _ => plain::outputs(layer, patches, out),
        }
        #[cfg(any(test, feature = "verify"))]
        {
            plain::outputs(layer, patches, &mut expected);
            assert_eq!(out, &*expected, "outputs of a layer, given and expected");
        }
    }

    /// The sums of one patch, before the shift. It serves the last layer, which is small, and always uses the plain
    /// loop.
    pub(crate) fn sums<const N: usize>(layer: Layer<'_>, patch: &[i8]) -> [i32; N] {
        core::array::from_fn(|output| plain::sum(layer, output, patch))
    }
}
