//! Every backend against `scalar.rs`: one macro stamps the same tests on each.

use super::{Backend, Scorer};
use crate::image::Image;
use crate::similarity::{Table, scalar};
use std::vec::Vec;
use std::{boxed::Box, println};

/// Bytes that look random, the same in every run.
fn noise(length: usize, seed: u32) -> Box<[u8]> {
    let mut state = seed | 1;
    let next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 24) as u8
    };
    core::iter::repeat_with(next).take(length).collect()
}

/// A template for `patch`: close to it, so that differences lie on both sides of any threshold.
fn close_to(patch: &[u8], seed: u32) -> Box<[u8]> {
    let noise = noise(patch.len(), seed);
    patch.iter().zip(&noise).map(|(&pixel, &noise)| pixel.wrapping_add(noise % 80)).collect()
}

#[track_caller]
fn same(backend: Backend, patch: Image<'_>, template: Image<'_>, threshold: u16) {
    let expected = scalar::score(patch, template, &Table::PAPER, threshold);
    let score = Scorer::new(backend, &Table::PAPER, threshold).score(patch, template);
    assert_eq!(score, expected, "{backend:?}: {patch:?}, {template:?}, threshold {threshold}");
}

/// All sizes up to 70 by 70. The slices end with the last pixel and are allocations of their own, so that a tool that
/// watches memory sees a byte too many being read.
fn all_sizes(backend: Backend) {
    for width in 1..=70u16 {
        for height in 1..=70u16 {
            let patch = noise(usize::from(width) * usize::from(height), u32::from(width * 71 + height));
            let template = close_to(&patch, 7);
            let view = |pixels| Image::new(pixels, width, height).unwrap();
            same(backend, view(&patch), view(&template), 1 + (width + height) % 64);
        }
    }
}

/// All thresholds, and all alignments of both pictures within larger ones.
fn all_thresholds_and_alignments(backend: Backend) {
    let (pixels, other) = (noise(200 * 12, 3), noise(200 * 12, 4));
    for threshold in 0..=256u16 {
        let start = usize::from(threshold) % 67;
        let patch = Image::with_stride(&pixels[start..], 65, 11, 200).unwrap();
        let template = close_to(&other, 5);
        let template = Image::with_stride(&template[usize::from(threshold) / 3 % 67..], 65, 11, 199).unwrap();
        same(backend, patch, template, threshold);
        same(backend, patch, patch, threshold);
    }
}

/// Every difference there is, at the thresholds around it.
fn all_differences(backend: Backend) {
    for difference in 0..=255u8 {
        let (patch, template) = ([difference; 33], [0; 33]);
        let view = |pixels| Image::new(pixels, 33, 1).unwrap();
        for threshold in u16::from(difference).saturating_sub(1)..=u16::from(difference) + 1 {
            same(backend, view(&patch), view(&template), threshold);
            same(backend, view(&template), view(&patch), threshold);
        }
    }
}

/// The largest sum that there can be, and pictures that leave a whole register's worth of zeroes.
fn extremes(backend: Backend) {
    let pixels: Vec<u8> = std::vec![255; 256 * 256];
    let view = Image::new(&pixels, 256, 256).unwrap();
    same(backend, view, view, 64);
    same(backend, view, view, 256);
    let line = Image::new(&pixels, 65535, 1).unwrap();
    same(backend, line, line, 1);
}

macro_rules! stamp {
    ($($module:ident: $backend:ident;)*) => {$(
        mod $module {
            use super::*;
            stamp!(@tests $backend: all_sizes, all_thresholds_and_alignments, all_differences, extremes);
        }
    )*};
    (@tests $backend:ident: $($test:ident),*) => {$(
        #[test]
        fn $test() {
            if Backend::$backend.is_available() {
                super::$test(Backend::$backend);
            } else {
                println!("skipped: {}: this machine has no {:?}", stringify!($test), Backend::$backend);
            }
        }
    )*};
}

stamp! {
    scalar_loop: Scalar;
    sse2: Sse2;
    avx2: Avx2;
    avx512: Avx512;
    neon: Neon;
}
