//! The paper's table for tests of kernels, which must not depend on `similarity`.

use crate::kernels::cut_table::CutTable;
use crate::kernels::one::ONE;

/// 65535 * exp(-difference / 255), rounded.
pub(in crate::kernels) fn similarity(difference: u8) -> u16 {
    (f64::from(ONE) * (-f64::from(difference) / 255.0).exp()).round() as u16
}

/// The paper's table, cut off at a threshold.
pub(in crate::kernels) fn cut(threshold: u16) -> CutTable {
    let mut cut = CutTable::EMPTY;
    cut.cut(&core::array::from_fn(|difference| similarity(difference as u8)), threshold);
    cut
}
