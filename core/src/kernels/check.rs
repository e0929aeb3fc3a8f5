//! Compares the loops of a backend with formulas or the plain loops, for many sizes, alignments and thresholds, for
//! extreme values, and for slices that are too short. A difference panics.
//!
//! Unit tests do this for each backend of the host, with data that ends at a page that may not be read;
//! `tests/chip/kernels` does it on emulated chips, at the edges of their memory.

#![allow(clippy::indexing_slicing, clippy::unwrap_used)] // a panic is a result
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of noise

use super::backend::Backend;
use super::cut_table::CutTable;
use super::layout::{CELL, CHANNELS, Layout, Packed, SIDE};
use super::native::{GradientStep, Interpolation, ScaledSums, deviation, features, gradients, norms, replace};
use super::plain;
#[cfg(feature = "refiner")]
use super::plain::dense::Layer;
use super::plain::levels::{BIAS, MixedRow};
use super::products::Products;
#[cfg(feature = "refiner")]
use super::products::{Dense, SPARE};
use super::scorer::Scorer;
use super::scores::{ALL_FOUR, Blocks, ONE, RowsOfRanges};
use crate::image::{Image, Rect};
use core::fmt::Debug;

/// Size in bytes of each memory area in [`Areas`].
pub const ROOM: usize = 64 * 1024;

/// Miri is thousands of times slower: there only every 29th case is compared.
const STEP: usize = if cfg!(miri) { 29 } else { 1 };

/// Memory areas with test pictures at one edge. If memory beyond it is inaccessible, reads beyond a picture fault.
#[derive(Debug)]
pub struct Areas<'a> {
    /// An area with pictures at its end, after which memory is inaccessible.
    pub end: &'a mut [u8],
    /// A second area with pictures at its end, before inaccessible memory.
    pub other_end: &'a mut [u8],
    /// An area with pictures at its start, before which memory is inaccessible.
    pub start: &'a mut [u8],
}

/// Compares all kernels of `backend`, and those selected at compile time, with formulas or the plain loops.
///
/// # Panics
/// If a result differs.
#[cfg(feature = "unstable")]
pub fn all(backend: Backend, areas: &mut Areas<'_>) {
    scores(backend, areas);
    candidates(backend, areas);
    ranges(backend, areas);
    groups(backend, areas);
    products(backend, areas);
    #[cfg(feature = "refiner")]
    dense(backend, areas);
    native(areas);
}

#[inline(never)]
pub(super) fn native(areas: &mut Areas<'_>) {
    weights();
    columns();
    cells();
    norms_of_rows();
    gray_levels(areas);
}

/// Pseudo-random numbers, the same in every run.
struct Noise(u32);

impl Noise {
    fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// A number from `-most` to `most`.
    fn next(&mut self, most: u32) -> i32 {
        ((self.bits() >> 7) % (2 * most + 1)).cast_signed() - most.cast_signed()
    }

    /// A gray level from `level` to `level + most - 1`, modulo 256.
    fn near(&mut self, level: u8, most: u8) -> u8 {
        level.wrapping_add((self.bits() >> 9) as u8 % most)
    }
}

/// Fills the areas with noise, for differences below and above a threshold. Bytes of `end` and of another area at the
/// same index differ by at most 64 (modulo 256); about a fifth of `start` differs by any amount.
fn fill(areas: &mut Areas<'_>) {
    let mut noise = Noise(1);
    for ((first, second), third) in areas.end.iter_mut().zip(&mut *areas.other_end).zip(&mut *areas.start) {
        let [base, offset, other, sign] = noise.bits().to_le_bytes();
        let [near, far] =
            [offset % (2 + other % 64), other].map(|by| if sign & 1 == 0 { by } else { by.wrapping_neg() });
        *first = base;
        *second = base.wrapping_add(near);
        *third = if sign > 200 { base.wrapping_add(far) } else { base.wrapping_sub(near) };
    }
}

/// One of three similarity tables, steep to flat, with zeroes from `threshold` on.
pub(super) fn cut(which: u16, threshold: u16) -> CutTable {
    // exp(-1), exp(-1 / 40), exp(-1 / 255) in units of 1/65536
    let factor = [24_109, 63_918, 65_280][usize::from(which % 3)];
    let mut entry = u32::from(ONE);
    let entries = core::array::from_fn(|_| {
        let this = entry as u16;
        entry = (entry * factor + (1 << 15)) >> 16;
        this
    });
    let mut cut = CutTable::EMPTY;
    cut.cut(&entries, threshold);
    cut
}

fn part(memory: &[u8], last: bool, length: usize) -> &[u8] {
    if last { &memory[memory.len() - length..] } else { &memory[..length] }
}

fn part_mut(memory: &mut [u8], last: bool, length: usize) -> &mut [u8] {
    let from = if last { memory.len() - length } else { 0 };
    &mut memory[from..][..length]
}

fn signed(bytes: &[u8]) -> &[i8] {
    // SAFETY: an i8 is as large and as aligned as a u8, and all values are valid.
    unsafe { core::slice::from_raw_parts(bytes.as_ptr().cast(), bytes.len()) }
}

fn picture(memory: &[u8], last: bool, (width, height): (u16, u16), stride: usize) -> Image<'_> {
    let bytes = usize::from(height - 1) * stride + usize::from(width);
    Image::with_stride(part(memory, last, bytes), width, height, stride).unwrap()
}

fn sum(patch: Image<'_>, template: Image<'_>, of: impl Fn(u8, u8) -> u32) -> u32 {
    let of_row = |y| patch.row(y).iter().zip(template.row(y)).map(|(&f, &g)| of(f, g)).sum::<u32>();
    (0..template.height()).map(of_row).sum()
}

fn score(patch: Image<'_>, template: Image<'_>, table: &CutTable) -> u32 {
    sum(patch, template, |f, g| table.similarity(f.abs_diff(g)).into())
}

#[track_caller]
fn check(right: bool, what: &str, backend: Backend, case: impl Debug) {
    assert!(right, "{backend:?}: {what}: {case:?}");
}

#[inline(never)]
pub(super) fn scores(backend: Backend, areas: &mut Areas<'_>) {
    fill(areas);
    let Areas { end, other_end, start } = &*areas;
    let small = (1..=70).flat_map(|width| [1, 2, 3, 8, 13, 70 - width / 2].map(|height| (width, height)));
    let wide = [127, 128, 129, 255, 256, 257, 1000, 1021, 1024, 4099].map(|width| (width, 3));
    for ((width, height), gap) in small.chain(wide).step_by(STEP).flat_map(|size| [0, 1, 2].map(|gap| (size, gap))) {
        let pair = |patch, template, last| {
            let patch = picture(patch, last, (width, height), usize::from(width) + gap);
            let template = picture(template, last, (width, height), usize::from(width) + 2 * gap);
            pair(backend, patch, template, 1 + (width * 7 + height * 13) % 255);
        };
        pair(end, other_end, true);
        pair(start, end, false);
        pair(end, start, false);
    }
    for threshold in (0..=256).step_by(STEP) {
        let size = (21 + threshold % 53, 3);
        for (from, other) in (0..4).flat_map(|from| (0..4).map(move |other| (from, other))) {
            let patch = picture(&end[from..], false, size, 77);
            pair(backend, patch, picture(&other_end[other..], false, size, 78), threshold);
            pair(backend, patch, patch, threshold);
        }
    }
    for difference in (0..=255).step_by(STEP) {
        let (row, black) = ([difference; 33], [0; 33]);
        let [row, black] = [&row, &black].map(|row| Image::new(row, 33, 1).unwrap());
        for threshold in u16::from(difference).saturating_sub(1)..=u16::from(difference) + 1 {
            pair(backend, row, black, threshold);
            pair(backend, black, row, threshold);
        }
    }
    padding(backend, areas);
    if !cfg!(miri) {
        largest_scores(backend, areas);
    }
}

/// Compares scores and distances, with floors and limits below, at and above the exact values.
fn pair(backend: Backend, patch: Image<'_>, template: Image<'_>, threshold: u16) {
    let table = cut(patch.height() % 3 + threshold, threshold);
    let scorer = Scorer::new(backend, &table);
    let case = (patch.width(), patch.height(), threshold);
    let score = score(patch, template, &table);
    let most = plain::scores::most(patch, template);
    check(scorer.score(patch, template) == Some(score), "score", backend, case);
    for floor in
        [0, 1, score / 2, score.saturating_sub(1), score, score.saturating_add(1), score.midpoint(most), u32::MAX]
    {
        let expected = Some(score).filter(|&score| score >= floor);
        check(scorer.score_at_least(patch, template, floor) == expected, "score and floor", backend, (case, floor));
    }
    let exact = sum(patch, template, |f, g| f.abs_diff(g).into());
    for enough in [0, exact / 3, exact.saturating_sub(1), exact, exact + 1, u32::MAX] {
        let answer = scorer.distance(patch, template, enough).unwrap();
        let right = if exact <= enough { answer == exact } else { answer > enough && answer <= exact };
        check(right, "distance", backend, (case, enough));
    }
}

fn padding(backend: Backend, areas: &Areas<'_>) {
    for (width, height) in [(1, 1), (3, 5), (40, 9), (64, 2), (65, 3), (150, 4)] {
        let template = picture(areas.end, true, (width, height), usize::from(width) + 1);
        let table = cut(height, 40 + width);
        for (x, y) in (0..=width).step_by(7).flat_map(|x| (0..=height).map(move |y| (x, y))) {
            let seen = Rect::new(x.into(), y.into(), (width - x) / 2, (height - y).div_ceil(2));
            let seen = seen.intersection(Rect::new(0, 0, width, height));
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let outside = pixels.filter(|&(x, y)| !seen.contains(Rect::new(x.into(), y.into(), 1, 1)));
            let of_black = |(x, y): (u16, u16)| u32::from(table.similarity(template.row(y)[usize::from(x)]));
            let score = Scorer::new(backend, &table).score_on_padding(template, seen);
            check(score == outside.map(of_black).sum(), "score on the padding", backend, (width, height, seen));
        }
    }
}

/// Compares the largest pictures whose score fits in a `u32`: white with white, and white with black. The score of
/// 65537 pixels would fit too, but 65537 is prime and a side is a `u16`, so the largest picture has 65536 pixels.
fn largest_scores(backend: Backend, Areas { end, other_end, .. }: &mut Areas<'_>) {
    end.fill(255);
    other_end.fill(0);
    for size in [(256, 256), (65_535, 1), (1, 65_535), (4369, 15), (16_384, 4)] {
        let [white, black] = [&*end, &*other_end].map(|memory| picture(memory, true, size, size.0.into()));
        for threshold in [1, 128, 256] {
            pair(backend, white, white, threshold);
            pair(backend, white, black, threshold);
        }
    }
}

/// Copies a part of a picture, with up to 15 gray levels of noise, to an edge of the memory `to`.
fn copy_near<'a>(from: Image<'_>, part: Rect, to: &'a mut [u8], last: bool, noise: &mut Noise) -> Image<'a> {
    let from = from.crop(part).unwrap();
    let (width, height) = (usize::from(part.width), usize::from(part.height));
    for (y, row) in part_mut(to, last, width * height).chunks_mut(width).enumerate() {
        row.iter_mut().zip(from.row(y as u16)).for_each(|(to, &from)| *to = noise.near(from, 16));
    }
    picture(to, last, (part.width, part.height), width)
}

/// Checks that `candidates` excludes no offset whose score reaches the floor, but does exclude some with low scores.
#[inline(never)]
pub(super) fn candidates(backend: Backend, areas: &mut Areas<'_>) {
    fill(areas);
    let mut noise = Noise(3);
    let sizes = (1..=70).flat_map(|width| [1, 2, 6, 1 + width * 5 % 23].map(|height| (width, height)));
    for ((width, height), threshold) in
        sizes.step_by(STEP).flat_map(|size| [0, 1, 13, 40, 255, 256].map(|threshold| (size, threshold)))
    {
        let last = (width + height + threshold) % 4 > 0;
        let patch = picture(areas.end, last, (width + 3, height), usize::from(width) + 3);
        let table = cut(width + height, threshold);
        for near in 0..5 {
            let part = Rect::new(near % 4, 0, width, height);
            let from = if near < 4 { patch } else { picture(areas.start, last, (width, height), width.into()) };
            let template = copy_near(from, part, areas.other_end, last, &mut noise);
            let score = |x| score(patch.crop(Rect { x, ..part }).unwrap(), template, &table);
            let scores = [0, 1, 2, 3].map(score);
            let most = plain::scores::most(template, template);
            let answer = |floor| Scorer::new(backend, &table).candidates(patch, template, floor, ALL_FOUR);
            for floor in scores.into_iter().chain([0, 1, scores[near as usize % 4] + 1, most]) {
                let answer = answer(floor);
                let right = (0..4).all(|offset| answer >> offset & 1 != 0 || scores[offset] < floor);
                check(right, "candidates", backend, (width, height, threshold, near, floor));
            }
            // Other backends may return all four offsets.
            let excludes = matches!(backend, Backend::Dsp | Backend::Helium);
            if excludes && near == 4 && width >= 16 && (1..=13).contains(&threshold) {
                check(answer(most) != ALL_FOUR, "no candidate is excluded", backend, (width, height, threshold));
            }
        }
    }
}

/// Compares the pixel ranges of 4x4 blocks with the formula. The four pixel rows under the blocks have different
/// alignments, and one of these rows lies at an edge of the memory.
#[inline(never)]
pub(super) fn ranges(backend: Backend, areas: &mut Areas<'_>) {
    fill(areas);
    let Areas { end, other_end, start } = &mut *areas;
    for (columns, at_edge) in (4..=200).step_by(STEP).flat_map(|columns| (0..4).map(move |row| (columns, row))) {
        let threshold = 1 + (columns * 7 + at_edge) as u16 % 256;
        let table = cut(2, threshold);
        let mut rows: [&[u8]; 4] = core::array::from_fn(|row| &other_end[row * 301..][..columns + 3]);
        rows[at_edge] = part(end, columns % 3 > 0, columns + 3);
        let stride = columns.next_multiple_of(4);
        let (low, high) = start[..512].split_at_mut(256);
        let after = [low[stride], high[stride]];
        Scorer::new(backend, &table).ranges(&rows, &mut low[..stride], &mut high[..stride]);
        check(after == [low[stride], high[stride]], "bytes after ranges", backend, (columns, threshold));
        ranges_are_right(backend, threshold, &rows, &low[..columns], &high[..columns]);
    }
    ranges_of_rows(backend, areas);
}

fn ranges_are_right(backend: Backend, threshold: u16, rows: &[&[u8]; 4], low: &[u8], high: &[u8]) {
    let (last, half) = ((threshold - 1) as u8, (threshold / 2) as u8);
    for (at, given) in low.iter().copied().zip(high.iter().copied()).enumerate() {
        let block = rows.iter().flat_map(|row| row[at..at + 4].iter().copied());
        let (lowest, highest) = block.fold((255, 0), |(low, high), pixel| (pixel.min(low), pixel.max(high)));
        let (from, to) = (lowest.saturating_sub(last), highest.saturating_add(last));
        let expected = match backend {
            Backend::Scalar => (lowest, highest),
            Backend::Swar => ((lowest / 2).saturating_sub(half), ((255 - highest) / 2).saturating_sub(half)),
            Backend::Dsp | Backend::Helium => (from, to - from),
            _ => (from ^ 128, (to - from) ^ 128),
        };
        check(given == expected, "range", backend, (low.len(), at, threshold));
    }
}

fn ranges_of_rows(backend: Backend, Areas { end, other_end, start }: &mut Areas<'_>) {
    let table = cut(2, 16);
    let scorer = Scorer::new(backend, &table);
    for width in 4..=150 {
        let (height, step, last) = (4 + width % 7, 1 << (width % 3), width % 2 > 0);
        let columns = usize::from(width) - 3;
        let stride = columns.next_multiple_of(4);
        let tops = (0..height - 3).step_by(step);
        let picture = picture(other_end, last, (width, height), width.into());
        let length = stride * (tops.len() - 1) + columns;
        let (low, high) = (part_mut(end, last, length), part_mut(start, last, length));
        if !scorer.ranges_of_rows(picture, step, RowsOfRanges { low: &mut *low, high: &mut *high, stride }) {
            continue;
        }
        for ((top, low), high) in tops.zip(low.chunks(stride)).zip(high.chunks(stride)) {
            let rows = [0, 1, 2, 3].map(|row| picture.row(top + row));
            ranges_are_right(backend, 16, &rows, &low[..columns], &high[..columns]);
        }
    }
    let pixels = picture(other_end, true, (64, 8), 64);
    let to = RowsOfRanges { low: &mut end[..64 * 5], high: &mut start[..64 * 4 + 60], stride: 64 };
    check(!scorer.ranges_of_rows(pixels, 1, to), "ranges of rows without room", backend, ());
    let to = RowsOfRanges { low: &mut end[..64 * 5], high: &mut start[..64 * 5], stride: 60 };
    check(!scorer.ranges_of_rows(pixels, 1, to), "ranges of rows in short rows", backend, ());
}

#[repr(align(4))]
struct Aligned([u8; 2048]);

/// Checks that the bound of a group of 4x4 offsets is not below any of their scores.
#[inline(never)]
pub(super) fn groups(backend: Backend, areas: &mut Areas<'_>) {
    let mut noise = Noise(5);
    let (mut low, mut high) = (Aligned([0; 2048]), Aligned([0; 2048]));
    for (width, which) in (1..=70).step_by(STEP).flat_map(|width| (0..6).map(move |which| (width, which))) {
        let (height, threshold) =
            [(1 + width % 11, width % 40), (1, 0), (2, 13), (6, 1), (2, 255), (3, 256)][usize::from(which)];
        let (left, last) = (width * 3 % 13, (width + which) % 3 > 0);
        let size = (left + width + 6, height + 5);
        let across = usize::from(size.0);
        // Noise in which neighbouring pixels are similar.
        for row in part_mut(areas.end, last, across * usize::from(size.1)).chunks_mut(across) {
            row.iter_mut().fold(100, |level, pixel| {
                *pixel = noise.near(level, 15).wrapping_sub(7);
                *pixel
            });
        }
        let frame = picture(areas.end, last, size, across);
        let part = Rect::new(i32::from(left) + 2, 1, width, height);
        let template = copy_near(frame, part, areas.other_end, last, &mut noise);
        let table = cut(2, threshold);
        let scorer = Scorer::new(backend, &table);
        let stride = usize::from(left + width).next_multiple_of(4);
        for (y, (low, high)) in (0..height + 2).zip(low.0.chunks_mut(stride).zip(high.0.chunks_mut(stride))) {
            scorer.ranges(&[0, 1, 2, 3].map(|row| &frame.row(y + row)[..usize::from(left + width) + 3]), low, high);
        }
        for top in 0..3 {
            let blocks =
                Blocks { low: &low.0, high: &high.0, start: usize::from(top) * stride + usize::from(left), stride };
            let score = |at: u16| {
                let patch = Rect { x: (left + at % 4).into(), y: (top + at / 4).into(), ..part };
                score(frame.crop(patch).unwrap(), template, &table)
            };
            let (best, most) = ((0..16).map(score).max().unwrap(), plain::scores::most(template, template));
            for floor in [0, 1, best / 2, best, best + 1, best.midpoint(most), most] {
                let right = match scorer.bound(&blocks, template, floor) {
                    Some(bound) => bound >= best.max(floor) && bound <= most,
                    None => best < floor,
                };
                check(right, "bound of a group", backend, (width, height, threshold, top, floor));
            }
        }
    }
    far_groups(backend, areas);
}

/// Checks that a group of 4x4 offsets at any column is excluded if each pixel under it differs from the template by the
/// threshold or more, and is not excluded if each differs by less.
fn far_groups(backend: Backend, areas: &mut Areas<'_>) {
    let table = cut(2, 13);
    let scorer = Scorer::new(backend, &table);
    let (mut low, mut high) = (Aligned([0; 2048]), Aligned([0; 2048]));
    for (width, column) in (16..=70).zip((0..13).cycle()) {
        let columns = column + usize::from(width);
        let stride = columns.next_multiple_of(4);
        let row = &[100; 86][..columns + 3];
        for (low, high) in low.0.chunks_mut(stride).zip(high.0.chunks_mut(stride)).take(9) {
            scorer.ranges(&[row; 4], low, high);
        }
        let blocks = Blocks { low: &low.0, high: &high.0, start: column, stride };
        for (level, counts) in [(80, false), (87, false), (88, true), (112, true), (114, false), (130, false)] {
            part_mut(areas.end, true, usize::from(width) * 9).fill(level);
            let template = picture(areas.end, true, (width, 9), width.into());
            let most = plain::scores::most(template, template);
            // A bound may count up to two of the nine rows as fully similar, but `most / 4` needs more than two.
            let bound = scorer.bound(&blocks, template, most / 4);
            check(bound.is_some() == counts, "bound of a far group", backend, (width, column, level));
        }
    }
    // Two strides overflow a `usize`, so the ranges cannot lie in memory.
    let beyond = Blocks { low: &low.0, high: &high.0, start: 0, stride: usize::MAX / 2 + 1 };
    let template = picture(areas.end, true, (16, 3), 16);
    let most = plain::scores::most(template, template);
    check(scorer.bound(&beyond, template, most) == Some(most), "bound without ranges", backend, beyond.stride);
}

/// Compares filter responses and gradients: many filter shapes, the largest sums, and invalid layouts.
#[inline(never)]
pub(super) fn products(backend: Backend, areas: &mut Areas<'_>) {
    let odd = [(4, 4), (5, 40), (6, 32), (4, 50), (14, 14), (32, 6), (1, 1), (7, 9), (13, 15)];
    let shapes = (4..=32).map(|across| (across, (1 + across * 5 % 13).min(200 / across)));
    let shapes = odd.into_iter().chain(shapes).enumerate().step_by(STEP);
    // Cells and weights of the largest absolute values, with equal and with opposite signs, then noise.
    for (cell, sign, count) in [(128, Some(-1), 6), (128, Some(1), 6), (127, Some(1), 6), (0, None, usize::MAX)] {
        areas.end.fill(cell);
        if sign.is_none() {
            fill(areas);
        }
        let spans = |number| [1 + number % 17, 2, 13, 17].map(|span| (number, span));
        for ((across, down), (number, span)) in
            shapes.clone().take(count).flat_map(|(number, shape)| spans(number).map(|span| (shape, span)))
        {
            let layout = Layout { row: across * 10, stride: (across + span - 1) * 10, step: 10, span };
            let cells = signed(part(areas.end, number % 3 > 0, layout.stride * (down + span - 1)));
            if span <= 13 && number % 2 > 0 {
                sums::<13>(backend, cells, layout, down, sign);
            } else {
                sums::<17>(backend, cells, layout, down, sign);
            }
        }
    }
    for (row, step, cut, stride) in [(35, 10, 0, 90), (40, 7, 0, 90), (40, 10, 25, 70), (30, 10, 0, 30), (0, 10, 0, 0)]
    {
        let layout = Layout { row, stride, step, span: 5 };
        let cells = signed(part(areas.end, true, (stride * 9usize).saturating_sub(cut)));
        sums::<13>(backend, cells, layout, 5, None);
    }
}

/// Compares responses and gradients, computed piece by piece, with those of the plain loops. Weights are noise within
/// +-8191 and errors noise within +-16383, or all are `sign` times these limits.
fn sums<const N: usize>(backend: Backend, cells: &[i8], layout: Layout, down: usize, sign: Option<i16>) {
    let products = Products::new(backend);
    let mut noise = Noise(5);
    let mut number = |most: i16| sign.map_or_else(|| noise.next(most as u32) as i16, |sign| sign * most);
    let mut weights = [0; 2000];
    let weights = &mut weights[..layout.row * down];
    weights.fill_with(|| number(8191));
    let errors: [[i16; N]; N] = core::array::from_fn(|_| core::array::from_fn(|_| number(16_383)));
    for spare in [0, 2000] {
        let (mut room, mut scratch) = (Packed::new(), [7; 2000]);
        let spare = &mut scratch[..spare];
        let (mut given, mut expected) = ([[7; N]; N], [[7; N]; N]);
        for piece in 0..products.pieces(layout, weights.len()) {
            products.responses(piece..piece + 1, &mut room, spare, cells, layout, weights, &mut given);
        }
        plain::products::responses(0..layout.span, &mut Packed::new(), &mut [], cells, layout, weights, &mut expected);
        let row = ..layout.span;
        let right = given[row].iter().zip(&expected[row]).all(|(given, expected)| given[row] == expected[row]);
        check(right, "responses", backend, (layout, down, sign));
        let (mut given, mut expected) = ([9000; 2000], [9000; 2000]);
        let [given, expected] = [&mut given, &mut expected].map(|sums| &mut sums[..weights.len()]);
        for piece in 0..products.gather_pieces(layout, weights.len()) {
            products.gather(piece..piece + 1, &mut room, spare, cells, layout, &errors, given);
        }
        plain::products::gather(0..layout.span, &mut Packed::new(), &mut [], cells, layout, &errors, expected);
        check(given == expected, "gathered errors", backend, (layout, down, sign));
    }
}

/// Compares layers of a network with the formula, for noise and for the largest sums. If a layer's slices are too
/// short, compares it with the plain loop.
#[cfg(feature = "refiner")]
#[inline(never)]
pub(super) fn dense(backend: Backend, areas: &mut Areas<'_>) {
    // (patches, inputs, outputs) of the refiner's layers but the last, and of two unusual layers.
    let known = [(16, 20, 8), (8, 72, 16), (8, 144, 24), (4, 216, 24), (1, 384, 24), (1, 4, 1), (2, 17, 5)];
    let odd = [(1, 1), (2, 1), (3, 2), (2, 3), (5, 5), (7, 4)];
    let odd = (4..=80).step_by(4).chain([220, 380]).zip(odd.into_iter().cycle()).map(|(inputs, (n, o))| (n, inputs, o));
    fill(areas);
    // Noise, then the largest numbers.
    for sign in [0, 1, -1] {
        let mut noise = Noise(9);
        let biases = [(); 24].map(|()| if sign == 0 { noise.next(200_000) } else { sign << 27 }.to_le_bytes());
        for (weight, x) in areas.end.iter_mut().zip(&mut *areas.other_end) {
            let (any, most) = ((*weight).cast_signed().max(-127), 127 * sign as i8);
            *weight = if sign == 0 { any } else { most }.cast_unsigned();
            *x = if sign == 0 { *x & 127 } else { 127 };
        }
        for (number, (count, inputs, outputs)) in known.into_iter().chain(odd.clone()).enumerate().step_by(STEP) {
            let last = number % 3 > 0;
            let weights = signed(part(areas.end, last, inputs * outputs));
            let patches = signed(part(areas.other_end, last, count * inputs));
            // With biases of 0, the products alone determine the result.
            let none = [[0; 4]; 24];
            for (biases, shift) in [(&biases, 20), (&biases, 21), (&biases, 22), (&none, 0), (&none, 9), (&none, 13)] {
                let layer = Layer { inputs, weights, biases: &biases[..outputs], shift };
                // Scratch memory at different alignments, or none.
                for room in [0..SPARE, 1..SPARE + 1, 0..0] {
                    let (mut spare, mut out) = ([77; SPARE + 1], [55; 256]);
                    Dense::new(backend).outputs(layer, patches, &mut spare[room], &mut out[..count * outputs]);
                    let right = patches.chunks(inputs).zip(out.chunks(outputs)).all(|(patch, out)| {
                        let sums = weights.chunks(inputs).zip(biases).map(|(weights, &bias)| {
                            let products = patch.iter().zip(weights).map(|(&x, &w)| i64::from(x) * i64::from(w));
                            (i64::from(i32::from_le_bytes(bias)) + products.sum::<i64>()) >> shift
                        });
                        out.iter().zip(sums).all(|(&out, sum)| i64::from(out) == sum.clamp(0, 127))
                    });
                    check(right, "layer", backend, (count, inputs, outputs, shift, sign));
                }
            }
        }
    }
    areas.end.fill(100);
    for (inputs, weights, patches) in [(16, 31, 32), (16, 32, 33), (16, 0, 16), (0, 32, 32), (15, 30, 30), (16, 32, 0)]
    {
        let weights = signed(part(areas.end, true, weights));
        let layer = Layer { inputs, weights, biases: &[[1, 0, 0, 0]; 2], shift: 11 };
        let (mut given, mut wanted) = ([9; 7], [9; 7]);
        Dense::new(backend).outputs(layer, &[100; 33][..patches], &mut [0; SPARE], &mut given);
        plain::dense::outputs(layer, &[100; 33][..patches], &mut [], &mut wanted);
        check(given == wanted, "layer with missing numbers", backend, (inputs, weights.len(), patches));
    }
}

/// Compares the kernels on filter weights with formulas, for 0 to 20 weights, which fill the last vector differently.
fn weights() {
    // Values at the limits of an `i32`, and near other powers of 2.
    const EXTREMES: [i32; 12] =
        [0, 1, -1, 1023, -1024, 65_536, -65_537, 1 << 30, -(1 << 30), i32::MAX, -i32::MAX, i32::MIN];
    let mut noise = Noise(7);
    for count in 0..21 {
        let mut weights = [(); 20].map(|()| EXTREMES[noise.bits() as usize % EXTREMES.len()]);
        let weights = &mut weights[..count.min(20)];
        scaled(ScaledSums::of(weights));
        for (unit, left) in [(14, 2), (14, 5), (16, 0), (17, 0), (19, 0)] {
            // Numbers within +-2^(30 - left), so that no value overflows, then numbers of -1 to 1, for which a product
            // with `factor / 2^32` rounds to 0 or -1.
            for most in [(1 << 30) >> left, 1] {
                let sums: [i32; 20] = core::array::from_fn(|_| noise.next(most));
                let mut reversed = sums;
                reversed.reverse();
                let (weights, sums) = (&reversed[..weights.len()], &sums[..weights.len()]);
                scaled(ScaledSums { weights, factor: 5056 << (32 - unit), sums, left });
            }
        }
        let slopes: [i16; 20] =
            core::array::from_fn(|at| if at % 3 == 0 { i16::MIN } else { noise.next(i16::MAX as u32) as i16 });
        for length in [0, 1, -1, (1 << 32) - 1, 1 << 40, (1 << 47) - 1, -(1 << 46), 0x1234_5678_9ABC] {
            for back in 0..63 {
                let mut moved = [5; 20];
                let moved = &mut moved[..weights.len()];
                moved.copy_from_slice(weights);
                GradientStep { length, back }.apply(moved, &slopes);
                for ((&moved, &weight), &slope) in moved.iter().zip(&*weights).zip(&slopes) {
                    let change = (i64::from(slope) * length + (1 << back >> 1)) >> back;
                    let expected = i32::try_from(i64::from(weight) - change).unwrap_or(weight);
                    assert_eq!(moved, expected, "{weight} less {slope} * {length} >> {back}");
                }
            }
        }
    }
}

/// Compares the largest absolute value of `numbers` with the formula, and their quantised values for every shift up to
/// 31 that takes this largest value below 8191.
fn scaled(numbers: ScaledSums<'_>) {
    let ScaledSums { weights, factor, sums, left } = numbers;
    let number = |factor, (&weight, &sum): (&i32, &i32)| {
        ((i128::from(weight) * i128::from(factor)) >> 32) as i64 + (i64::from(sum) << left)
    };
    // The absolute value, rounded toward zero. `number` rounds down, so for a negative value the product is negated.
    let size = |pair: (&i32, &i32)| match number(factor, pair) {
        number @ 0.. => number,
        _ => number(-factor, pair) - 2 * (i64::from(*pair.1) << left),
    };
    let largest = numbers.largest();
    let expected = weights.iter().zip(sums).map(size).max().unwrap_or(0);
    assert_eq!(i64::from(largest), expected, "the largest of {weights:?}, {sums:?} << {left}, factor {factor}");
    for shift in (0..32).skip_while(|shift| largest >> shift >= 8191) {
        let mut coded = [7; 21];
        numbers.code(shift, &mut coded);
        for (pair, &coded) in weights.iter().zip(sums).zip(&coded) {
            let expected = (number(factor, pair) + (1 << shift >> 1)) >> shift;
            assert_eq!(i64::from(coded), expected, "{pair:?} << {left}, factor {factor}, coded by {shift}");
        }
        assert!(coded[weights.len()..].iter().all(|&coded| coded == 7), "{} numbers are coded", weights.len());
    }
}

fn columns() {
    let mut noise = Noise(11);
    let mut places = [(0, 0); 40];
    let mut columns = Interpolation::<40>::new();
    for (column, place) in (0..).zip(&mut places) {
        *place = ((noise.bits() % 512) as u16, 255 - column * 6);
        columns.push(place.0, place.1);
    }
    let mut row: MixedRow = [0; Interpolation::<40>::LEFT_SAMPLES + 4];
    for extreme in [true, false] {
        row.fill_with(|| {
            let level = noise.bits() % (255 * 256 + 1);
            ((if extreme { level % 2 * 255 * 256 } else { level }) as u16).wrapping_sub(BIAS)
        });
        for count in 0..=40 {
            let mut out = [7; 40];
            columns.mix(&row, &mut out[..count]);
            let expected = |number: usize| {
                let (place, part) = places[number];
                let [first, second] = [0, 1].map(|next| u32::from(row[usize::from(place) + next].wrapping_add(BIAS)));
                ((first * (256 - u32::from(part)) + second * u32::from(part) + (1 << 15)) >> 16) as u8
            };
            assert_eq!(out, core::array::from_fn(|at| if at < count { expected(at) } else { 7 }), "{count} columns");
        }
    }
}

fn cells() {
    /// Cells in the longest row of the robust tracker.
    const ROW: usize = 48;
    let mut noise = Noise(13);
    for (across, most) in (0..=ROW).flat_map(|across| [2, 30, 255].map(|most| (across, most))) {
        let mut lines = [[0; ROW * CELL as usize + 2]; SIDE];
        lines.as_flattened_mut().fill_with(|| match most {
            2 => ((noise.bits() >> 9) as u8 & 1).wrapping_neg(),
            most => noise.near(0, most),
        });
        let (mut sums, mut energies) = ([[7; ROW]; CHANNELS], [7; ROW]);
        gradients(&lines, &mut sums, &mut energies, across);
        for (number, &energy) in energies[..across].iter().enumerate() {
            let wanted = plain::gradients::cell(&lines, number * usize::from(CELL));
            assert_eq!((energy, sums.map(|row| row[number])), (wanted.energy(), wanted.0), "cell {number} of {across}");
        }
        let inverses = [(); ROW].map(|()| noise.bits() % 162_561);
        let (mut given, mut expected) = ([[0; CHANNELS]; ROW], [[0; CHANNELS]; ROW]);
        features(&sums, &inverses, &mut given[..across]);
        plain::gradients::features(&sums, &inverses, &mut expected[..across]);
        assert_eq!(given, expected, "features of {across} cells");
    }
}

/// Compares norms with the formula: for random energies, for the smallest mean energy whose norm is at least `case`,
/// and for that energy less 1.
fn norms_of_rows() {
    let mut noise = Noise(17);
    for (case, kind) in (0..47_200_u32).step_by(STEP).flat_map(|case| [0, 1, 2].map(|kind| (case, kind))) {
        let (across, rows, shift) = (2 + case as usize % 20, 1 + case % 3, noise.bits() % 32);
        let energies: [u32; 22] = core::array::from_fn(|_| match kind {
            0 => (noise.bits() >> shift) % (rows * 5900 * 5900),
            kind => rows * ((case * case).div_ceil(64) + 1).saturating_sub(kind).min(5900 * 5900),
        });
        let mut given = energies;
        norms(&mut given[..across], rows, |norm| 3 * norm);
        for (at, &norm) in given[..across].iter().enumerate() {
            let around = &energies[at.saturating_sub(1)..across.min(at + 2)];
            let mean = around.iter().sum::<u32>() / (rows * around.len() as u32);
            assert_eq!(norm, 3 * (64 * mean).isqrt(), "norm {at} of {across} in {rows} rows");
        }
        assert_eq!(given[across..], energies[across..], "norms of {across} columns");
    }
}

fn gray_levels(areas: &mut Areas<'_>) {
    fill(areas);
    for (length, level) in (0..=300).chain([1024, 4099, 65_535]).zip([0, 255, 1, 100, 254].into_iter().cycle()) {
        if length == 65_535 {
            areas.end.fill(!level);
        }
        let last = length % 3 > 0;
        let (old, new) = (part_mut(areas.end, last, length), part(areas.other_end, last, length));
        let sum = old.iter().map(|&pixel| u32::from(pixel.abs_diff(level))).sum();
        let clipped = old.iter().filter(|&&pixel| pixel == 0 || pixel == 255).count() as u32;
        assert_eq!(deviation(old, level), [sum, clipped], "{length} pixels at {level}");
        let largest = old.iter().zip(new).map(|(old, &new)| old.abs_diff(new)).fold(level % 7, u8::max);
        assert_eq!(replace(old, new, level % 7), largest, "the largest difference of {length} pixels");
        assert!(old == new, "{length} pixels are replaced");
        old.iter_mut().for_each(|pixel| *pixel = pixel.wrapping_mul(31).wrapping_add(level));
    }
}
