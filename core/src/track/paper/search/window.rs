//! The search window (the positions of the box that a search considers), the goal and result of a search, the tie rule.

use crate::image::Rect;
use core::ops::RangeInclusive;

/// The radius of the search window in pixels: offsets -x..=x and -y..=y around the last position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radius {
    /// Pixels to the left and to the right.
    pub x: u16,
    /// Pixels up and down.
    pub y: u16,
}

impl Radius {
    pub(crate) const fn at_most(self, most: u16) -> Self {
        Self { x: if self.x > most { most } else { self.x }, y: if self.y > most { most } else { self.y } }
    }

    pub(crate) const fn fits(self, span: usize) -> bool {
        2 * (self.x as usize) < span && 2 * (self.y as usize) < span
    }
}

/// All positions of the box within a radius of its last position, cut at the edges of the padded frame. A position is
/// that of the box's top left corner. Positions are one pixel apart. A window is never empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Window {
    centre_x: i32,
    centre_y: i32,
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Window {
    pub(crate) const NONE: Self = Self { centre_x: 0, centre_y: 0, left: 0, right: 0, top: 0, bottom: 0 };

    /// The window of `radius` around `target`, in a frame of the size of `bounds` with `padding` pixels around it.
    #[must_use]
    pub fn new(target: Rect, radius: Radius, bounds: Rect, padding: u16) -> Self {
        let (left, right) = span(target.x, radius.x, padding, bounds.width, target.width);
        let (top, bottom) = span(target.y, radius.y, padding, bounds.height, target.height);
        Self { centre_x: target.x, centre_y: target.y, left, right, top, bottom }
    }

    /// The x coordinates that the box's left edge takes in this window.
    #[must_use]
    pub const fn xs(&self) -> RangeInclusive<i32> {
        self.left..=self.right
    }

    /// The y coordinates that the box's top edge takes in this window.
    #[must_use]
    pub const fn ys(&self) -> RangeInclusive<i32> {
        self.top..=self.bottom
    }

    /// The number of positions on the x axis and on the y axis.
    #[must_use]
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub fn size(&self) -> (usize, usize) {
        (count(self.left, self.right), count(self.top, self.bottom))
    }

    pub(super) fn contains(&self, x: i32, y: i32) -> bool {
        self.xs().contains(&x) && self.ys().contains(&y)
    }

    /// The last position, on which the window is centred.
    pub(super) const fn centre(&self) -> (i32, i32) {
        (self.centre_x, self.centre_y)
    }

    pub(super) fn position(&self, column: usize, row: usize) -> (i32, i32) {
        // A window has at most 2 * 65535 + 1 positions on an axis.
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        (self.left.saturating_add(column as i32), self.top.saturating_add(row as i32))
    }

    /// The (columns, rows) of the largest window of `radius` for a box of `target`'s size anywhere in the padded frame.
    pub(crate) fn largest_size(target: Rect, radius: Radius, bounds: Rect, padding: u16) -> (usize, usize) {
        let most = |radius: u16, frame: u16, size: u16| {
            let all = (usize::from(frame) + 2 * usize::from(padding)).saturating_sub(usize::from(size)) + 1;
            all.min(2 * usize::from(radius) + 1)
        };
        (most(radius.x, bounds.width, target.width), most(radius.y, bounds.height, target.height))
    }

    /// The pixels of the frame that a box of `width` x `height` covers at the positions of the window. Never empty: on
    /// an axis where no position reaches the frame, the row or column at the frame's edge is taken.
    pub(crate) fn pixels(&self, width: u16, height: u16, bounds: Rect) -> Rect {
        let (x, width) = pixels(self.left, self.right, width, bounds.width);
        let (y, height) = pixels(self.top, self.bottom, height, bounds.height);
        Rect::new(x, y, width, height)
    }
}

/// A position of the box in the search window (an offset), and its score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Left edge of the box, in pixels of the frame.
    pub x: i32,
    /// Top edge of the box, in pixels of the frame.
    pub y: i32,
    /// The sum of the similarities of all template pixels at this position, in units of 1/65535.
    pub score: u32,
}

impl Peak {
    /// True if this offset wins over `other`: by a larger score, or at equal scores by the tie rule.
    #[cfg_attr(smr_small, inline(never))]
    #[cfg_attr(not(smr_small), inline)]
    pub(super) fn beats(&self, other: &Self, window: &Window) -> bool {
        if self.score == other.score { self.order(window) < other.order(window) } else { self.score > other.score }
    }

    /// The key of the tie rule: of equal scores the offset with the least key is the peak.
    fn order(&self, window: &Window) -> (u64, i32, i32) {
        let (x, y) = window.centre();
        let (dx, dy) = (u64::from(self.x.abs_diff(x)), u64::from(self.y.abs_diff(y)));
        (dx * dx + dy * dy, self.y, self.x)
    }

    pub(super) fn is_further_than(&self, distance: u32, other: &Self) -> bool {
        self.x.abs_diff(other.x).max(self.y.abs_diff(other.y)) > distance
    }
}

/// The goal of a search. The value of a variant is the radius of the peak's neighbourhood in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Peak,
    /// The peak, and whether an offset outside its neighbourhood has the same score. Takes little longer than `Peak`.
    Equals(u16),
    /// The peak and the runner-up.
    RunnerUp(u16),
}

/// The result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peaks {
    /// The offset with the largest score.
    pub peak: Peak,
    /// The largest score outside the peak's neighbourhood; 0 if the neighbourhood covers the window. `None` if the
    /// gate's decision did not depend on it: see [`runner_up_always`](crate::paper::Config::runner_up_always).
    pub runner_up: Option<u32>,
}

/// (first, count) of the frame's pixels on an axis that a box covers at the positions `first..=last`; if it covers
/// none, the frame's nearest pixel.
#[cfg_attr(smr_small, inline(never))]
fn pixels(first: i32, last: i32, size: u16, frame: u16) -> (i32, u16) {
    let frame = i32::from(frame);
    let from = first.min(frame - 1).max(0);
    let end = last.saturating_add(size.into()).min(frame).max(from + 1);
    (from, u16::try_from(end - from).unwrap_or(u16::MAX))
}

/// (first, last) position of the window around `at` on an axis, clamped to the positions of the box in the padded
/// frame. The range is not empty, even if `at` is none of these positions.
#[cfg_attr(smr_small, inline(never))]
fn span(at: i32, radius: u16, padding: u16, frame: u16, size: u16) -> (i32, i32) {
    let first = -i32::from(padding);
    let last = (i32::from(frame) + i32::from(padding) - i32::from(size)).max(first);
    let reach = i32::from(radius);
    (at.saturating_sub(reach).clamp(first, last), at.saturating_add(reach).clamp(first, last))
}

fn count(first: i32, last: i32) -> usize {
    usize::try_from(last.saturating_sub(first)).unwrap_or(0) + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Tests frames, boxes and radii of all sizes. Boxes may lie in the padding.
        #[test]
        fn a_window_stays_in_the_padded_frame_and_around_its_centre(
            (frame_width, frame_height) in (1u16.., 1u16..),
            (width, height) in (1u16.., 1u16..),
            (along_x, along_y) in (0.0..=1.0f64, 0.0..=1.0f64),
            (radius_x, radius_y, padding) in any::<(u16, u16, u16)>(),
        ) {
            let (width, height) = (width.min(frame_width), height.min(frame_height));
            let place = |along: f64, frame: u16, size: u16| {
                let (first, last) = (-i32::from(padding), i32::from(frame) + i32::from(padding) - i32::from(size));
                first + (f64::from(last - first) * along) as i32
            };
            let x = place(along_x, frame_width, width);
            let y = place(along_y, frame_height, height);
            let target = Rect::new(x, y, width, height);
            let bounds = Rect::new(0, 0, frame_width, frame_height);
            let radius = Radius { x: radius_x, y: radius_y };
            let window = Window::new(target, radius, bounds, padding);

            prop_assert!(window.xs().contains(&x) && window.ys().contains(&y));
            prop_assert_eq!(*window.xs().start(), (x - i32::from(radius_x)).max(-i32::from(padding)));
            let last = i32::from(frame_height) + i32::from(padding) - i32::from(height);
            prop_assert_eq!(*window.ys().end(), (y + i32::from(radius_y)).min(last));
            let (columns, rows) = window.size();
            prop_assert_eq!(columns, window.xs().count());
            prop_assert_eq!(rows, window.ys().count());
            let (most_columns, most_rows) = Window::largest_size(target, radius, bounds, padding);
            prop_assert!(columns <= most_columns && rows <= most_rows);
        }

        #[test]
        fn the_pixels_are_those_that_some_box_covers(
            (frame_width, frame_height) in (1u16..20, 1u16..20),
            (width, height) in (1u16..20, 1u16..20),
            (x, y) in (-9i32..28, -9i32..28),
            (radius_x, radius_y, padding) in (0u16..12, 0u16..12, 0u16..9),
        ) {
            let target = Rect::new(x, y, width.min(frame_width), height.min(frame_height));
            let bounds = Rect::new(0, 0, frame_width, frame_height);
            let window = Window::new(target, Radius { x: radius_x, y: radius_y }, bounds, padding);
            let pixels = window.pixels(target.width, target.height, bounds);
            let covered = |px: i32, py: i32| {
                window.ys().any(|y| window.xs().any(|x| Rect { x, y, ..target }.contains(Rect::new(px, py, 1, 1))))
            };
            prop_assert!(bounds.contains(pixels), "{:?}", pixels);
            let mut any = false;
            let places = || (0..i32::from(frame_height)).flat_map(|y| (0..i32::from(frame_width)).map(move |x| (x, y)));
            for (px, py) in places() {
                let is_covered = covered(px, py);
                any |= is_covered;
                prop_assert!(!is_covered || pixels.contains(Rect::new(px, py, 1, 1)), "({}, {})", px, py);
            }
            for (px, py) in places().filter(|_| any) {
                prop_assert_eq!(pixels.contains(Rect::new(px, py, 1, 1)), covered(px, py), "({}, {})", px, py);
            }
        }
    }
}
