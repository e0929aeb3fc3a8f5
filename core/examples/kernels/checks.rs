//! Compares every kernel with the plain loop that specifies it.

use crate::memory::{Memory, ROOM};
use smr_core::similarity::{Backend, CutTable, Scorer, Table};
use smr_core::unstable::{candidates, group_bound, ranges, spread};
use smr_core::{Image, Rect};

/// The steepest table, one in between, and the paper's.
static TABLES: [Table; 3] = [table(1), table(40), Table::PAPER];

const fn table(scale: u16) -> Table {
    match Table::new(scale) {
        Ok(table) => table,
        Err(_) => Table::PAPER,
    }
}

/// The comparisons of one backend, and how many were made.
pub struct Checks {
    pub backend: Backend,
    pub compared: u32,
}

/// A result that differs from the plain loop's.
pub struct Difference {
    pub what: &'static str,
    pub width: usize,
    pub height: usize,
    pub threshold: u16,
}

/// Bytes that begin at a multiple of four.
#[repr(align(4))]
struct Words([u8; 240]);

type Outcome = Result<(), Difference>;

/// The size of two pictures, and the stride of each.
#[derive(Clone, Copy)]
struct Shape {
    width: u16,
    height: u16,
    strides: (usize, usize),
}

impl Checks {
    pub fn all(&mut self, memory: &mut Memory) -> Outcome {
        noise(memory.end, memory.other_end, memory.start);
        for width in 1..=70 {
            for height in [1, 2, 3, 8, 13] {
                self.size(width, height, memory)?;
            }
        }
        for width in [127, 128, 129, 255, 256, 257, 1000, 1021, 1024, 4099] {
            self.size(width, 3, memory)?;
        }
        for threshold in 0..=256 {
            self.alignments(threshold, memory)?;
        }
        for (width, height) in (1..=150).flat_map(|width| [1, 2, 5].map(|height| (width, height))) {
            for gap in 0..3 {
                let strides = (usize::from(width) + gap, usize::from(width) + 2 * gap);
                self.between(memory, Shape { width, height, strides }, (width * 7 + height * 13) % 257)?;
            }
        }
        for (width, height) in (1..=40).flat_map(|width| [1, 2, 6].map(|height| (width, height))) {
            for threshold in [0, 1, 2, 13, 64, 255, 256] {
                self.candidates(memory, width, height, threshold)?;
                self.group(memory, width, height, threshold)?;
            }
        }
        (0..=200).try_for_each(|columns| self.spread(columns, memory))
    }

    /// Compares the offsets that may reach a score: every offset that reaches it is among them, and not all four are if
    /// none comes near it.
    fn candidates(&mut self, memory: &Memory, width: u16, height: u16, threshold: u16) -> Outcome {
        let wrong = |what| Difference { what, width: width.into(), height: height.into(), threshold };
        let shape = |width| Shape { width, height, strides: (0, 0) };
        let patch = picture(memory.end, usize::from(width) + 3, shape(width + 3), true);
        let template = picture(memory.other_end, width.into(), shape(width), true);
        let (patch, template) = patch.zip(template).ok_or(wrong("no picture"))?;
        let table = TABLES.get(usize::from((width + height) % 3)).unwrap_or(&Table::PAPER);
        let table = CutTable::new(table, threshold);
        let plain = Scorer::new(Backend::Scalar, &table);
        let score = |offset: u8| {
            let patch = patch.crop(Rect::new(offset.into(), 0, width, height))?;
            plain.score(patch, template)
        };
        let most = u32::from(width) * u32::from(height) * u32::from(Table::ONE);
        for floor in (0..4).filter_map(score).flat_map(|score| [score, score.saturating_sub(1)]).chain([0, most]) {
            let answer = candidates(&Scorer::new(self.backend, &table), patch, template, floor);
            let right = (0..4).all(|offset| answer >> offset & 1 != 0 || score(offset) < Some(floor));
            self.compare(right).ok_or(wrong("candidates"))?;
        }
        // Other backends let all four through.
        let excludes = matches!(self.backend, Backend::Dsp | Backend::Helium);
        if excludes && width >= 16 && (1..=13).contains(&threshold) {
            let answer = candidates(&Scorer::new(self.backend, &table), patch, template, most);
            self.compare(answer != 0b1111).ok_or(wrong("candidates that are none"))?;
        }
        Ok(())
    }

    /// Compares the bound of a group with the scores of its 16 offsets.
    fn group(&mut self, memory: &Memory, width: u16, height: u16, threshold: u16) -> Outcome {
        let wrong = |what| Difference { what, width: width.into(), height: height.into(), threshold };
        let frame = Shape { width: width + 3, height: height + 3, strides: (0, 0) };
        let frame = picture(memory.end, frame.width.into(), frame, true).ok_or(wrong("no picture"))?;
        let shape = Shape { width, height, strides: (0, 0) };
        let template = picture(memory.other_end, width.into(), shape, false).ok_or(wrong("no picture"))?;
        let table = CutTable::new(&Table::PAPER, threshold);
        let (scorer, plain) = (Scorer::new(self.backend, &table), Scorer::new(Backend::Scalar, &table));
        let stride = usize::from(width).next_multiple_of(4);
        let (mut low, mut high) = (Words([0; 240]), Words([0; 240]));
        let rows = low.0.chunks_mut(stride).zip(high.0.chunks_mut(stride));
        for (y, (low, high)) in (0..height).zip(rows) {
            ranges(&scorer, &[0, 1, 2, 3].map(|row| frame.row(y + row)), low, high);
        }
        let bound = |floor| group_bound(&scorer, (&low.0, &high.0), stride, template, floor);
        let score = |at: i32| plain.score(frame.crop(Rect::new(at % 4, at / 4, width, height))?, template);
        let best = (0..16).filter_map(score).max().ok_or(wrong("no score"))?;
        for floor in [0, best / 2, best] {
            self.compare(bound(floor) >= Some(best)).ok_or(wrong("bound of a group"))?;
        }
        self.compare(bound(best + 1).is_none_or(|least| least > best)).ok_or(wrong("bound of a group above its floor"))
    }

    /// Compares pictures at both ends of the memory and at its start, with and without gaps between the rows.
    fn size(&mut self, width: u16, height: u16, memory: &Memory) -> Outcome {
        let threshold = 1 + (width * 7 + height * 13) % 255;
        for gap in 0..3 {
            let strides = (usize::from(width) + gap, usize::from(width) + 2 * gap);
            let shape = Shape { width, height, strides };
            self.pair(memory.end, memory.other_end, true, shape, threshold)?;
            self.pair(memory.start, memory.end, false, shape, threshold)?;
            self.pair(memory.end, memory.start, false, shape, threshold)?;
        }
        Ok(())
    }

    fn alignments(&mut self, threshold: u16, memory: &Memory) -> Outcome {
        for (from, other) in (0..4).flat_map(|from| (0..4).map(move |other| (from, other))) {
            let shape = Shape { width: 21 + threshold % 4, height: 3, strides: (31, 40) };
            let (patch, template) = (memory.end.get(from..), memory.other_end.get(other..));
            self.pair(patch.unwrap_or_default(), template.unwrap_or_default(), false, shape, threshold)?;
        }
        Ok(())
    }

    /// Compares scores and distances of two pictures: at the end of their memory if `last`, else at its start.
    fn pair(&mut self, patch: &[u8], template: &[u8], last: bool, shape: Shape, threshold: u16) -> Outcome {
        let wrong = |what| Difference { what, width: shape.width.into(), height: shape.height.into(), threshold };
        let view = |memory, stride| picture(memory, stride, shape, last).ok_or(wrong("no picture"));
        let (patch, template) = (view(patch, shape.strides.0)?, view(template, shape.strides.1)?);
        let table = TABLES.get(usize::from((shape.height + threshold) % 3)).unwrap_or(&Table::PAPER);
        let table = CutTable::new(table, threshold);
        let (scorer, plain) = (Scorer::new(self.backend, &table), Scorer::new(Backend::Scalar, &table));
        let score = plain.score(patch, template).ok_or(wrong("too large"))?;
        let most = u32::from(shape.width) * u32::from(shape.height) * u32::from(Table::ONE);
        for floor in [0, 1, score / 2, score.saturating_sub(1), score, score + 1, score.midpoint(most), most, u32::MAX]
        {
            let expected = Some(score).filter(|&score| score >= floor);
            self.compare(scorer.score_at_least(patch, template, floor) == expected).ok_or(wrong("score"))?;
        }
        let distance = plain.distance(patch, template, u32::MAX).ok_or(wrong("too large"))?;
        for enough in [0, distance / 3, distance.saturating_sub(1), distance, distance + 1, u32::MAX] {
            let answer = scorer.distance(patch, template, enough).ok_or(wrong("distance"))?;
            let right = if distance <= enough { answer == distance } else { answer > enough && answer <= distance };
            self.compare(right).ok_or(wrong("distance"))?;
        }
        Ok(())
    }

    /// Compares the upper bound for patches between two pictures: it is at least the plain loop's, and at most the
    /// score of equal pictures.
    fn between(&mut self, memory: &mut Memory, shape: Shape, threshold: u16) -> Outcome {
        let wrong = |what| Difference { what, width: shape.width.into(), height: shape.height.into(), threshold };
        let bytes = (usize::from(shape.height) - 1) * shape.strides.0 + usize::from(shape.width);
        let from = ROOM - 2 * bytes;
        let both = memory.end.get_mut(from..).unwrap_or_default();
        let (below, above) = both.split_at_mut_checked(bytes).unwrap_or_default();
        for (below, above) in below.iter_mut().zip(above.iter_mut()) {
            (*below, *above) = ((*below).min(*above), (*below).max(*above));
        }
        let view = |pixels, stride| Image::with_stride(pixels, shape.width, shape.height, stride).ok();
        let template = memory.other_end.get(from..).unwrap_or_default();
        let pictures = (view(below, shape.strides.0), view(above, shape.strides.0), view(template, shape.strides.1));
        let (Some(below), Some(above), Some(template)) = pictures else { return Err(wrong("no picture")) };
        let table = TABLES.get(usize::from((shape.height + threshold) % 3)).unwrap_or(&Table::PAPER);
        let table = CutTable::new(table, threshold);
        let (scorer, plain) = (Scorer::new(self.backend, &table), Scorer::new(Backend::Scalar, &table));
        let most = u32::from(shape.width) * u32::from(shape.height) * u32::from(Table::ONE);
        for (low, high) in [(below, above), (above, above)] {
            let exact = plain.score_between_at_least(low, high, template, 0).unwrap_or(0);
            for floor in [0, 1, exact / 2, exact, exact + 1, exact.midpoint(most), most] {
                let answer = scorer.score_between_at_least(low, high, template, floor);
                let right = match answer {
                    Some(answer) => answer >= exact.max(floor) && answer <= most,
                    None => exact < floor,
                };
                self.compare(right).ok_or(wrong("score between"))?;
            }
        }
        Ok(())
    }

    /// Compares the minima and maxima of four rows. One of the rows and the output lie at the edge of the memory. Every
    /// row has another alignment, and one of them may be shorter.
    fn spread(&mut self, columns: usize, memory: &mut Memory) -> Outcome {
        let wrong = |what| Difference { what, width: columns, height: 4, threshold: 0 };
        let table = CutTable::new(&Table::PAPER, 13);
        let (scorer, plain) = (Scorer::new(self.backend, &table), Scorer::new(Backend::Scalar, &table));
        for at_edge in 0..4 {
            let mut rows: [&[u8]; 4] = core::array::from_fn(|row| {
                let missing = usize::from(row == columns % 8).min(columns);
                part(memory.other_end, row * 301, columns + 3 - missing)
            });
            if let Some(row) = rows.get_mut(at_edge) {
                *row = part(memory.end, ROOM - columns - 3, columns + 3);
            }
            // The output lies at the start of the memory. The noise after it must not change.
            let mut low: [u8; 256] = memory.start.first_chunk().copied().ok_or(wrong("no room"))?;
            let mut high: [u8; 256] = memory.start.last_chunk().copied().ok_or(wrong("no room"))?;
            let (lows, highs) = memory.start.split_at_mut_checked(ROOM - 256).ok_or(wrong("no room"))?;
            spread(
                &plain,
                &rows,
                low.get_mut(..columns).unwrap_or_default(),
                high.get_mut(..columns).unwrap_or_default(),
            );
            spread(
                &scorer,
                &rows,
                lows.get_mut(..columns).unwrap_or_default(),
                highs.get_mut(..columns).unwrap_or_default(),
            );
            self.compare(lows.starts_with(&low) && *highs == high).ok_or(wrong("spread"))?;
        }
        Ok(())
    }

    fn compare(&mut self, right: bool) -> Option<()> {
        self.compared += 1;
        right.then_some(())
    }
}

fn part(memory: &[u8], from: usize, length: usize) -> &[u8] {
    memory.get(from..).and_then(|memory| memory.get(..length)).unwrap_or_default()
}

fn picture(memory: &[u8], stride: usize, shape: Shape, last: bool) -> Option<Image<'_>> {
    let bytes = (usize::from(shape.height) - 1) * stride + usize::from(shape.width);
    let from = if last { memory.len().checked_sub(bytes)? } else { 0 };
    Image::with_stride(memory.get(from..)?, shape.width, shape.height, stride).ok()
}

/// Fills the memory with pseudorandom bytes, the same in every run. The bytes of the second area are close to those of
/// the first and the third, so that differences lie on both sides of any threshold.
fn noise(first: &mut [u8], second: &mut [u8], third: &mut [u8]) {
    let mut state = 1u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    for ((first, second), third) in first.iter_mut().zip(second).zip(third) {
        let [base, offset, other, sign] = next().to_le_bytes();
        // Most differences are small, some are large.
        let [near, far] =
            [offset % (2 + other % 64), other].map(|by| if sign & 1 == 0 { by } else { by.wrapping_neg() });
        *first = base;
        *second = base.wrapping_add(near);
        *third = if sign > 200 { base.wrapping_add(far) } else { base.wrapping_sub(near) };
    }
}
