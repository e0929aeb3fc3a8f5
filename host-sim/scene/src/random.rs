//! Random numbers for scenes and for simulated camera faults and covered lenses, equal on every machine.

/// The generator SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// Returns a random number from 0 to `end - 1`; 0 if `end` is not positive.
    pub fn below(&mut self, end: i64) -> i64 {
        let product = u128::from(self.next()) * u128::from(end.max(0).cast_unsigned());
        i64::try_from(product >> 64).unwrap_or(0)
    }

    pub fn place(&mut self, entries: usize) -> usize {
        let product = u128::from(self.next()) * entries as u128;
        usize::try_from(product >> 64).unwrap_or(0)
    }

    #[allow(clippy::should_implement_trait)] // it never ends
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// Returns nearly normal noise of standard deviation 2.3: (sum of four uniform bytes - mean of the sum) / 64.
    pub fn noise(&mut self) -> i32 {
        let [a, b, c, d, ..] = self.next().to_le_bytes().map(i32::from);
        (a + b + c + d - 4 * 255 / 2 + 32) >> 6
    }
}
