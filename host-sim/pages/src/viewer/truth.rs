//! The truth about a target: boxes that the user drew, boxes on a line between two of them, and what the user has looked
//! at of the tracker's boxes. All other frames are unknown.

use super::answers::AnsweredFrame;
use super::model::{Lock, Target, is_inside};
use smr_core::State;
use smr_evaluation::MethodAnswer;
use smr_recordings::BoundingBox;

/// Consecutive frames in which the truth is known. In the first, the box of the target is one to lock on.
#[derive(Debug, PartialEq)]
pub(super) struct Part {
    pub first: usize,
    /// `None`: the target is not visible.
    pub boxes: Vec<Option<BoundingBox>>,
}

/// A recording of one frame has nothing to follow.
const MIN_FRAMES: usize = 2;

impl Target {
    /// Returns the parts of a recording of `frames` frames of the size `size` in which the truth is known. `rows` are the
    /// tracker's answers.
    pub(super) fn known_parts(&self, rows: &[(usize, AnsweredFrame)], frames: usize, size: (u16, u16)) -> Vec<Part> {
        let opens = |bbox: &BoundingBox| bbox.to_rect().is_some_and(|rect| is_inside(rect, size));
        let mut rows = rows.iter().peekable();
        let mut parts: Vec<Part> = Vec::new();
        let mut is_open = false;
        for frame in self.locks.first().map_or(1, |lock| lock.frame)..=frames {
            while rows.next_if(|(at, _)| *at < frame).is_some() {}
            let answer = rows.next_if(|(at, _)| *at == frame).and_then(|(_, row)| row.report.target);
            match (self.known(frame, answer), parts.last_mut().filter(|_| is_open)) {
                (Some(bbox), Some(part)) => part.boxes.push(bbox),
                (Some(Some(bbox)), None) if opens(&bbox) => {
                    parts.push(Part { first: frame, boxes: vec![Some(bbox)] });
                    is_open = true;
                }
                (Some(_), None) => {}
                (None, _) => is_open = false,
            }
        }
        parts.retain(|part| part.boxes.len() >= MIN_FRAMES);
        parts
    }

    /// Returns the true box in a frame; `Some(None)`: the target is not visible; `None`: unknown. `answer` is the
    /// tracker's box. A lost target that was not marked as hidden or gone is unknown: the tracker may be wrong.
    fn known(&self, frame: usize, answer: Option<BoundingBox>) -> Option<Option<BoundingBox>> {
        let (before, after) = self.locks.split_at(self.locks.partition_point(|lock| lock.frame <= frame));
        let last = before.last()?;
        if last.frame == frame {
            return Some(last.rect().map(BoundingBox::from));
        }
        if !self.checked.contains(frame) {
            return None;
        }
        if last.bbox.is_none() || self.hidden.contains(frame) {
            return Some(None);
        }
        on_line(last, after, frame).or(answer).map(Some)
    }

    /// Returns the answer in a frame as the user says it: the box on a line between two of the user's, or none where
    /// something hides the target; elsewhere the tracker's `answer`. `scale` is the size of the tracker's frames, relative
    /// to those that the user has seen.
    pub fn said(&self, frame: usize, answer: MethodAnswer, scale: (f64, f64)) -> MethodAnswer {
        let (before, after) = self.locks.split_at(self.locks.partition_point(|lock| lock.frame <= frame));
        let Some(last) = before.last().filter(|last| last.frame < frame) else { return answer };
        if self.hidden.contains(frame) {
            return MethodAnswer { target: None, bbox: None, state: State::Lost, evidence: None, work: None };
        }
        on_line(last, after, frame).map_or(answer, |bbox| {
            let bbox = bbox.scaled(scale);
            MethodAnswer {
                target: Some(bbox),
                bbox: bbox.to_rect(),
                state: State::Tracking,
                evidence: None,
                work: None,
            }
        })
    }
}

/// Returns the box in a frame behind the lock `last`, if it lies on a line to the first of the locks `after`.
fn on_line(last: &Lock, after: &[Lock], frame: usize) -> Option<BoundingBox> {
    after.first().filter(|_| last.by_hand).and_then(|next| between(last, next, frame))
}

/// Returns the box in a frame on the line between the boxes of two locks; `None` if one of them has no box.
fn between(first: &Lock, last: &Lock, frame: usize) -> Option<BoundingBox> {
    let (from, to) = (BoundingBox::from(first.rect()?), BoundingBox::from(last.rect()?));
    #[allow(clippy::cast_precision_loss)] // frame numbers are far below 2^52
    let part = (frame - first.frame) as f64 / (last.frame - first.frame) as f64;
    let on_line = |from: f64, to: f64| from + (to - from) * part;
    Some(BoundingBox {
        x: on_line(from.x, to.x),
        y: on_line(from.y, to.y),
        width: on_line(from.width, to.width),
        height: on_line(from.height, to.height),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::test_viewer::{FRAMES, Running, Scene, expected, lock, target};
    use proptest::prelude::*;
    use smr_core::Rect;
    use smr_evaluation::MethodKind;
    use smr_recordings::synthetic;

    const SIZE: (u16, u16) = (synthetic::WIDTH, synthetic::HEIGHT);

    fn by_hand(frame: usize, rect: Rect) -> Lock {
        Lock { by_hand: true, ..Lock::new(frame, Some(rect)) }
    }

    fn drawn(locks: Vec<Lock>, hidden: &[(usize, usize)], checked: &[(usize, usize)]) -> Target {
        Target { locks, hidden: hidden.to_vec().into(), checked: checked.to_vec().into(), ..target(1, &[]) }
    }

    /// The left edge of each true box, `None` where the target is not visible, and the first frame, of each part.
    fn lefts(target: &Target, frames: usize) -> Vec<(usize, Vec<Option<f64>>)> {
        let left = |bbox: Option<BoundingBox>| bbox.map(|bbox| bbox.x);
        let parts = target.known_parts(&[], frames, SIZE);
        parts.into_iter().map(|part| (part.first, part.boxes.into_iter().map(left).collect())).collect()
    }

    #[test]
    fn what_the_user_says_comes_before_what_the_tracker_answers() {
        let (from, to) = (Rect::new(0, 0, 10, 10), Rect::new(90, 80, 10, 20));
        let target = drawn(vec![by_hand(2, from), Lock::new(6, Some(to)), Lock::new(9, None)], &[(8, 8)], &[]);
        let answer = MethodAnswer::locked(Rect::new(7, 7, 7, 7));
        let left = |frame| target.said(frame, answer, (0.5, 1.0)).target.map(|bbox| (bbox.x, bbox.height));
        let found = [1, 2, 3, 4, 6, 7, 8, 9].map(left);
        let own = Some((7.0, 7.0));
        assert_eq!(found, [own, own, Some((11.25, 12.5)), Some((22.5, 15.0)), own, own, None, own]);
        assert_eq!(target.said(8, answer, (1.0, 1.0)).state, State::Lost);
    }

    #[test]
    fn boxes_between_two_lie_on_a_line_and_only_what_was_looked_at_is_truth() {
        let (from, to) = (Rect::new(0, 0, 10, 10), Rect::new(90, 80, 10, 20));
        let locks = vec![by_hand(2, from), by_hand(6, to), Lock::new(9, None), Lock::new(12, Some(from))];
        let line = [0.0, 22.5, 45.0, 67.5, 90.0].map(Some);
        let all = [&line[..], &[None; 5]].concat();
        assert_eq!(lefts(&drawn(locks.clone(), &[(7, 8)], &[(1, 20)]), 12), [(2, [&all[..], &[Some(0.0)]].concat())]);
        assert_eq!(lefts(&drawn(locks.clone(), &[(7, 8)], &[(3, 5), (7, 7)]), 12), [(2, all[..6].to_vec())]);
        assert_eq!(
            lefts(&drawn(locks.clone(), &[], &[(4, 5)]), 12),
            [(4, line[2..].to_vec())],
            "a frame alone is no part"
        );
        // Behind the last box by hand the boxes are the tracker's, which has given none here.
        assert_eq!(lefts(&drawn(locks[..2].to_vec(), &[], &[(1, 20)]), 12), [(2, line.to_vec())]);
        // A part begins with a visible target; one that is hidden between two boxes by hand is not on their line.
        let hidden = [(9, 9), (4, 3)];
        assert_eq!(lefts(&drawn(locks, &hidden, &[(3, 6)]), 12), [(2, vec![line[0], None, None, line[3], line[4]])]);
        let height =
            drawn(vec![by_hand(1, from), Lock::new(3, Some(to))], &[], &[(2, 2)]).known_parts(&[], 3, SIZE)[0].boxes[1];
        assert_eq!(height, Some(BoundingBox { x: 45.0, y: 40.0, width: 10.0, height: 15.0 }));
        // A clip of one frame, and a target without boxes.
        assert_eq!(lefts(&drawn(vec![by_hand(1, from)], &[], &[(1, 1)]), 1), []);
        assert_eq!(lefts(&drawn(vec![], &[], &[(1, 9)]), 9), []);
    }

    #[test]
    fn a_part_begins_with_a_box_that_a_tracker_takes() {
        let at = |x: f64| BoundingBox { x, y: 5.0, width: 20.0, height: 10.0 };
        let row = |x: f64| {
            let report = MethodAnswer { target: Some(at(x)), ..MethodAnswer::locked(Rect::new(0, 5, 20, 10)) };
            AnsweredFrame { report, shown: at(x), quality: None, time: None }
        };
        // It comes in over the left border, and goes out over the right one.
        let lefts = [-4.0, -0.6, -0.4, 3.0, f64::from(SIZE.0) - 19.0];
        let rows: Vec<_> = (3..).zip(lefts.map(row)).collect();
        let boxes = lefts[2..].iter().map(|&x| Some(at(x))).collect();
        assert_eq!(drawn(vec![lock(1)], &[], &[(3, 20)]).known_parts(&rows, 20, SIZE), [Part { first: 5, boxes }]);
    }

    #[test]
    fn the_trackers_boxes_are_truth_where_they_were_looked_at_except_while_it_is_lost() {
        let mut running = Running::start(Scene::default(), vec![target(1, &[1])]);
        running.heard();
        let rows = running.followed.rows().remove(0).1;
        let checked = drawn(vec![lock(1)], &[], &[(1, FRAMES)]);
        let seen: Vec<_> = expected(MethodKind::Paper, &[1]).into_iter().map(|(_, report)| report.target).collect();
        let known: Vec<_> = checked.known_parts(&rows, FRAMES, SIZE).into_iter().flat_map(|part| part.boxes).collect();
        assert_eq!(known, seen.into_iter().filter(Option::is_some).collect::<Vec<_>>());
        assert_eq!(drawn(vec![lock(1)], &[], &[]).known_parts(&rows, FRAMES, SIZE), []);
    }

    fn any_rect() -> impl Strategy<Value = Rect> {
        (-500..500_i32, -500..500_i32, 1..500_u16, 1..500_u16).prop_map(|(x, y, width, height)| Rect {
            x,
            y,
            width,
            height,
        })
    }

    proptest! {
        /// Boxes between two by hand, which may lie over the border of the picture: exact at both ends, each side
        /// between those of the ends, and the same if the film runs backwards.
        #[test]
        fn a_line_is_exact_at_its_ends(from in any_rect(), to in any_rect(), first in 1..1000_usize, frames in 1..1000_usize) {
            let last = first + frames;
            let box_in = |from, to, frame| between(&Lock::new(first, Some(from)), &Lock::new(last, Some(to)), frame).unwrap();
            prop_assert_eq!(box_in(from, to, first), from.into());
            prop_assert_eq!(box_in(from, to, last), to.into());
            let sides = |BoundingBox { x, y, width, height }: BoundingBox| [x, y, width, height, x + width, y + height];
            for frame in [first + frames / 3, last - frames / 5] {
                let (here, back) = (sides(box_in(from, to, frame)), sides(box_in(to, from, first + last - frame)));
                for (at, side) in here.into_iter().enumerate() {
                    let ends = [from, to].map(|rect| sides(rect.into())[at]);
                    prop_assert!(side >= ends[0].min(ends[1]) - 1e-9 && side <= ends[0].max(ends[1]) + 1e-9);
                    prop_assert!((side - back[at]).abs() < 1e-9);
                }
            }
        }
    }
}
