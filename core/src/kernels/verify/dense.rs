//! Compares layers of a small network.

use crate::kernels::plain::dense::{self as plain, Layer};

/// Checks the outputs of a layer. Bytes that are no output are as before.
#[track_caller]
pub(crate) fn outputs(out: &[i8], before: &mut heapless::Vec<i8, 1024>, layer: Layer<'_>, patches: &[i8]) {
    plain::outputs(layer, patches, &mut [], before);
    assert_eq!(out, &**before, "outputs of a layer, given and expected");
}
