//! Simulates a target that leaves and returns. While the target is gone, shows only a strip of each frame beside the
//! target's place; afterwards, shows the frames shifted.

use crate::bounding_box::BoundingBox;
use crate::raster::GrayFrame;
use smr_core::Rect;
use std::ops::Range;

#[derive(Clone, Debug, PartialEq)]
pub struct Away {
    gone: Range<usize>,
    sides: [i32; 2],
    /// Column range and row range of the strip beside the target; only the strip is shown while the target is gone.
    strip: [Range<i32>; 2],
    /// Shift of the image to the right and down in pixels, once the target has returned.
    shift: [i32; 2],
}

impl Away {
    /// Chooses the strip and the shift. Each of the four possible strips lies between one side of the frame and the box
    /// around all boxes of the target in the frames `gone` and the frame before them; the largest strip is chosen. The
    /// shift keeps the first box after `gone` in the frame.
    pub fn new(truth: &[Option<BoundingBox>], gone: Range<usize>, frame: Rect) -> Self {
        let corners = |at: &BoundingBox| [[at.x, at.y], [at.x + at.width, at.y + at.height]];
        let corners: Vec<_> = truth[gone.start - 1..gone.end].iter().flatten().flat_map(corners).collect();
        let inside = |at: Option<BoundingBox>| frame.intersection(at.and_then(|at| at.to_rect()).unwrap_or_default());
        let (seen, lost) = (inside(BoundingBox::around(&corners)), inside(truth[gone.start - 1]));
        let back = inside(truth[gone.end..].iter().flatten().next().copied());
        let [w, h] = [frame.right(), frame.bottom()];
        let strips = [[0..seen.x, 0..h], [seen.right()..w, 0..h], [0..w, 0..seen.y], [0..w, seen.bottom()..h]];
        let strip = strips.into_iter().max_by_key(|[columns, rows]| columns.len() * rows.len()).unwrap_or_default();
        // Returns the shift on one axis: towards the border that takes the target farther from where it was lost, by at
        // most a quarter of the frame's side, and not past that border.
        let shift = |lost: i32, start: i32, end: i32, side: i32| {
            let shifts = [-start, side - end].map(|shift| shift.clamp(-side / 4, side / 4));
            shifts.into_iter().max_by_key(|shift| (start + shift).abs_diff(lost)).unwrap_or(0)
        };
        let shift = [shift(lost.x, back.x, back.right(), w), shift(lost.y, back.y, back.bottom(), h)];
        Self { gone, sides: [w, h], strip, shift }
    }

    /// Returns the frame to show in place of `frame`; `index` counts from the first frame without the target.
    pub fn view(&self, index: usize, frame: &GrayFrame) -> GrayFrame {
        let from = |axis: usize, at: i32| {
            let (side, Range { start, end }) = (self.sides[axis], self.strip[axis].clone());
            if index >= self.gone.len() {
                return (at - self.shift[axis]).clamp(0, side - 1);
            }
            // Moves the strip to the opposite side of the frame, as if the camera had turned, and fills the rest of the
            // frame with the strip, mirrored and unmirrored in turn.
            let length = (end - start).max(1);
            let at = if start == 0 { at + length - side } else { at }.rem_euclid(2 * length);
            start + at.min(2 * length - 1 - at)
        };
        GrayFrame::drawn(frame.width, frame.height, |x, y| frame.level(from(0, x), from(1, y)))
    }

    /// Returns the ground truth of the shown frames. The target is visible if the centre of its box is in the frame.
    pub fn truth(&self, truth: &[Option<BoundingBox>]) -> Vec<Option<BoundingBox>> {
        let ([w, h], [right, down]) = (self.sides.map(f64::from), self.shift.map(f64::from));
        let is_visible = |(x, y): (f64, f64)| (0.0..w).contains(&x) && (0.0..h).contains(&y);
        let moved = |at: BoundingBox| BoundingBox { x: at.x + right, y: at.y + down, ..at };
        let mut truth = truth.to_vec();
        truth[self.gone.clone()].fill(None);
        let back = truth[self.gone.end..].iter_mut();
        back.for_each(|target| *target = target.map(moved).filter(|at| is_visible(at.centre())));
        truth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of 16x8 pixels, each with its index as gray level. The 4x2 target is gone in frames 2 and 3 of four.
    fn away(places: [[i32; 2]; 4]) -> (GrayFrame, Vec<Option<BoundingBox>>, Away) {
        let truth = places.map(|[x, y]| Some([x, y, 4, 2].into())).to_vec();
        let away = Away::new(&truth, 1..3, Rect::new(0, 0, 16, 8));
        (GrayFrame::drawn(16, 8, |x, y| (16 * y + x).to_le_bytes()[0]), truth, away)
    }

    #[test]
    fn a_target_is_gone_and_back_elsewhere() {
        // The largest strip is columns 9 to 15. The target is lost at (2, 3). On its return, it is at (4, 3) in the
        // recording, and is shown 4 pixels farther right and 2 farther down.
        let (frame, truth, away) = away([[2, 3], [3, 4], [5, 4], [4, 3]]);
        let row = |index, row: usize| away.view(index, &frame).pixels[16 * row..][..16].to_vec();
        assert_eq!(row(1, 0), [9, 10, 11, 12, 13, 14, 15, 15, 14, 13, 12, 11, 10, 9, 9, 10]);
        assert_eq!(row(2, 1), [0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
        assert_eq!((row(1, 7)[0], row(2, 7)[4]), (16 * 7 + 9, 16 * 5));
        assert_eq!(away.truth(&truth), [truth[0], None, None, Some([8, 5, 4, 2].into())]);
    }

    /// Each case: position of the target, recorded position of the pixel shown at the top left, and the shift.
    #[test]
    fn the_camera_turns_to_each_side_and_the_box_stays_inside() {
        for (place, seen, shift) in
            [([0, 3], [4, 0], [4, 2]), ([12, 3], [3, 0], [-4, 2]), ([6, 0], [0, 2], [4, 2]), ([6, 6], [0, 1], [4, -2])]
        {
            let (frame, mut truth, away) = away([place; 4]);
            let view = away.view(0, &frame).pixels;
            let at = Rect::new(place[0], place[1], 4, 2);
            let shows = |&pixel: &u8| at.contains(Rect::new(i32::from(pixel % 16), i32::from(pixel / 16), 1, 1));
            assert!(!view.iter().any(shows), "{place:?}: {view:?}");
            assert_eq!(([view[0] % 16, view[0] / 16].map(i32::from), away.shift), (seen, shift), "{place:?}");
            truth[3] = Some([-8, 2, 4, 2].into());
            assert_eq!(away.truth(&truth)[3], None);
        }
        let (whole, frame) = ([Some([0, 0, 16, 8].into()); 4], away([[0; 2]; 4]).0);
        let away = Away::new(&whole, 1..3, frame.frame().bounds());
        assert_eq!((away.view(0, &frame).pixels, away.shift), (vec![0; 128], [0, 0]), "beside it is nothing");
    }
}
