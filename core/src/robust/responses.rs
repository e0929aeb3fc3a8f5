//! The filter's responses around a place, and their peak.

use super::REACH;
use super::filter::Shape;
use super::grid::Grid;

/// Offsets on an axis, at most.
pub(super) const SPAN: usize = 2 * REACH as usize + 1;
/// At the search's edge a response counts so much less, in units of 1/256; in between by the square of the distance.
const FAR: i64 = 77;

/// Responses at all offsets up to a reach, row by row.
pub(super) struct Responses {
    pub(super) rows: [[i32; SPAN]; SPAN],
    /// Offsets on an axis.
    pub(super) span: usize,
}

/// The largest response: where, in units of 1/256 cell from the middle, and how large, in units of 1/16384.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Peak {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) response: i32,
}

impl Responses {
    /// Makes them row by row, of cells that reach so much further on each side than the filter.
    pub(super) fn make(&mut self, grid: &Grid, reach: u16, cells: &[i8], row: impl Fn(&[i8], Shape, &mut [i32])) {
        let shape = Shape::new(grid, reach);
        self.span = 2 * usize::from(reach) + 1;
        for (y, out) in self.rows.iter_mut().take(self.span).enumerate() {
            let cells = cells.get(y * shape.stride..).unwrap_or_default();
            row(cells, shape, out.get_mut(..self.span).unwrap_or_default());
        }
    }

    /// The first of the largest, with the top of a parabola through its neighbours on each axis. If `near` is to be preferred,
    /// positive responses of a whole search far from the middle count less.
    pub(super) fn peak(&self, near: bool) -> Peak {
        let counts = |x: usize, y: usize, response: i32| if near { nearer(x, y, response) } else { response };
        let (mut response, mut x, mut y) = (i32::MIN, 0, 0);
        for (down, row) in self.rows.iter().take(self.span).enumerate() {
            for (right, &candidate) in row.iter().take(self.span).enumerate() {
                let candidate = counts(right, down, candidate);
                if candidate > response {
                    (response, x, y) = (candidate, right, down);
                }
            }
        }
        let at = |x: Option<usize>, y: Option<usize>| {
            let (x, y) = (x.filter(|&x| x < self.span)?, y.filter(|&y| y < self.span)?);
            Some(counts(x, y, *self.rows.get(y)?.get(x)?))
        };
        let part = |before: Option<i32>, after: Option<i32>| match (before, after) {
            (Some(before), Some(after)) => top(before, response, after),
            _ => 0,
        };
        let right = part(at(x.checked_sub(1), Some(y)), at(Some(x + 1), Some(y)));
        let down = part(at(Some(x), y.checked_sub(1)), at(Some(x), Some(y + 1)));
        let cells = |at: usize| i32::try_from(2 * at + 1).unwrap_or(0) - i32::try_from(self.span).unwrap_or(0);
        Peak { x: 128 * cells(x) + right, y: 128 * cells(y) + down, response }
    }
}

/// What a response counts at an offset of a whole search.
fn nearer(x: usize, y: usize, response: i32) -> i32 {
    let away = |at: usize| i64::try_from(at).map_or(0, |at| (at - i64::from(REACH)).pow(2));
    let part = 256 - ((FAR * (away(x) + away(y)).min(64)) >> 6);
    let less = (i64::from(response.max(0)) * part) >> 8;
    i32::try_from(less).unwrap_or(0) + response.min(0)
}

/// Where between its neighbours a maximum lies, in units of 1/256 of their distance, -128 to 128: the top of the parabola
/// through three responses one apart. 0 if the middle one is no maximum.
fn top(before: i32, at: i32, after: i32) -> i32 {
    // Responses are below 2^24.
    let bend = before - 2 * at + after;
    if bend >= 0 {
        return 0;
    }
    let top = i64::from(before - after) * 128 / i64::from(bend);
    i32::try_from(top.clamp(-128, 128)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_parabola() {
        let parabola = |top: i32, x: i32| 1_000_000 - (x * 256 - top).pow(2);
        for at in [-127, -1, 0, 1, 77, 128] {
            let found = top(parabola(at, -1), parabola(at, 0), parabola(at, 1));
            assert!((found - at).abs() <= 1, "{at}: {found}");
        }
        assert_eq!([top(5, 5, 5), top(9, 5, 9), top(1 << 24, 1 << 24, -(1 << 24))], [0, 0, -128]);
        assert_eq!(top(-(1 << 24), 1 << 24, -(1 << 24)), 0);
    }

    #[test]
    fn a_peak_is_told_from_the_middle() {
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        responses.rows[3][10] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512, y: -5 * 256, response: 900 });
        responses.rows[3][11] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512 + 128, y: -5 * 256, response: 900 });
        responses.span = 3;
        responses.rows[0][0] = 5;
        assert_eq!(responses.peak(false), Peak { x: -256, y: -256, response: 5 });
    }

    #[test]
    fn far_responses_count_less() {
        let less = |x: usize, y: usize| nearer(x, y, 1 << 24);
        assert_eq!([less(8, 8), less(0, 0), less(0, 8), less(8, 4)], [1 << 24, 179 << 16, 179 << 16, 237 << 16]);
        assert_eq!(nearer(0, 1, -256), -256);
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        (responses.rows[0][0], responses.rows[8][8]) = (1000, 800);
        assert_eq!([responses.peak(false).response, responses.peak(true).response], [1000, 800]);
    }
}
