//! Compares resampled rows.

use crate::kernels::plain::bilinear::{MixedRow, levels};

/// Checks the gray levels of columns.
#[track_caller]
pub(crate) fn mix(out: &[u8], from: &[u16], parts: &[[u16; 2]], row: &MixedRow) {
    for (number, (&out, wanted)) in out.iter().zip(levels(from, parts, row)).enumerate() {
        assert_eq!(out, wanted, "column {number}");
    }
}
