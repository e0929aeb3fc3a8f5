//! CRC-32 (the one of Ethernet and zip), the checksum of saved targets and flight records.
//!
//! It processes four bits at a time with a table of 64 bytes: 120 bytes of flash, where usual crates take 1.5 KB.

/// Entry i: the CRC register after four one-bit steps from the value i. A step shifts the register right, then XORs the
/// polynomial if it shifted out a 1.
#[allow(clippy::indexing_slicing)] // evaluated at compile time
const TABLE: [u32; 16] = {
    let mut table = [0; 16];
    let mut bits = 0_u32;
    while bits < 16 {
        let mut sum = bits;
        let mut bit = 0;
        while bit < 4 {
            sum = (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg());
            bit += 1;
        }
        table[bits as usize] = sum;
        bits += 1;
    }
    table
};

#[derive(Clone, Copy)]
pub(super) struct Crc(u32);

impl Crc {
    pub(super) const fn new() -> Self {
        Self(u32::MAX)
    }

    #[inline(never)]
    #[allow(clippy::indexing_slicing)] // four bits are always a valid index into 16 entries
    pub(super) fn update(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 ^= u32::from(byte);
            for _ in 0..2 {
                self.0 = (self.0 >> 4) ^ TABLE[(self.0 & 15) as usize];
            }
        }
    }

    pub(super) const fn finish(self) -> u32 {
        !self.0
    }

    pub(super) fn of(bytes: &[u8]) -> u32 {
        let mut crc = Self::new();
        crc.update(bytes);
        crc.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::Crc;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_checksum_of_ethernet(bytes in prop::collection::vec(any::<u8>(), 0..300), cut in 0usize..300) {
            let known = crc32fast::hash(&bytes);
            prop_assert_eq!(Crc::of(&bytes), known);
            let (first, rest) = bytes.split_at(cut.min(bytes.len()));
            let mut parts = Crc::new();
            parts.update(first);
            parts.update(rest);
            prop_assert_eq!(parts.finish(), known);
        }
    }
}
