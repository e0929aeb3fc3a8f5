//! Plain loops on the gray levels of a row: bilinear sampling, deviation from a level, replacement by new levels.

use super::super::unrolling::rolled;

/// The sum of absolute differences of `pixels` from `level`, and the number of clipped pixels (0 or 255).
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

/// Maximum number of pixels whose sum of deviations surely fits in 16 bits: 257 * 255 = 65535.
const PART: usize = 257;

/// Copies `new` over `old`. Returns the maximum of `largest` and the absolute differences of the pixels.
#[inline(always)]
pub(crate) fn replace(old: &mut [u8], new: &[u8], largest: u8) -> u8 {
    // Two loops, so that the compiler vectorizes both.
    let largest = rolled(old.iter().zip(new)).fold(largest, |largest, (old, &new)| largest.max(old.abs_diff(new)));
    rolled(old.iter_mut().zip(new)).for_each(|(old, &new)| *old = new);
    largest
}

/// Number of row positions that can be the left sample of an output column. The right sample is one position further.
pub(crate) const LEFT_SAMPLES: u16 = 512;

/// A row of gray levels to sample, as 256 * level - [`BIAS`] in two's complement, with room for the last right sample.
pub(crate) type MixedRow = [u16; LEFT_SAMPLES as usize + 4];

/// Weights of a column's left and right sample, 256 in sum. The assembly loads them as an aligned word.
#[derive(Clone, Copy)]
#[repr(align(4))]
pub(crate) struct SampleWeights(pub(crate) [u16; 2]);

/// Subtracted from each number of a [`MixedRow`], because the DSP extension and Helium multiply signed numbers.
pub(crate) const BIAS: u16 = if cfg!(any(smr_dsp, smr_helium)) { 1 << 15 } else { 0 };

/// Computes the rounded gray level of each column. `from` holds the byte offsets of the left samples in `row`.
#[inline(always)]
fn mixed(from: &[u16], parts: &[SampleWeights], row: &MixedRow) -> impl Iterator<Item = u8> {
    from.iter().zip(parts).map(|(&from, parts)| {
        let pair = row.get(usize::from(from / 2)..).and_then(|row| row.first_chunk()).copied().unwrap_or([0; 2]);
        let [first, second] = pair.map(|number| u32::from(number.wrapping_add(BIAS)));
        let [rest, part] = parts.0.map(u32::from);
        let [_, _, level, _] = (first * rest + second * part + (1 << 15)).to_le_bytes();
        level
    })
}

#[inline(always)]
pub(crate) fn mix(from: &[u16], parts: &[SampleWeights], row: &MixedRow, out: &mut [u8]) {
    out.iter_mut().zip(mixed(from, parts, row)).for_each(|(out, level)| *out = level);
}
