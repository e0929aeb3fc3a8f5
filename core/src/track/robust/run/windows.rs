//! The search windows of an update, and the pixels of the frame that it may read for them.

use super::super::config::Config;
use super::super::constants::{CELL, Limits, MARGIN, SCALE_REACH};
use super::super::decision::{Sweep, Track};
use super::super::features::{Grid, Lattice, Place};
use super::super::filter::other_scales;
use super::super::refiner::reachable;
use crate::image::Rect;

/// `MARGIN` in whole cells, rounded up.
const MARGIN_CELLS: u16 = MARGIN.div_ceil(CELL);

/// The middle of the first search window: the target's expected place in the next frame.
pub(crate) fn expected(track: &Track) -> Place {
    track.motion.expected(track.bounds)
}

/// The middle of the next window of redetection, at the scale that the target had when it was last *tracking*; and true
/// if the window is the last of its row.
#[inline(never)]
pub(super) fn next_sweep_window(track: &Track, config: &Config, sweep: Sweep) -> (Place, bool) {
    let side = i64::from(2 * config.reach() * CELL) * track.grid.step_at(track.tracked_scale);
    let ((x, y), is_last) = sweep.middle(u32::try_from(side).unwrap_or(u32::MAX), track.bounds);
    (Place { x, y, scale: track.tracked_scale }, is_last)
}

/// The pixels that an update may read around the expected place: the search window, the view for verification at any
/// place in it, the windows at other scales, and the refiner's crop.
#[inline(never)]
pub(crate) fn expected_pixels(track: &Track, config: &Config) -> Rect {
    let (centre, reach) = (expected(track), track.reach(config));
    let mut pixels = pixels(track, &centre, reach + MARGIN_CELLS);
    if config.size {
        for scale in other_scales(centre.scale) {
            pixels = union(pixels, self::pixels(track, &Place { scale, ..centre }, reach + SCALE_REACH + MARGIN_CELLS));
        }
    }
    if config.refines() {
        pixels = union(pixels, refined_pixels(track, centre, reach));
    }
    pixels
}

/// The pixels that redetection may read in the next update. `None` if that update cannot redetect the target.
#[inline(never)]
pub(crate) fn swept_pixels(track: &Track, config: &Config) -> Option<Rect> {
    if !track.confidence.may_be_lost_next(config) && !track.is_given_up(config) {
        return None;
    }
    let (mut sweep, mut all) = (track.sweep, Rect::default());
    for _ in 0..config.sweep {
        let (place, is_last) = next_sweep_window(track, config, sweep);
        let mut window = pixels(track, &place, config.reach() + MARGIN_CELLS);
        if config.refines() {
            window = union(window, crops(track, place, (config.reach() + 1) * CELL));
        }
        all = if all.is_empty() { window } else { union(all, window) };
        sweep.move_on();
        if is_last {
            break;
        }
    }
    Some(all).filter(|all| !all.is_empty())
}

/// The pixels that a lock reads: the search window around the box, and the refiner's crop (1.75 times the box). Empty if
/// the box is not in the frame.
#[inline(never)]
pub(crate) fn lock_pixels(bounds: Rect, target: Rect, config: &Config, limits: Limits) -> Rect {
    if !bounds.contains(target) {
        return Rect::default();
    }
    let grid = Grid::within(limits, target);
    let window = Lattice::search_window(&Place::of(target), &grid, config.reach()).pixels(bounds);
    if config.refines() {
        return union(window, reachable(Track::new(bounds, target, limits).box_at(Place::of(target)), 0, bounds));
    }
    window
}

#[inline(never)]
fn pixels(track: &Track, place: &Place, reach: u16) -> Rect {
    Lattice::search_window(place, &track.grid, reach).pixels(track.bounds)
}

/// The pixels that the refiner may read if the target is found anywhere in the search window around `centre`. Includes
/// a margin: the peak may lie between cells, alignment moves by up to `MARGIN` pixels of the grid, refinement by one,
/// and the scale may grow by a step.
fn refined_pixels(track: &Track, centre: Place, reach: u16) -> Rect {
    let [_, larger] = other_scales(centre.scale);
    crops(track, Place { scale: larger, ..centre }, (reach + 1) * CELL + MARGIN + 2)
}

/// The pixels of the refiner's crops at `place` and up to `pixels` pixels of the grid around it.
fn crops(track: &Track, place: Place, pixels: u16) -> Rect {
    let by = i64::from(pixels) * track.grid.step_at(place.scale);
    reachable(track.corrected(place), by, track.bounds)
}

#[inline(never)]
fn union(a: Rect, b: Rect) -> Rect {
    let (left, top) = (a.x.min(b.x), a.y.min(b.y));
    let side = |from: i32, to: i32| u16::try_from(to.saturating_sub(from)).unwrap_or(u16::MAX);
    Rect::new(left, top, side(left, a.right().max(b.right())), side(top, a.bottom().max(b.bottom())))
}
