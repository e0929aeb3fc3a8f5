//! Layout of picture rows in words of four pixels, for the loops of the DSP extension.

use crate::kernels::rows::Rows;

pub(super) const LANES: usize = 4;

pub(super) fn in_lanes(byte: u8) -> u32 {
    u32::from_ne_bytes([byte; LANES])
}

/// Constants that each loop over rows reads from memory. The assembly depends on their offsets.
#[repr(C)]
pub(super) struct WordRow {
    /// Bytes from the end of the whole words of a row to the next row, in the patch and in the template.
    f_stride: usize,
    g_stride: usize,
    /// Offset of the word whose upper part holds the columns after the last whole word; 0 if there are none.
    last: usize,
    /// Number of low bits in the word at `last` that belong to earlier columns.
    pub(super) skipped_bits: u32,
    end: *const u8,
}

impl WordRow {
    /// Returns the layout of the rows of `pair`, two pictures with at least four columns.
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // a word has 32 bits
    pub(super) fn of(pair: &Rows) -> Self {
        let (words, left) = (words(pair), pair.width % LANES);
        Self {
            f_stride: pair.patch_stride.wrapping_sub(words),
            g_stride: pair.template_stride.wrapping_sub(words),
            last: if left == 0 { 0 } else { pair.width - LANES },
            skipped_bits: 8 * (LANES - left) as u32,
            end: pair.template.wrapping_add(pair.height.wrapping_mul(pair.template_stride)),
        }
    }
}

/// Bytes in the whole words of a row.
#[inline(always)]
pub(super) fn words(pair: &Rows) -> usize {
    pair.width - pair.width % LANES
}

/// Bytes of code to skip in the first round of a loop that is unrolled to four words, with `bytes` of code for each
/// word. So if the word count is no multiple of 4, the first round processes its remainder modulo 4.
#[inline(always)]
pub(super) fn entry_offset(pair: &Rows, bytes: usize) -> usize {
    (pair.width / LANES).wrapping_neg() % 4 * bytes
}
