//! Bilinear sampling of a row with one product for each column. `deviation` and `replace` are the plain functions.

use crate::kernels::plain::levels::{MixedRow, SampleWeights};
use crate::kernels::unrolling::rolled;

pub(crate) use crate::kernels::plain::levels::{deviation, replace};

/// # Safety
/// Each number in `from` is even, and less than twice [`LEFT_SAMPLES`](crate::kernels::plain::levels::LEFT_SAMPLES).
#[inline(never)]
pub(crate) unsafe fn mix(from: &[u16], parts: &[SampleWeights], row: &MixedRow, out: &mut [u8]) {
    for (out, (&from, &SampleWeights([_, part]))) in rolled(out.iter_mut().zip(from.iter().zip(parts))) {
        let pair = row.as_ptr().wrapping_byte_add(from.into());
        // SAFETY: `from` is an even offset below 2 * `LEFT_SAMPLES`, so the row has a number there and one after it.
        let [first, second] = [pair, pair.wrapping_add(1)].map(|number| u32::from(unsafe { *number }));
        // The left sample's weight is 256 - part, so one product suffices. Wrapping cancels out.
        let level =
            (first << 8).wrapping_add(second.wrapping_sub(first).wrapping_mul(part.into())).wrapping_add(1 << 15);
        [_, _, *out, _] = level.to_le_bytes();
    }
}
