//! Compares a backend with the plain loops (feature `verify`). A difference panics with a message that names the call.

#[cfg(not(any(smr_dsp, smr_helium)))]
use super::super::blocks::{Blocks, RowsOfRanges};
use super::super::cut_table::CutTable;
use super::super::plain::scores as plain;
use crate::image::{Image, Rect};
use core::slice;

/// Checks a score of at least `floor`.
#[track_caller]
pub(crate) fn score(answer: Option<u32>, (patch, template): (Image<'_>, Image<'_>), table: &CutTable, floor: u32) {
    let expected = Some(plain::score(patch, template, table)).filter(|&score| score >= floor);
    assert_eq!(
        answer,
        expected,
        "score of at least {floor} at threshold {}, given and expected: {patch:?}, {template:?}",
        table.threshold()
    );
}

/// Checks a distance up to `enough`.
#[track_caller]
pub(crate) fn distance(answer: u32, (patch, template): (Image<'_>, Image<'_>), enough: u32) {
    let exact = plain::distance(patch, template, u32::MAX);
    let right = if exact <= enough { answer == exact } else { answer > enough && answer <= exact };
    assert!(right, "distance {answer} instead of {exact}, enough {enough}: {patch:?}, {template:?}");
}

/// Checks the bound of a patch between two pictures.
#[track_caller]
pub(crate) fn score_between(
    answer: Option<u32>,
    (low, high, template): (Image<'_>, Image<'_>, Image<'_>),
    table: &CutTable,
    floor: u32,
) {
    let least = plain::score_between_at_least(low, high, template, table, floor);
    let right = answer.is_none_or(|answer| answer >= floor) && answer >= least;
    assert!(
        right,
        "at threshold {} {answer:?} reached instead of {least:?}, floor {floor}: {template:?}",
        table.threshold()
    );
}

/// Checks which of four offsets may reach `floor`.
#[track_caller]
pub(crate) fn candidates(answer: u8, (patch, template): (Image<'_>, Image<'_>), table: &CutTable, floor: u32) {
    for (column, offset) in (0..patch.width().saturating_sub(template.width()).min(3) + 1).zip(0..) {
        let within = Rect::new(column.into(), 0, template.width(), template.height());
        let score = patch.crop(within).map_or(u32::MAX, |patch| plain::score(patch, template, table));
        assert!(
            answer >> offset & 1 != 0 || score < floor,
            "offset {offset} scores {score} and was excluded by the floor {floor}: {patch:?}, {template:?}"
        );
    }
}

/// Checks ranges.
#[track_caller]
pub(crate) fn spread(rows: &[&[u8]; 4], low: &[u8], high: &[u8]) {
    ranges(rows, low, high, |lowest, highest| (lowest, highest));
}

/// Checks the ranges of `swar/scores.rs`.
#[cfg(not(any(smr_dsp, smr_helium)))]
#[track_caller]
pub(crate) fn widened_ranges(rows: &[&[u8]; 4], table: &CutTable, low: &[u8], high: &[u8]) {
    let half = |level: u8| (level / 2).saturating_sub(u8::try_from(table.threshold() / 2).unwrap_or(u8::MAX));
    ranges(rows, low, high, |lowest, highest| (half(lowest), half(u8::MAX - highest)));
}

/// Checks the ranges of `generic.rs`.
#[cfg(not(any(smr_dsp, smr_helium)))]
#[track_caller]
pub(crate) fn spans(rows: &[&[u8]; 4], table: &CutTable, low: &[u8], high: &[u8]) {
    let last = u8::try_from(table.threshold().saturating_sub(1)).unwrap_or(u8::MAX);
    ranges(rows, low, high, |lowest, highest| {
        let (low, high) = (lowest.saturating_sub(last), highest.saturating_add(last));
        (low.wrapping_sub(128), (high - low).wrapping_sub(128))
    });
}

/// Checks what is stored for each block. `stored` makes it of the lowest and the highest pixel.
#[track_caller]
fn ranges(rows: &[&[u8]; 4], low: &[u8], high: &[u8], stored: impl Fn(u8, u8) -> (u8, u8)) {
    for (column, (&low, &high)) in low.iter().zip(high).enumerate() {
        let block = rows.map(|row| row.get(column..column + 4).unwrap_or_default());
        if block.iter().any(|row| row.is_empty()) {
            return;
        }
        let (mut lowest, mut highest) = (0, 0);
        plain::spread(&block, slice::from_mut(&mut lowest), slice::from_mut(&mut highest));
        assert_eq!(stored(lowest, highest), (low, high), "range of column {column}, expected and given");
    }
}

/// Checks the ranges of several rows of `generic.rs`.
#[cfg(not(any(smr_dsp, smr_helium)))]
#[track_caller]
pub(crate) fn rows_of_spans(pixels: Image<'_>, step: usize, table: &CutTable, to: &RowsOfRanges<'_>) {
    let tops = (0..pixels.height().saturating_sub(3)).step_by(step);
    for ((top, low), high) in tops.zip(to.low.chunks(to.stride)).zip(to.high.chunks(to.stride)) {
        let rows = [0, 1, 2, 3].map(|row| pixels.row(top + row));
        spans(&rows, table, low, high);
    }
}

/// True if a pixel counts in a range of `generic.rs`.
#[cfg(not(any(smr_dsp, smr_helium)))]
pub(crate) fn is_in_span(low: u8, span: u8, g: u8) -> bool {
    g.wrapping_sub(low.wrapping_add(128)) <= span.wrapping_add(128)
}

/// True if a pixel counts in a range of `swar/scores.rs`.
#[cfg(not(any(smr_dsp, smr_helium)))]
pub(crate) fn is_in_widened(low: u8, high: u8, g: u8) -> bool {
    low <= g / 2 && high <= (u8::MAX - g) / 2
}

/// Checks a bound: at least the number of pixels of the template that count in their ranges.
#[cfg(not(any(smr_dsp, smr_helium)))]
#[track_caller]
pub(crate) fn bound(
    answer: Option<u32>,
    (blocks, template): (&Blocks<'_>, Image<'_>),
    table: &CutTable,
    floor: u32,
    counts: fn(u8, u8, u8) -> bool,
) {
    let Some((low, high)) = blocks.pictures(template) else { return };
    let rows = low.rows().zip(high.rows()).zip(template.rows());
    let of_row = |((low, high), g): ((&[u8], &[u8]), &[u8])| {
        low.iter().zip(high).zip(g).filter(|&((&low, &high), &g)| counts(low, high, g)).count()
    };
    let inside = rows.map(of_row).sum();
    let least = if table.threshold() == 0 { 0 } else { plain::full(inside) };
    let right = answer.map_or(least < floor, |answer| answer >= floor.max(least));
    assert!(right, "{answer:?} reached instead of {least}, floor {floor}: {template:?}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::tests::table::cut;

    const ROW: [u8; 4] = [10, 20, 30, 40];
    const OTHER: [u8; 4] = [10, 21, 30, 99];

    fn view(row: &[u8; 4]) -> Image<'_> {
        Image::new(row, 4, 1).unwrap()
    }

    fn pictures() -> (Image<'static>, Image<'static>) {
        (view(&ROW), view(&OTHER))
    }

    #[test]
    fn what_is_right_is_let_through() {
        let (patch, template) = pictures();
        let exact = plain::score(patch, template, &cut(13));
        score(Some(exact), pictures(), &cut(13), exact);
        score(None, pictures(), &cut(13), exact + 1);
        distance(60, pictures(), 60);
        distance(7, pictures(), 6);
        score_between(Some(4 * 65535), (view(&ROW), view(&OTHER), view(&OTHER)), &cut(13), 1);
        score_between(None, (view(&ROW), view(&ROW), view(&OTHER)), &cut(13), 4 * 65535);
        spread(&[&ROW; 4], &[10], &[40]);
    }

    #[test]
    #[should_panic(expected = "score of at least 1")]
    fn a_score_that_is_one_too_large_is_noticed() {
        let (patch, template) = pictures();
        let exact = plain::score(patch, template, &cut(13));
        score(Some(exact + 1), pictures(), &cut(13), 1);
    }

    #[test]
    #[should_panic(expected = "score of at least 1")]
    fn a_score_that_is_withheld_is_noticed() {
        score(None, pictures(), &cut(13), 1);
    }

    #[test]
    #[should_panic(expected = "distance 6 instead of 60, enough 6")]
    fn a_distance_that_ends_too_early_is_noticed() {
        distance(6, pictures(), 6);
    }

    #[test]
    #[should_panic(expected = "reached instead of")]
    fn a_bound_that_is_too_low_is_noticed() {
        score_between(Some(4 * 65535 - 1), (view(&ROW), view(&OTHER), view(&OTHER)), &cut(13), 1);
    }

    #[test]
    #[should_panic(expected = "range of column 0")]
    fn a_wrong_range_is_noticed() {
        spread(&[&ROW; 4], &[10], &[39]);
    }
}
