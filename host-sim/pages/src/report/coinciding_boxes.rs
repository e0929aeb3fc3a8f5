//! Boxes that coincide: in turn a dash of each is drawn, so that all are seen.

use smr_recordings::BoundingBox;

/// Edges that are not further apart, in pixels of the frame, are seen as one line.
const NEAR: f64 = 1.5;

/// Of each box its place among those that it coincides with, and how many they are: (0, 1) of one that stands alone.
pub(super) fn turns(boxes: &[BoundingBox]) -> Vec<(usize, usize)> {
    let near = |a: &BoundingBox, b: &BoundingBox| {
        let edges = |of: &BoundingBox| [of.x, of.y, of.x + of.width, of.y + of.height];
        edges(a).iter().zip(edges(b)).all(|(a, b)| (a - b).abs() < NEAR)
    };
    let turn = |(index, bbox): (usize, &BoundingBox)| {
        let same = |of: &[BoundingBox]| of.iter().filter(|other| near(bbox, other)).count();
        (same(&boxes[..index]), same(boxes).max(1))
    };
    boxes.iter().enumerate().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_that_coincide_take_turns() {
        let at = |x: f64| BoundingBox { x, y: 0.0, width: 10.0, height: 10.0 };
        assert_eq!(turns(&[at(0.0), at(20.0), at(0.5)]), [(0, 2), (0, 1), (1, 2)]);
        assert_eq!(turns(&[at(0.0), at(1.5)]), [(0, 1), (0, 1)]);
        assert_eq!(turns(&[]), []);
        assert_eq!(turns(&[at(f64::NAN)]), [(0, 1)]);
    }
}
