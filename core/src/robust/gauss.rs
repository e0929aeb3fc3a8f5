//! exp(-t^2 / 2) for the labels, computed at compile time.

/// In units of 1/16384; t in units of 1/32.
pub(super) const TABLE: [u16; 160] = table();

#[allow(clippy::indexing_slicing, clippy::cast_possible_truncation)] // t < 160; every entry is at most 2^14
const fn table() -> [u16; 160] {
    // With q = exp(-1/2048): q^(t^2), from one to the next by q^(2t + 1).
    const ONE: u128 = 1 << 60;
    const Q: u128 = ONE - (1 << 49) + (1 << 37) - (1 << 26) / 3 ;
    let mut entries = [0; 160];
    let (mut value, mut odd) = (ONE, Q);
    let mut t = 0;
    while t < 160 {
        entries[t] = ((value + (1 << 45)) >> 46) as u16;
        value = (value * odd) >> 60;
        odd = (odd * ((Q * Q) >> 60)) >> 60;
        t += 1;
    }
    entries
}
