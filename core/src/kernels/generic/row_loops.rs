//! Constants of the loops over the rows of a picture, and over the vectors of a row.

use super::vector::Vector;

/// Rows between two checks whether the score can still reach the floor.
pub(super) const ROWS_A_LOOK: usize = 8;

/// Value of the const parameter `WHOLE` (whole vectors in a row) in a loop that supports every number of vectors but 0.
pub(crate) const ANY: usize = usize::MAX;

/// Evaluates `$call` with two constants for rows of `$width` pixels: `WHOLE`, the number of whole vectors in a row, and
/// `END`, true if pixels follow after the whole vectors.
macro_rules! by_width {
    ($width:expr, $vector:ty, $call:expr) => {{
        use $crate::kernels::generic::{ANY, Vector};
        let width = $width;
        match (width / <$vector>::LANES, width.is_multiple_of(<$vector>::LANES)) {
            (0, _) => by_width!(@ 0, true, $call),
            #[cfg(not(smr_small))]
            (1, true) => by_width!(@ 1, false, $call),
            #[cfg(not(smr_small))]
            (1, false) => by_width!(@ 1, true, $call),
            #[cfg(not(smr_small))]
            (2, true) => by_width!(@ 2, false, $call),
            (_, true) => by_width!(@ ANY, false, $call),
            (_, false) => by_width!(@ ANY, true, $call),
        }
    }};
    (@ $whole:expr, $end:expr, $call:expr) => {{
        const WHOLE: usize = $whole;
        const END: bool = $end;
        $call
    }};
}

pub(crate) use by_width;

/// Number of pixels in the whole vectors of a row.
#[inline(always)]
pub(super) fn whole<V: Vector, const WHOLE: usize>(width: usize) -> usize {
    if WHOLE == ANY { width / V::LANES * V::LANES } else { WHOLE * V::LANES }
}
