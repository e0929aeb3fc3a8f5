//! Compares scores, distances, ranges and bounds with the formula.

use super::areas::{Areas, Noise, STEP, check, fill, part, part_mut, picture};
use crate::image::{Image, Rect};
use crate::kernels::backend::Backend;
use crate::kernels::cut_table::CutTable;
use crate::kernels::plain;
use crate::kernels::scorer::Scorer;
use crate::kernels::scores::{ALL_FOUR, Blocks, ONE, RowsOfRanges};

/// One of three similarity tables, steep to flat, with zeroes from `threshold` on.
pub(in crate::kernels) fn cut(which: u16, threshold: u16) -> CutTable {
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

fn sum(patch: Image<'_>, template: Image<'_>, of: impl Fn(u8, u8) -> u32) -> u32 {
    let of_row = |y| patch.row(y).iter().zip(template.row(y)).map(|(&f, &g)| of(f, g)).sum::<u32>();
    (0..template.height()).map(of_row).sum()
}

fn score(patch: Image<'_>, template: Image<'_>, table: &CutTable) -> u32 {
    sum(patch, template, |f, g| table.similarity(f.abs_diff(g)).into())
}

#[inline(never)]
pub(in crate::kernels) fn scores(backend: Backend, areas: &mut Areas<'_>) {
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
pub(in crate::kernels) fn candidates(backend: Backend, areas: &mut Areas<'_>) {
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
pub(in crate::kernels) fn ranges(backend: Backend, areas: &mut Areas<'_>) {
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
pub(in crate::kernels) fn groups(backend: Backend, areas: &mut Areas<'_>) {
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
