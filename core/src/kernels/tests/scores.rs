//! Tests every backend against `plain/scores.rs`.

use super::backends::for_each_backend;
use super::guard::{Guarded, Side};
use super::noise::noise as numbers;
use super::table::{cut, similarity};
use crate::image::{Image, Rect};
use crate::kernels::backend::Backend;
use crate::kernels::blocks::{Blocks, RowsOfRanges};
use crate::kernels::plain::scores as plain;
use crate::kernels::scorer::Scorer;
use crate::kernels::scores::ALL_FOUR;
use std::vec::Vec;

/// The largest side of a picture: all sizes up to this are tried. Miri is thousands of times slower, so there it is a
/// little more than the narrowest vector.
const EDGE: u16 = if cfg!(miri) { 18 } else { 70 };

/// Step of loops that go through all values.
const STEP: usize = if cfg!(miri) { 29 } else { 1 };

/// Bytes that look random, the same in every run.
fn noise(length: usize, seed: u32) -> Vec<u8> {
    numbers(length, seed, 1 << 20).map(|number: i32| number as u8).collect()
}

/// A template for `patch`. It is close to the patch, so that differences lie on both sides of any threshold.
fn close_to(patch: &[u8], seed: u32) -> Vec<u8> {
    let noise = noise(patch.len(), seed);
    patch.iter().zip(&noise).map(|(&pixel, &noise)| pixel.wrapping_add(noise % 80)).collect()
}

/// Scores with floors around the score, and distances with limits around the distance, equal those of the plain loops.
#[track_caller]
fn same(backend: Backend, patch: Image<'_>, template: Image<'_>, threshold: u16) {
    let table = cut(threshold);
    let scorer = Scorer::new(backend, &table);
    let of = || std::format!("{backend:?}: {patch:?}, {template:?}, threshold {threshold}");

    let score = plain::score(patch, template, &table);
    assert_eq!(scorer.score(patch, template), Some(score), "{}", of());
    for floor in [0, score / 2, score.saturating_sub(1), score, score.saturating_add(1), u32::MAX] {
        let expected = (score >= floor).then_some(score);
        assert_eq!(scorer.score_at_least(patch, template, floor), expected, "{}, floor {floor}", of());
    }

    let exact = plain::distance(patch, template, u32::MAX);
    for enough in [u32::MAX, exact, exact.saturating_sub(1), exact / 2, 0] {
        let distance = scorer.distance(patch, template, enough).unwrap();
        let right = if exact <= enough { distance == exact } else { distance > enough && distance <= exact };
        assert!(right, "{}, distance {distance} instead of {exact}, enough {enough}", of());
    }
}

/// Tests all sizes up to 70 by 70 next to a forbidden page: after both pictures, before both, and with a stride larger
/// than the width.
fn all_sizes(backend: Backend) {
    let (mut one, mut other) = (Guarded::with_room(70 * 73), Guarded::with_room(70 * 73));
    for width in 1..=EDGE {
        for height in 1..=EDGE {
            let stride = usize::from(width + height % 4);
            let length = usize::from(height - 1) * stride + usize::from(width);
            let pixels = noise(length, u32::from(width * 71 + height));
            let threshold = (width * 71 + height * 3) % 257;
            for side in [Side::After, Side::Before] {
                let view = |pixels| Image::with_stride(pixels, width, height, stride).unwrap();
                let (patch, template) = (one.copy(&pixels, side), other.copy(&close_to(&pixels, 7), side));
                same(backend, view(patch), view(template), 1 + threshold % 64);
                same(backend, view(patch), view(template), threshold);
            }
        }
    }
}

/// Tests all thresholds, with both pictures at all positions within larger ones.
fn all_thresholds_and_alignments(backend: Backend) {
    let (pixels, other) = (noise(200 * 12, 3), noise(200 * 12, 4));
    for threshold in (0..=256u16).step_by(STEP) {
        let start = usize::from(threshold) % 67;
        let patch = Image::with_stride(&pixels[start..], 65, 11, 200).unwrap();
        let template = close_to(&other, 5);
        let template = Image::with_stride(&template[usize::from(threshold) / 3 % 67..], 65, 11, 199).unwrap();
        same(backend, patch, template, threshold);
        same(backend, patch, patch, threshold);
    }
    for place in (0..64 * 64).step_by(STEP * 7) {
        let patch = Image::with_stride(&pixels[place % 64..], 77, 3, 128).unwrap();
        let template = Image::with_stride(&other[place / 64..], 77, 3, 77).unwrap();
        same(backend, patch, template, 40);
    }
}

/// Tests every difference, at the thresholds around it.
fn all_differences(backend: Backend) {
    for difference in (0..=255u8).step_by(STEP) {
        let (patch, template) = ([difference; 33], [0; 33]);
        let view = |pixels| Image::new(pixels, 33, 1).unwrap();
        for threshold in u16::from(difference).saturating_sub(1)..=u16::from(difference) + 1 {
            same(backend, view(&patch), view(&template), threshold);
            same(backend, view(&template), view(&patch), threshold);
        }
    }
}

/// Tests the largest possible scores and distances.
fn extremes(backend: Backend) {
    if cfg!(miri) {
        return;
    }
    let (white, black): (Vec<u8>, Vec<u8>) = (std::vec![255; 256 * 256], std::vec![0; 256 * 256]);
    let view = |pixels| Image::new(pixels, 256, 256).unwrap();
    for threshold in [1, 64, 128, 129, 256] {
        same(backend, view(&white), view(&white), threshold);
        same(backend, view(&white), view(&black), threshold);
    }
    let line = |pixels| Image::new(pixels, 65535, 1).unwrap();
    same(backend, line(&white), line(&white), 1);
    same(backend, line(&white), line(&black), 256);
    let column = |pixels| Image::new(pixels, 1, 65535).unwrap();
    same(backend, column(&white), column(&white), 1);
}

/// Pictures with as many pixels as a sum can hold, equal or as different as possible, score as in the plain loops.
/// Larger ones have no score. 65537 is prime and a side is a `u16`, so the largest allowed picture has 65536 pixels and
/// the smallest beyond 65538.
fn bound(backend: Backend) {
    let (white, black) = (std::vec![255; 2 * 65535], std::vec![0; 2 * 65535]);
    let table = cut(256);
    let scorer = Scorer::new(backend, &table);
    for (width, height) in [(256, 256), (65535, 1), (1, 65535), (4369, 15), (16384, 4)] {
        let view = |pixels| Image::new(pixels, width, height).unwrap();
        let (white, black, pixels) = (view(&white), view(&black), u32::from(width) * u32::from(height));
        let least = pixels * u32::from(similarity(255));
        assert_eq!(scorer.score(white, white), Some(pixels * 65535), "{backend:?}");
        assert_eq!(scorer.score(white, black), Some(least), "{backend:?}");
        assert_eq!(scorer.distance(white, black, u32::MAX), Some(pixels * 255), "{backend:?}");
        assert_eq!(scorer.distance(white, white, 0), Some(0), "{backend:?}");
        assert_eq!(scorer.score_between_at_least(white, white, white, 0), Some(pixels * 65535), "{backend:?}");
        assert!(scorer.score_between_at_least(black, black, white, 0) >= Some(least), "{backend:?}");
    }
    for (width, height) in [(257, 256), (65535, 2), (32769, 2), (2, 65535)] {
        let view = |pixels| Image::new(pixels, width, height).unwrap();
        let (white, black) = (view(&white), view(&black));
        for patch in [white, black] {
            assert_eq!(scorer.score(patch, white), None, "{backend:?}");
            assert_eq!(scorer.score_at_least(patch, white, 1), None, "{backend:?}");
            assert_eq!(scorer.distance(patch, white, u32::MAX), None, "{backend:?}");
            assert_eq!(scorer.score_between_at_least(patch, white, white, 0), None, "{backend:?}");
        }
    }
}

/// Tests ranges of all lengths next to a forbidden page. If rows differ in length, the shortest decides.
fn all_lengths_of_ranges(backend: Backend) {
    let table = cut(16);
    let scorer = Scorer::new(backend, &table);
    let mut guarded: [Guarded; 6] = core::array::from_fn(|_| Guarded::with_room(256));
    for length in (0..=200usize).step_by(STEP) {
        for side in [Side::After, Side::Before] {
            let [rows @ .., low, high] = &mut guarded;
            let mut seed = length as u32 * 9;
            let rows = rows.each_mut().map(|row| {
                seed += 1;
                row.copy(&noise(length + 3 + (seed as usize % 3), seed), side)
            });
            let mut expected = (std::vec![7; length + 3], std::vec![7; length + 3]);
            plain::spread(&rows, &mut expected.0, &mut expected.1);
            for room in [length, length + 1, length.saturating_sub(1)] {
                let (low, high) = (low.slice(room, side), high.slice(room, side));
                low.fill(7);
                high.fill(7);
                scorer.spread(&rows, low, high);
                assert_eq!(low, &expected.0[..room], "{backend:?}, {length} columns, room for {room}");
                assert_eq!(high, &expected.1[..room], "{backend:?}, {length} columns, room for {room}");
            }
        }
    }
}

/// The ranges of several rows are those of each row, next to a forbidden page, for all widths and steps.
fn ranges_of_rows(backend: Backend) {
    let table = cut(16);
    let scorer = Scorer::new(backend, &table);
    let mut guarded: [Guarded; 3] = core::array::from_fn(|_| Guarded::with_room(3000));
    for width in (4..=150u16).step_by(STEP) {
        let (height, step) = (4 + width % 7, 1 << (width % 3));
        let stride = (usize::from(width) - 3).next_multiple_of(4);
        let tops = (0..height - 3).step_by(step);
        let pixels = noise(usize::from(width) * usize::from(height), width.into());
        for side in [Side::After, Side::Before] {
            let [pictures, low, high] = &mut guarded;
            let picture = Image::new(pictures.copy(&pixels, side), width, height).unwrap();
            let [low, high] =
                [low, high].map(|memory| memory.slice(stride * (tops.len() - 1) + usize::from(width) - 3, side));
            let to = RowsOfRanges { low, high, stride };
            if !scorer.ranges_of_rows(picture, step, to) {
                continue;
            }
            for ((top, low), high) in tops.clone().zip(low.chunks(stride)).zip(high.chunks(stride)) {
                let mut expected = Aligned([0; 4096]);
                let (lowest, highest) = expected.0.split_at_mut(2048);
                let rows = [0, 1, 2, 3].map(|row| picture.row(top + row));
                scorer.ranges(&rows, &mut lowest[..stride], &mut highest[..stride]);
                let columns = usize::from(width) - 3;
                assert_eq!(low[..columns], lowest[..columns], "{backend:?}: {width} columns, step {step}, row {top}");
                assert_eq!(high[..columns], highest[..columns], "{backend:?}: {width} columns, step {step}, row {top}");
            }
        }
    }
    let picture = noise(64 * 8, 1);
    let picture = Image::new(&picture, 64, 8).unwrap();
    let (mut low, mut high) = ([0; 64 * 5], [0; 64 * 4 + 60]);
    let to = RowsOfRanges { low: &mut low, high: &mut high, stride: 64 };
    assert!(!scorer.ranges_of_rows(picture, 1, to), "{backend:?}: there is too little room");
    let to = RowsOfRanges { low: &mut low, high: &mut high, stride: 60 };
    assert!(!scorer.ranges_of_rows(picture, 1, to), "{backend:?}: the rows are too short");
}

/// No offset that reaches the floor is excluded, for all widths, next to a forbidden page.
fn all_candidates(backend: Backend) {
    let mut guarded: [Guarded; 2] = core::array::from_fn(|_| Guarded::with_room(12 << 10));
    for width in 1..=EDGE {
        let (height, threshold) = (1 + width * 5 % 23, width % 40);
        let table = cut(threshold);
        let pixels = noise(usize::from(width + 3) * usize::from(height), width.into());
        let of_patch = Image::new(&pixels, width + 3, height).unwrap();
        for side in [Side::After, Side::Before] {
            let [for_patch, for_template] = &mut guarded;
            let patch = Image::new(for_patch.copy(&pixels, side), width + 3, height).unwrap();
            for best in 0..4 {
                let at = |column: u16| of_patch.crop(Rect::new(column.into(), 0, width, height)).unwrap();
                let template: Vec<u8> = at(best).rows().flatten().copied().collect();
                let template = for_template.copy(&close_to(&template, best.into()), side);
                let template = Image::new(template, width, height).unwrap();
                let scores = [0, 1, 2, 3].map(|column| plain::score(at(column), template, &table));
                let most = plain::most(template, template);
                for floor in scores.into_iter().chain([0, 1, scores[usize::from(best)] + 1, most]) {
                    let candidates = Scorer::new(backend, &table).candidates(patch, template, floor, ALL_FOUR);
                    for (offset, score) in scores.into_iter().enumerate() {
                        let is_candidate = candidates >> offset & 1 != 0;
                        let of =
                            || std::format!("{backend:?}: {width}x{height}, score {score} of {most}, floor {floor}");
                        assert!(is_candidate || score < floor, "{}", of());
                    }
                }
            }
        }
    }
}

/// Patches between two pictures: the bound is at least that of the plain loop, and valid if the two are equal.
fn all_ranges(backend: Backend) {
    let (one, two) = (noise(3600, 1), noise(3600, 2));
    for threshold in (0..=256u16).step_by(STEP) {
        let (width, height) = (1 + threshold % 60, 1 + threshold * 7 % 41);
        let ranges =
            one.iter().zip(&two).map(|(&one, &two)| (one, one.saturating_add(two % (1 + (threshold % 90) as u8))));
        let (low, high): (Vec<u8>, Vec<u8>) = ranges.unzip();
        let template = close_to(&low, threshold.into());
        let view = |pixels| Image::with_stride(pixels, width, height, 60).unwrap();
        let (low, high, template) = (view(&low), view(&high), view(&template));
        let table = cut(threshold);
        let scorer = Scorer::new(backend, &table);
        let most = plain::most(low, template);
        for floor in [0, 1, most / 2, most / 4 * 3, most] {
            let least = plain::score_between_at_least(low, high, template, &table, floor);
            let reached = scorer.score_between_at_least(low, high, template, floor);
            assert!(reached >= least, "{backend:?}: {reached:?} reached instead of {least:?}, floor {floor}");
            assert!(reached.is_none_or(|reached| floor <= reached && reached <= most), "{backend:?}: {reached:?}");
            // The only picture between a picture and itself is the picture.
            let score = plain::score(low, template, &table);
            let itself = scorer.score_between_at_least(low, low, template, floor);
            assert!(itself >= Some(score).filter(|&score| score >= floor), "{backend:?}: {itself:?}, {score}");
        }
    }
}

/// Memory for ranges.
#[repr(align(4))]
struct Aligned([u8; 4096]);

/// Templates within the ranges of a group, at every column: the bound is at least the score of each of the group's 16
/// offsets. The rows of the frame and the template touch a forbidden page.
fn all_groups(backend: Backend) {
    let mut guarded: [Guarded; 5] = core::array::from_fn(|_| Guarded::with_room(12 << 10));
    for width in 1..=EDGE {
        let (height, column) = (1 + width % 11, usize::from(width * 3 % 13));
        let (columns, below) = (column + usize::from(width), usize::from(height));
        let stride = columns.next_multiple_of(4);
        let seed = u32::from(width);
        let frame: Vec<_> = (0..below + 6).map(|row| calm(columns + 6, seed + row as u32)).collect();
        let table = cut(width % 40);
        let scorer = Scorer::new(backend, &table);
        for side in [Side::After, Side::Before] {
            let [rows @ .., for_template] = &mut guarded;
            let mut bytes = Aligned([0; 4096]);
            let (low, high) = bytes.0.split_at_mut(2048);
            let ranges = low.chunks_mut(stride).zip(high.chunks_mut(stride)).take(below + 3);
            for (row, (low, high)) in ranges.enumerate() {
                let mut of_frame = frame[row..].iter();
                let four = rows.each_mut().map(|memory| memory.copy(&of_frame.next().unwrap()[..columns + 3], side));
                scorer.ranges(&four, low, high);
            }
            let template: Vec<u8> = (2..)
                .zip(&frame[1..])
                .take(below)
                .flat_map(|(_, row)| row[column + 2..][..width.into()].to_vec())
                .collect();
            let template = Image::new(for_template.copy(&close_to(&template, seed), side), width, height).unwrap();
            for top in 0..3 {
                let blocks = Blocks { low, high, start: top * stride + column, stride };
                let scores = (0..16).map(|offset| {
                    let rows = frame[top + offset / 4..].iter().take(below);
                    let patch: Vec<u8> =
                        rows.flat_map(|row| row[column + offset % 4..][..width.into()].to_vec()).collect();
                    plain::score(Image::new(&patch, width, height).unwrap(), template, &table)
                });
                let (best, most) = (scores.max().unwrap(), plain::most(template, template));
                for floor in [0, 1, best, best + 1, best.midpoint(most), most] {
                    let bound = scorer.bound(&blocks, template, floor);
                    assert!(
                        bound.is_some() || best < floor,
                        "{backend:?}: {width}x{height}, score {best}, floor {floor}"
                    );
                    let right = bound.is_none_or(|bound| bound >= best.max(floor) && bound <= most);
                    assert!(right, "{backend:?}: {width}x{height}: {bound:?}, score {best}, floor {floor}");
                }
            }
        }
    }
}

/// Bytes of which neighbours are close to each other.
fn calm(length: usize, seed: u32) -> Vec<u8> {
    let mut level = 100u8;
    noise(length, seed)
        .iter()
        .map(|&step| {
            level = level.wrapping_add(step % 15).wrapping_sub(7);
            level
        })
        .collect()
}

/// Groups far from the template are excluded, at every column.
fn far_groups(backend: Backend) {
    let scorer_table = cut(13);
    let scorer = Scorer::new(backend, &scorer_table);
    for (width, column) in (16..=EDGE).zip((0..13).cycle()) {
        let (columns, height) = (column + usize::from(width), 9usize);
        let stride = columns.next_multiple_of(4);
        let mut bytes = Aligned([0; 4096]);
        let (low, high) = bytes.0.split_at_mut(2048);
        let row = std::vec![100; columns + 3];
        for (low, high) in low.chunks_mut(stride).zip(high.chunks_mut(stride)).take(height) {
            scorer.ranges(&[&row; 4], low, high);
        }
        let blocks = Blocks { low, high, start: column, stride };
        for (level, counts) in [(80, false), (87, false), (88, true), (112, true), (114, false), (130, false)] {
            let template = std::vec![level; usize::from(width) * height];
            let template = Image::new(&template, width, 9).unwrap();
            let most = plain::most(template, template);
            // The bound may leave out up to two rows.
            let bound = scorer.bound(&blocks, template, most / 4);
            assert_eq!(bound.is_some(), counts, "{backend:?}: {width}x{height} at column {column}, level {level}");
        }
    }
}

for_each_backend!(
    all_candidates,
    all_groups,
    far_groups,
    ranges_of_rows,
    all_sizes,
    all_thresholds_and_alignments,
    all_differences,
    extremes,
    bound,
    all_lengths_of_ranges,
    all_ranges
);
