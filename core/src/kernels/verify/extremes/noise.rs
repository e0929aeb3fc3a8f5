//! The numbers that kernels are compared with.

/// Numbers from `-most` to `most` that look random, the same in every run.
pub(in crate::kernels) struct Noise(u32);

impl Noise {
    pub(in crate::kernels) fn new(seed: u32) -> Self {
        Self(seed | 1)
    }

    pub(in crate::kernels) fn next(&mut self, most: u32) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        ((self.0 >> 7) % (2 * most + 1)).cast_signed() - most.cast_signed()
    }
}
