//! The filter's responses around a place, and their peak.

use super::REACH;

/// Offsets on an axis, at most.
pub(super) const SPAN: usize = 2 * REACH as usize + 1;
/// At the search's edge a response counts so much less, in units of 1/256; in between by the square of the distance.
const FAR: u32 = 77;

/// Responses at all offsets up to a reach, row by row.
pub(super) struct Responses {
    pub(super) rows: [[i32; SPAN]; SPAN],
    /// Offsets on an axis.
    pub(super) span: usize,
}

/// The largest response: where, in units of 1/256 cell from the middle, how large, in units of 1/16384, and how high the tops
/// of the parabolas through it are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Peak {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) response: i32,
    pub(super) height: i32,
}

impl Responses {
    /// See [`peak`].
    pub(super) fn peak(&self, near: bool) -> Peak {
        peak(&self.rows, self.span, near)
    }
}

/// The largest of the responses at so many offsets on an axis, with the top of a parabola through its neighbours on each axis. Of equals
/// the middle one, or the first: where nothing is seen, as in a black frame, the place stays. If `near` is to be preferred, positive responses of a whole search far from the middle count less.
#[inline(never)] // one copy in flash
pub(super) fn peak(rows: &[[i32; SPAN]], span: usize, near: bool) -> Peak {
    let counts = |x: usize, y: usize, response: i32| if near { nearer(x, y, span, response) } else { response };
    let (mut x, mut y) = (span / 2, span / 2);
    let mut response = rows.get(y).and_then(|row| row.get(x)).map_or(i32::MIN, |&middle| counts(x, y, middle));
    for (down, row) in rows.iter().take(span).enumerate() {
        for (right, &candidate) in row.iter().take(span).enumerate() {
            // It counts no more than it is.
            let counted = if candidate > response { counts(right, down, candidate) } else { candidate };
            if counted > response {
                (response, x, y) = (counted, right, down);
            }
        }
    }
    let at = |x: Option<usize>, y: Option<usize>| {
        let (x, y) = (x.filter(|&x| x < span)?, y.filter(|&y| y < span)?);
        Some(counts(x, y, *rows.get(y)?.get(x)?))
    };
    let part = |before: Option<i32>, after: Option<i32>| match (before, after) {
        (Some(before), Some(after)) => top(before, response, after),
        _ => (0, 0),
    };
    let (right, across) = part(at(x.checked_sub(1), Some(y)), at(Some(x + 1), Some(y)));
    let (below, down) = part(at(Some(x), y.checked_sub(1)), at(Some(x), Some(y + 1)));
    let cells = |at: usize| i32::try_from(2 * at + 1).unwrap_or(0) - i32::try_from(span).unwrap_or(0);
    let height = response.saturating_add(across).saturating_add(down);
    Peak { x: 128 * cells(x) + right, y: 128 * cells(y) + below, response, height }
}

/// What a response counts at an offset of a whole search.
#[inline(never)] // one copy in flash
fn nearer(x: usize, y: usize, span: usize, response: i32) -> i32 {
    let reach = u32::try_from(span / 2).unwrap_or(0);
    let away = |at: usize| u32::try_from(at).map_or(0, |at| at.abs_diff(reach).pow(2));
    let edge = (reach * reach).max(1);
    let part = 256 - FAR * (away(x) + away(y)).min(edge) / edge;
    let less = (i64::from(response.max(0)) * i64::from(part)) >> 8;
    i32::try_from(less).unwrap_or(0) + response.min(0)
}

/// Where between its neighbours a maximum lies, in units of 1/256 of their distance, -128 to 128: the top of the parabola
/// through three responses one apart; and by how much it is higher than the middle one. 0 if that is no maximum.
#[inline(never)] // one copy in flash
fn top(before: i32, at: i32, after: i32) -> (i32, i32) {
    // Responses are below 2^24.
    let bend = before - 2 * at + after;
    if bend >= 0 {
        return (0, 0);
    }
    let (difference, bend) = (i64::from(before - after), i64::from(bend));
    // The neighbours are not larger, so the difference is not beyond the bend; its square is below 2^50.
    let (top, higher) = ((difference * 128 / bend).clamp(-128, 128), difference.pow(2) / (-8 * bend));
    (i32::try_from(top).unwrap_or(0), i32::try_from(higher).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_parabola() {
        let parabola = |top: i32, x: i32| 1_000_000 - (x * 256 - top).pow(2);
        for at in [-127, -1, 0, 1, 77, 128] {
            let (found, higher) = top(parabola(at, -1), parabola(at, 0), parabola(at, 1));
            assert!((found - at).abs() <= 1, "{at}: {found}");
            assert!((higher - at.pow(2)).abs() <= 1, "{at}: {higher}");
        }
        assert_eq!([top(5, 5, 5), top(9, 5, 9), top(-(1 << 24), 1 << 24, -(1 << 24))], [(0, 0); 3]);
        assert_eq!(top(1 << 24, 1 << 24, -(1 << 24)), (-128, 1 << 22));
    }

    #[test]
    fn a_peak_is_told_from_the_middle() {
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        responses.rows[3][10] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512, y: -5 * 256, response: 900, height: 900 });
        responses.rows[3][11] = 900;
        assert_eq!(responses.peak(false), Peak { x: 512 + 128, y: -5 * 256, response: 900, height: 1012 });
        responses.span = 3;
        responses.rows[0][0] = 5;
        assert_eq!(responses.peak(false), Peak { x: -256, y: -256, response: 5, height: 5 });
    }

    #[test]
    fn where_all_respond_alike_the_middle_is_the_peak() {
        for response in [-5, 0] {
            let responses = Responses { rows: [[response; SPAN]; SPAN], span: SPAN };
            for near in [false, true] {
                assert_eq!(responses.peak(near), Peak { x: 0, y: 0, response, height: response });
            }
        }
    }

    #[test]
    fn far_responses_count_less() {
        let less = |x: usize, y: usize| nearer(x, y, SPAN, 1 << 24);
        assert_eq!([less(8, 8), less(0, 0), less(0, 8), less(8, 4)], [1 << 24, 179 << 16, 179 << 16, 237 << 16]);
        assert_eq!(nearer(0, 1, SPAN, -256), -256);
        let mut responses = Responses { rows: [[0; SPAN]; SPAN], span: SPAN };
        (responses.rows[0][0], responses.rows[8][8]) = (1000, 800);
        assert_eq!([responses.peak(false).response, responses.peak(true).response], [1000, 800]);
    }
}
