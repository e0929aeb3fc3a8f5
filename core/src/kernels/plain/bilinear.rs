//! Columns of a resampled row: each is interpolated from two neighbouring numbers of the row.

/// The number of places in a row where the first number of a column may be.
pub(crate) const PLACES: u16 = 512;

/// A row to interpolate: 256 times a gray level, less [`BIAS`] (in two's complement). One number may follow the last
/// place.
pub(crate) type MixedRow = [u16; PLACES as usize + 4];

/// The number that is subtracted from each number of a [`MixedRow`]: the DSP extension and Helium multiply signed
/// numbers.
pub(crate) const BIAS: u16 = if cfg!(any(smr_dsp, smr_helium)) { 1 << 15 } else { 0 };

/// Computes the rounded gray level of each column. `from` is the byte in the row where the column's first number
/// begins. `parts` are the weights of the first and of the second number, 256 in sum.
#[inline(always)]
pub(crate) fn levels(from: &[u16], parts: &[[u16; 2]], row: &MixedRow) -> impl Iterator<Item = u8> {
    from.iter().zip(parts).map(|(&from, parts)| {
        let pair = row.get(usize::from(from / 2)..).and_then(|row| row.first_chunk()).copied().unwrap_or([0; 2]);
        let [first, second] = pair.map(|number| u32::from(number.wrapping_add(BIAS)));
        let [rest, part] = parts.map(u32::from);
        let [_, _, level, _] = (first * rest + second * part + (1 << 15)).to_le_bytes();
        level
    })
}

/// Writes the [`levels`] of columns, up to the length of `out`.
#[inline(always)]
pub(crate) fn mix(from: &[u16], parts: &[[u16; 2]], row: &MixedRow, out: &mut [u8]) {
    out.iter_mut().zip(levels(from, parts, row)).for_each(|(out, level)| *out = level);
}
