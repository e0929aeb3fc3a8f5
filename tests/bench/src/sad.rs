//! A plain search to compare with: it finds the least sum of absolute differences (SAD) by trying every offset.
//!
//! [`Sad::Plain`] is the obvious loop, as the compiler optimises it. [`Sad::Psadbw`] is written for speed on x86-64: AVX2's
//! `vpsadbw`, 32 pixels at a time. It shares no code with smr-core's kernels, so that its time does not change when they do.
//! Both compare every pixel of every offset.

use smr_recordings::GrayFrame;

/// A way to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sad {
    Plain,
    Psadbw,
}

impl Sad {
    /// The ways that this machine can run.
    pub fn available() -> impl Iterator<Item = Self> {
        [Self::Plain, Self::Psadbw].into_iter().filter(|&sad| sad == Self::Plain || has_psadbw())
    }

    /// Column and row of the place of `template` in `crop` with the least sum, the first of equal ones; and the sum.
    pub fn search(self, crop: &GrayFrame, template: &GrayFrame) -> (usize, usize, u32) {
        match self {
            Self::Plain => least(crop, template, plain),
            Self::Psadbw => with_psadbw(crop, template),
        }
    }
}

/// The place where `distance` is least.
#[inline(always)] // into the function that has AVX2
fn least(crop: &GrayFrame, template: &GrayFrame, distance: impl Fn(Rows<'_>, Rows<'_>) -> u32) -> (usize, usize, u32) {
    let (width, height) = (usize::from(template.width), usize::from(template.height));
    let stride = usize::from(crop.width);
    let g = Rows { pixels: &template.pixels, stride: width, width, height };
    let mut best = (0, 0, u32::MAX);
    for y in 0..=usize::from(crop.height) - height {
        for x in 0..=stride - width {
            let f = Rows { pixels: &crop.pixels[y * stride + x..], stride, width, height };
            let sum = distance(f, g);
            if sum < best.2 {
                best = (x, y, sum);
            }
        }
    }
    best
}

#[derive(Clone, Copy)]
struct Rows<'a> {
    pixels: &'a [u8],
    stride: usize,
    width: usize,
    height: usize,
}

impl<'a> Rows<'a> {
    /// The same for templates of a width that is known at compile time.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn of_width(self, width: usize) -> Self {
        Self { width, ..self }
    }

    #[inline(always)] // into the function that has AVX2
    fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        self.pixels.chunks(self.stride).take(self.height).map(move |row| &row[..self.width])
    }
}

fn plain(f: Rows<'_>, g: Rows<'_>) -> u32 {
    let row = |(f, g): (&[u8], &[u8])| f.iter().zip(g).map(|(&f, &g)| u32::from(f.abs_diff(g))).sum::<u32>();
    f.iter().zip(g.iter()).map(row).sum()
}

#[cfg(target_arch = "x86_64")]
use psadbw::{has_psadbw, with_psadbw};

#[cfg(not(target_arch = "x86_64"))]
fn has_psadbw() -> bool {
    false
}

#[cfg(not(target_arch = "x86_64"))]
fn with_psadbw(crop: &GrayFrame, template: &GrayFrame) -> (usize, usize, u32) {
    least(crop, template, plain)
}

/// The whole search in one function for AVX2.
#[cfg(target_arch = "x86_64")]
mod psadbw {
    use super::{GrayFrame, Rows, least, plain};
    use pulp::x86::V3;
    use std::arch::x86_64::__m256i;

    pub(super) fn has_psadbw() -> bool {
        V3::try_new().is_some()
    }

    pub(super) fn with_psadbw(crop: &GrayFrame, template: &GrayFrame) -> (usize, usize, u32) {
        match V3::try_new() {
            Some(simd) => simd.vectorize(Search { simd, crop, template }),
            None => least(crop, template, plain),
        }
    }

    struct Search<'a> {
        simd: V3,
        crop: &'a GrayFrame,
        template: &'a GrayFrame,
    }

    impl pulp::NullaryFnOnce for Search<'_> {
        type Output = (usize, usize, u32);

        #[inline(always)] // pulp compiles for AVX2 what is inlined here
        fn call(self) -> Self::Output {
            let Self { simd, crop, template } = self;
            match template.width {
                64 => least(
                    crop,
                    template,
                    #[inline(always)]
                    |f, g| distance(simd, f.of_width(64), g.of_width(64)),
                ),
                _ => least(
                    crop,
                    template,
                    #[inline(always)]
                    |f, g| distance(simd, f, g),
                ),
            }
        }
    }

    #[inline(always)]
    fn distance(simd: V3, f: Rows<'_>, g: Rows<'_>) -> u32 {
        let mut sums = simd.avx._mm256_setzero_si256();
        let mut rest = 0;
        for (f, g) in f.iter().zip(g.iter()) {
            let ((f, f_rest), (g, g_rest)) = (f.as_chunks::<32>(), g.as_chunks::<32>());
            for (f, g) in f.iter().zip(g) {
                let (f, g): (__m256i, __m256i) = (pulp::cast(*f), pulp::cast(*g));
                sums = simd.avx2._mm256_add_epi64(sums, simd.avx2._mm256_sad_epu8(f, g));
            }
            rest += f_rest.iter().zip(g_rest).map(|(&f, &g)| u32::from(f.abs_diff(g))).sum::<u32>();
        }
        let sums: [u64; 4] = pulp::cast(sums);
        let sum: u64 = sums.iter().sum();
        rest + u32::try_from(sum).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_recordings::synthetic;

    #[test]
    fn all_ways_find_the_place_that_was_cut_out() {
        let crop = synthetic::frame(40);
        for (width, height) in [(64, 64), (51, 54), (24, 28), (1, 1), (33, 2)] {
            let (left, top) = (37, 11);
            let rect = smr_core::Rect::new(37, 11, width, height);
            let patch = crop.frame().patch(rect).unwrap();
            let mut pixels: Vec<u8> = patch.rows().flatten().copied().collect();
            if width > 1 {
                pixels[0] ^= 1;
            }
            let template = GrayFrame { width, height, pixels };
            for sad in Sad::available() {
                let found = sad.search(&crop, &template);
                let expected = if width > 1 { (left, top, 1) } else { Sad::Plain.search(&crop, &template) };
                assert_eq!(found, expected, "{sad:?}, {width}x{height}");
            }
        }
    }
}
