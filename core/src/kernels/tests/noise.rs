//! Numbers for tests of kernels.

use crate::kernels::verify::extremes::noise::Noise;
use core::fmt::Debug;

/// Numbers from `-most` to `most` that look random, the same in every run.
pub(super) fn noise<T: TryFrom<i32, Error: Debug>>(count: usize, seed: u32, most: u32) -> impl Iterator<Item = T> {
    let mut noise = Noise::new(seed);
    core::iter::repeat_with(move || T::try_from(noise.next(most)).unwrap()).take(count)
}
