//! Sums over the gray levels of a row, and the replacement of a row: the plain loops.

use super::super::unrolling::rolled;

/// The sum of the differences of `pixels` from `level`, and the number of pixels at 0 or 255. The sum fits for at most
/// 65537 pixels.
#[inline(always)]
pub(crate) fn deviation(pixels: &[u8], level: u8) -> [u32; 2] {
    let (mut deviation, mut clipped) = (0, 0);
    for part in pixels.chunks(PART) {
        // One pass computes both: the upper 16 bits count clipped pixels, the lower 16 bits sum deviations.
        let sums = rolled(part.iter())
            .map(|&pixel| u32::from(pixel.abs_diff(level)) + (u32::from(pixel.wrapping_add(1) < 2) << 16))
            .sum::<u32>();
        deviation += sums & 0xffff;
        clipped += sums >> 16;
    }
    [deviation, clipped]
}

/// The pixels whose deviations are summed in 16 bits: 257 * 255 is the most that these can hold.
const PART: usize = 257;

/// Replaces `old` by as many pixels of `new`. Returns the largest of `largest` and the differences of the pixels.
#[inline(always)]
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    // Two loops, so that the compiler vectorizes both.
    let largest = rolled(old.iter().zip(new)).fold(largest, |largest, (old, &new)| largest.max(old.abs_diff(new)));
    rolled(old.iter_mut().zip(new)).for_each(|(old, &new)| *old = new);
    largest
}
