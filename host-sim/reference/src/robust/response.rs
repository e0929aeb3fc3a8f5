//! The filter's responses at all offsets of a search window, and their peak.

use super::Numbers;
use super::gradients::Cells;
use super::learning::ScaledIntegers;
use super::rounding::{FINE, index, quotient, to_f64, to_zero};
use super::sampling::Shape;

/// Filter responses at all offsets up to `reach` cells from the middle, row by row.
pub fn responses(shape: &Shape, weights: &ScaledIntegers, cells: &Cells, reach: i64) -> Vec<f64> {
    let span = 2 * reach + 1;
    (0..span).flat_map(|y| (0..span).map(move |x| weights.response(shape, cells, x, y))).collect()
}

/// Reduces positive responses by a fraction that grows with the squared distance from the middle, up to
/// `distance_penalty` / 256 at `reach` cells and beyond. Fraction (in 256ths) and result are rounded down.
pub fn penalised(numbers: &Numbers, responses: &[f64], reach: i64) -> Vec<f64> {
    let span = 2 * reach + 1;
    let away = |at: i64| (at % span - reach).pow(2) + (at / span - reach).pow(2);
    let less = |(at, &response): (i64, &f64)| {
        let edge = to_f64(reach * reach);
        let part = FINE - (numbers.distance_penalty * to_f64(away(at)).min(edge) / edge).floor();
        if response > 0.0 { (response * part / FINE).floor() } else { response }
    };
    (0..).zip(responses).map(less).collect()
}

/// Largest response. Ties go to the offset in the middle, else to the first in row order.
pub struct Peak {
    /// Offset from the middle in cells, interpolated by a parabola on each axis.
    pub x: f64,
    pub y: f64,
    pub response: f64,
    /// Largest response plus the height of each axis's parabola above it.
    pub height: f64,
}

pub fn peak(responses: &[f64], reach: i64) -> Peak {
    let span = 2 * reach + 1;
    let response = responses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let first = responses.iter().position(|&other| other == response).expect("there are offsets");
    let first = i64::try_from(first).expect("places are far below 2^63");
    let middle = reach * span + reach;
    let best = if responses[index(middle)] == response { middle } else { first };
    let (x, y) = (best % span, best / span);
    let at = |x: i64, y: i64| {
        let inside = (0..span).contains(&x) && (0..span).contains(&y);
        inside.then(|| responses[index(y * span + x)])
    };
    let part = |before: Option<f64>, after: Option<f64>| match (before, after) {
        (Some(before), Some(after)) => parabola_top(before, response, after),
        _ => (0.0, 0.0),
    };
    let (across, wider) = part(at(x - 1, y), at(x + 1, y));
    let (down, deeper) = part(at(x, y - 1), at(x, y + 1));
    Peak { x: to_f64(x - reach) + across, y: to_f64(y - reach) + down, response, height: response + wider + deeper }
}

/// Top of the parabola through three neighbouring responses: distance from the middle response (at most 1/2, rounded
/// toward 0 to 1/256) and height above the middle response (rounded down). Both are 0 if the parabola has no top.
fn parabola_top(before: f64, at: f64, after: f64) -> (f64, f64) {
    let bend = before - 2.0 * at + after;
    if bend >= 0.0 {
        return (0.0, 0.0);
    }
    let difference = before - after;
    (to_zero(difference / 2.0 / bend, FINE).clamp(-0.5, 0.5), quotient(difference * difference, -8.0 * bend))
}
