//! Memory with test data: areas with pictures at an edge, noise, and the panic of a difference.

use crate::image::Image;
use crate::kernels::backend::Backend;
use core::fmt::Debug;

/// Size in bytes of each memory area in [`Areas`].
pub const ROOM: usize = 64 * 1024;

/// Miri is thousands of times slower: there only every 29th case is compared.
pub(super) const STEP: usize = if cfg!(miri) { 29 } else { 1 };

/// Memory areas with test pictures at one edge. If memory beyond it is inaccessible, reads beyond a picture fault.
#[derive(Debug)]
pub struct Areas<'a> {
    /// An area with pictures at its end, after which memory is inaccessible.
    pub end: &'a mut [u8],
    /// A second area with pictures at its end, before inaccessible memory.
    pub other_end: &'a mut [u8],
    /// An area with pictures at its start, before which memory is inaccessible.
    pub start: &'a mut [u8],
}

/// Pseudo-random numbers, the same in every run.
pub(super) struct Noise(pub(super) u32);

impl Noise {
    pub(super) fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// A number from `-most` to `most`.
    pub(super) fn next(&mut self, most: u32) -> i32 {
        ((self.bits() >> 7) % (2 * most + 1)).cast_signed() - most.cast_signed()
    }

    /// A gray level from `level` to `level + most - 1`, modulo 256.
    pub(super) fn near(&mut self, level: u8, most: u8) -> u8 {
        level.wrapping_add((self.bits() >> 9) as u8 % most)
    }
}

/// Fills the areas with noise, for differences below and above a threshold. Bytes of `end` and of another area at the
/// same index differ by at most 64 (modulo 256); about a fifth of `start` differs by any amount.
pub(super) fn fill(areas: &mut Areas<'_>) {
    let mut noise = Noise(1);
    for ((first, second), third) in areas.end.iter_mut().zip(&mut *areas.other_end).zip(&mut *areas.start) {
        let [base, offset, other, sign] = noise.bits().to_le_bytes();
        let [near, far] =
            [offset % (2 + other % 64), other].map(|by| if sign & 1 == 0 { by } else { by.wrapping_neg() });
        *first = base;
        *second = base.wrapping_add(near);
        *third = if sign > 200 { base.wrapping_add(far) } else { base.wrapping_sub(near) };
    }
}

pub(super) fn part(memory: &[u8], last: bool, length: usize) -> &[u8] {
    if last { &memory[memory.len() - length..] } else { &memory[..length] }
}

pub(super) fn part_mut(memory: &mut [u8], last: bool, length: usize) -> &mut [u8] {
    let from = if last { memory.len() - length } else { 0 };
    &mut memory[from..][..length]
}

pub(super) fn signed(bytes: &[u8]) -> &[i8] {
    // SAFETY: an i8 is as large and as aligned as a u8, and all values are valid.
    unsafe { core::slice::from_raw_parts(bytes.as_ptr().cast(), bytes.len()) }
}

pub(super) fn picture(memory: &[u8], last: bool, (width, height): (u16, u16), stride: usize) -> Image<'_> {
    let bytes = usize::from(height - 1) * stride + usize::from(width);
    Image::with_stride(part(memory, last, bytes), width, height, stride).unwrap()
}

#[track_caller]
pub(super) fn check(right: bool, what: &str, backend: Backend, case: impl Debug) {
    assert!(right, "{backend:?}: {what}: {case:?}");
}
