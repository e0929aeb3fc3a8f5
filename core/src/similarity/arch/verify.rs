//! The plain loops beside a faster backend (feature `verify`): a difference is a panic that says what was asked.

use super::super::{Table, scalar};
use crate::image::Image;

/// The score that a backend gave for pictures, where it was asked for one of at least `floor`.
#[track_caller]
pub(super) fn score(
    answer: Option<u32>,
    (patch, template): (Image<'_>, Image<'_>),
    (table, threshold): (&Table, u16),
    floor: u32,
) {
    let expected = Some(scalar::score(patch, template, table, threshold)).filter(|&score| score >= floor);
    assert_eq!(
        answer, expected,
        "score of at least {floor} at threshold {threshold}, given and expected: {patch:?}, {template:?}"
    );
}

/// The distance that a backend gave, where it was asked for one of up to `enough`.
#[track_caller]
pub(super) fn distance(answer: u32, (patch, template): (Image<'_>, Image<'_>), enough: u32) {
    let exact = scalar::distance(patch, template, u32::MAX);
    let right = if exact <= enough { answer == exact } else { answer > enough && answer <= exact };
    assert!(right, "distance {answer} instead of {exact}, enough {enough}: {patch:?}, {template:?}");
}

/// The means that a backend gave.
#[track_caller]
pub(super) fn means(rows: &[&[u8]; 8], means: &[u8]) {
    for column in 0..rows.iter().map(|row| row.len()).min().unwrap_or(0).min(means.len()) {
        let mut expected = [0];
        scalar::means(&rows.map(|row| row.get(column..).unwrap_or_default()), &mut expected);
        assert_eq!(means.get(column), expected.first(), "mean of column {column}, given and expected");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: [u8; 4] = [10, 20, 30, 40];
    const OTHER: [u8; 4] = [10, 21, 30, 99];

    fn pictures() -> (Image<'static>, Image<'static>) {
        (Image::new(&ROW, 4, 1).unwrap(), Image::new(&OTHER, 4, 1).unwrap())
    }

    #[test]
    fn what_is_right_is_let_through() {
        let (patch, template) = pictures();
        let exact = scalar::score(patch, template, &Table::PAPER, 13);
        score(Some(exact), pictures(), (&Table::PAPER, 13), exact);
        score(None, pictures(), (&Table::PAPER, 13), exact + 1);
        distance(60, pictures(), 60);
        distance(7, pictures(), 6);
        means(&[&ROW; 8], &ROW);
    }

    #[test]
    #[should_panic(expected = "score of at least 1")]
    fn a_score_that_is_one_too_large_is_noticed() {
        let (patch, template) = pictures();
        let exact = scalar::score(patch, template, &Table::PAPER, 13);
        score(Some(exact + 1), pictures(), (&Table::PAPER, 13), 1);
    }

    #[test]
    #[should_panic(expected = "score of at least 1")]
    fn a_score_that_is_withheld_is_noticed() {
        score(None, pictures(), (&Table::PAPER, 13), 1);
    }

    #[test]
    #[should_panic(expected = "distance 6 instead of 60, enough 6")]
    fn a_distance_that_ends_too_early_is_noticed() {
        distance(6, pictures(), 6);
    }

    #[test]
    #[should_panic(expected = "mean of column 3")]
    fn a_wrong_mean_is_noticed() {
        means(&[&ROW; 8], &[10, 20, 30, 41]);
    }
}
