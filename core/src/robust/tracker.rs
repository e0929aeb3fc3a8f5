//! The way of a frame through the robust tracker: window, filter, place, size, verification, learning, answer.

use super::agreement;
use super::config::Config;
use super::features::{CELL, CHANNELS, Strip};
use super::filter::{Coded, Desk, Filter};
use super::grid::{Grid, Lattice, MOST_SIDE, PIXEL, SCALE};
use super::samples::Samples;
use super::sweep::Sweep;
use super::templates::Mean;
use super::trust::Trust;
use super::{MOST_CELLS, MOST_PIXELS, REACH, place, threshold};
use crate::image::{Frame, Image, Rect};
use crate::similarity::{Backend, Scorer};
use core::fmt;
use heapless::Vec;

/// What the robust tracker holds of its target after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The early template agrees, part by part: this is the target.
    Tracking,
    /// It hardly agrees: the target is partly hidden or changes quickly, or something else is followed.
    Uncertain,
    /// It has not agreed for some frames, at most five: the target is not seen. The box is what is followed meanwhile; it is
    /// believed again only when the early template agrees clearly, there or where the sweep finds it.
    Lost,
}

/// A box in units of 1/256 pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineRect {
    /// Left edge.
    pub x: i32,
    /// Top edge.
    pub y: i32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

/// The answer of [`Tracker::update`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// The target's box in units of 1/256 pixel; it may reach out of the frame.
    pub fine: FineRect,
    /// The same in whole pixels, each edge rounded.
    pub bbox: Rect,
    /// Whether the box is to be believed.
    pub state: State,
    /// How well the early template agrees, in units of 1/65535: the fourth least ratio of its 16 parts.
    pub ratio: u16,
    /// Confidence.
    pub confidence: u16,
    /// The target's size against that of the box that was locked on, in units of 1/65536.
    pub scale: u32,
    /// The filter's response at the place, in units of 1/16384; the label is 16384.
    pub response: i32,
    /// True if the target was found somewhere else, after it was lost or doubtful.
    pub found_again: bool,
}

/// Bytes of the largest window of cells.
const WINDOW: usize = (MOST_SIDE + 2 * REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * REACH as usize) * CHANNELS;
/// The place is looked for in a view that is so much larger than the template, and the agreement one pixel beyond.
const AROUND: u16 = place::AROUND + 1;
/// Pixels of the largest view.
const VIEW: usize = 4096;
/// Offsets on an axis of the search window.
const SPAN: usize = 2 * REACH as usize + 1;

/// Follows one target, whose size, light and view may change.
pub struct Tracker {
    config: Config,
    strip: Strip,
    cells: Vec<i8, WINDOW>,
    desk: Desk,
    view: Vec<u8, VIEW>,
    patch: Vec<u8, MOST_PIXELS>,
    filter: Filter,
    samples: Samples,
    last: Vec<u8, MOST_PIXELS>,
    slow: Mean<MOST_PIXELS>,
    early: Mean<MOST_PIXELS>,
    track: Option<Track>,
}

/// What is remembered of a target beside its filter and its templates.
#[derive(Clone, Copy)]
struct Track {
    bounds: Rect,
    /// Of the box that was locked on.
    width: u16,
    height: u16,
    grid: Grid,
    place: Place,
    /// How far the target moves from frame to frame, as far as is known.
    right: i64,
    down: i64,
    /// The scale when the target was last believed.
    believed: u32,
    trust: Trust,
    state: State,
    sweep: Sweep,
}

/// The target's middle and size.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: i64,
    y: i64,
    scale: u32,
}

/// A peak of responses: where, in units of 1/256 cell from the window's middle, and how large, in units of 1/16384.
#[derive(Clone, Copy, Debug)]
struct Peak {
    x: i32,
    y: i32,
    response: i32,
}

impl Tracker {
    /// A tracker without a target.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new(config: Config) -> Self {
        Self {
            config,
            strip: Strip::new(),
            cells: Vec::new(),
            desk: Desk::new(),
            view: Vec::new(),
            patch: Vec::new(),
            filter: Filter::new(),
            samples: Samples::new(),
            last: Vec::new(),
            slow: Mean::new(),
            early: Mean::new(),
            track: None,
        }
    }

    /// Starts on the target in `target`, at any time; whatever was followed before is forgotten.
    ///
    /// # Errors
    /// [`LockError`]; the tracker then goes on with what it had.
    pub fn lock(&mut self, frame: &Frame<'_>, target: Rect) -> Result<(), LockError> {
        let bounds = frame.bounds();
        if target.is_empty() {
            return Err(LockError::BoxEmpty);
        }
        if !bounds.contains(target) {
            return Err(LockError::BoxOutsideFrame);
        }
        let grid = Grid::new(target);
        let middle = |from: i32, size: u16| (2 * i64::from(from) + i64::from(size) - 1) * PIXEL / 2;
        let place = Place { x: middle(target.x, target.width), y: middle(target.y, target.height), scale: SCALE };
        let track = Track {
            bounds,
            width: target.width,
            height: target.height,
            grid,
            place,
            right: 0,
            down: 0,
            believed: SCALE,
            trust: Trust::new(CLEAR),
            state: State::Tracking,
            sweep: Sweep::new(),
        };
        if !frame.covered().contains(window(&grid, place, REACH).pixels(bounds)) {
            return Err(LockError::BoxNotInMemory);
        }
        // Cannot fail: all of it is in memory.
        template(&grid, place, 0).sample(frame, &mut self.last);
        self.slow.start(&self.last);
        self.early.start(&self.last);
        self.filter.start(&grid);
        self.samples.clear();
        self.see(frame, &grid, place, REACH);
        let Self { samples, cells, filter, desk, config, .. } = self;
        samples.take(&grid, cells, (0, 0), &config.tuning);
        for _ in 0..config.tuning.first_steps {
            filter.learn(&grid, samples, desk, &config.tuning);
        }
        self.track = Some(track);
        Ok(())
    }

    /// Looks for the target in the next frame.
    ///
    /// # Errors
    /// [`UpdateError`]; the tracker is then as it was before.
    pub fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        if !frame.covered().contains(self.pixels_of(&track)) {
            return Err(UpdateError::WindowNotInMemory);
        }
        let tuning = self.config.tuning;
        let mut next = track;
        let centre = track.expected(&tuning);
        let coded = self.filter.code(&mut self.desk);
        let (mut place, peak, mut ratio) = self.look(frame, &track, centre, coded);
        let evidence = evidence(ratio, peak);
        let mut found_again = false;
        if tuning.verify {
            next.trust = track.trust.after(evidence, &tuning);
            next.state = next.trust.state(&tuning);
        }
        let doubted = tuning.gate && evidence < tuning.gate_below;
        // The sample is of this window: it is taken before another one is looked at.
        if !doubted {
            let step = (i64::from(CELL) * track.grid.step_at(centre.scale)).max(1);
            let label = |to: i64, from: i64| i32::try_from((to - from) * 256 / step).unwrap_or(0);
            let at = (label(place.x, centre.x), label(place.y, centre.y));
            self.samples.take(&track.grid, &self.cells, at, &tuning);
        }
        if tuning.size {
            place.scale = self.size(frame, &track, place, peak, coded);
        }
        if next.trust.sweeps(&tuning) && tuning.sweep {
            let there = track.sweep_place();
            next.sweep.advance();
            let (found, peak, again) = self.look(frame, &track, there, coded);
            let clear = self::evidence(again, peak);
            if clear >= tuning.again && clear >= evidence + tuning.better {
                (place, ratio, found_again) = (found, again, true);
                next = Track { trust: Trust::new(clear), state: State::Tracking, ..next };
            }
        }
        next.moved_to(place, found_again);
        if !doubted {
            for _ in 0..tuning.steps {
                self.filter.learn(&track.grid, &self.samples, &mut self.desk, &tuning);
            }
        }
        self.remember(frame, &mut next, found_again);
        self.track = Some(next);
        let fine = next.fine();
        Ok(Answer {
            fine,
            bbox: whole(fine),
            state: next.state,
            ratio,
            confidence: next.trust.confidence(),
            scale: next.place.scale,
            response: peak.response,
            found_again,
        })
    }

    /// The pixels of the frame that the next [`Tracker::update`] may read; `None` before the first lock.
    #[must_use]
    pub fn window(&self) -> Option<Rect> {
        self.track.as_ref().map(|track| self.pixels_of(track))
    }

    /// The last patch on the grid; `None` before the first lock.
    #[must_use]
    pub fn template(&self) -> Option<Image<'_>> {
        self.image(&self.last)
    }

    /// The running mean beside it; `None` before the first lock.
    #[must_use]
    pub fn slow_template(&self) -> Option<Image<'_>> {
        self.image(self.slow.pixels())
    }

    /// The early template, by which the track is verified; `None` before the first lock.
    #[must_use]
    pub fn early_template(&self) -> Option<Image<'_>> {
        self.image(self.early.pixels())
    }

    /// The grid; `None` before the first lock.
    #[must_use]
    pub fn grid(&self) -> Option<Grid> {
        self.track.map(|track| track.grid)
    }

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    fn image<'a>(&self, pixels: &'a [u8]) -> Option<Image<'a>> {
        let grid = self.track?.grid;
        Image::new(pixels, grid.columns, grid.rows).ok()
    }

    /// What may be read: the window, and the sweep's next one.
    fn pixels_of(&self, track: &Track) -> Rect {
        let tuning = &self.config.tuning;
        let near = window(&track.grid, track.expected(tuning), REACH).pixels(track.bounds);
        if !tuning.sweep || !tuning.verify {
            return near;
        }
        union(near, window(&track.grid, track.sweep_place(), REACH).pixels(track.bounds))
    }

    /// The features of a window.
    fn see(&mut self, frame: &Frame<'_>, grid: &Grid, place: Place, reach: u16) {
        self.strip.features(frame, &window(grid, place, reach), &mut self.cells);
    }

    /// The filter's peak in the last window that was seen, of offsets up to `reach` cells around its middle.
    fn peak(&self, grid: &Grid, coded: Coded, reach: u16) -> Peak {
        let row = usize::from(grid.across) * CHANNELS;
        let stride = usize::from(grid.across + 2 * reach) * CHANNELS;
        let span = 2 * usize::from(reach) + 1;
        let mut responses = [[0; SPAN]; SPAN];
        let mut best = (i32::MIN, 0, 0);
        for (y, out) in responses.iter_mut().take(span).enumerate() {
            let out = out.get_mut(..span).unwrap_or_default();
            self.desk.responses(coded, self.cells.get(y * stride..).unwrap_or_default(), stride, row, out);
            for (x, response) in out.iter_mut().enumerate() {
                if reach == REACH {
                    let away = |at: usize| (i64::try_from(at).unwrap_or(0) - i64::from(reach)).pow(2);
                    let part = 256 - ((self.config.tuning.near * (away(x) + away(y)).min(64)) >> 6);
                    *response = i32::try_from((i64::from(*response) * part) >> 8).unwrap_or(0);
                }
                if *response > best.0 {
                    best = (*response, x, y);
                }
            }
        }
        let (response, x, y) = best;
        let at = |x: usize, y: usize| responses.get(y).filter(|_| x < span && y < span).and_then(|row| row.get(x)).copied();
        let part = |before: Option<i32>, after: Option<i32>| match (before, after) {
            (Some(before), Some(after)) => top(before, response, after),
            _ => 0,
        };
        let cells = |at: usize| (i32::try_from(at).unwrap_or(0) - i32::from(reach)) * 256;
        Peak {
            x: cells(x) + part(x.checked_sub(1).and_then(|x| at(x, y)), at(x + 1, y)),
            y: cells(y) + part(y.checked_sub(1).and_then(|y| at(x, y)), at(x, y + 1)),
            response,
        }
    }

    /// Where the target is in the window around `centre`: by the filter, then by the templates; and how well the early template
    /// agrees there.
    fn look(&mut self, frame: &Frame<'_>, track: &Track, centre: Place, coded: Coded) -> (Place, Peak, u16) {
        let grid = track.grid;
        self.see(frame, &grid, centre, REACH);
        let peak = self.peak(&grid, coded, REACH);
        let step = grid.step_at(centre.scale);
        // 1/256 cell is 1/64 pixel of the grid; a step is in 1/4096 pixel.
        let moved = |from: i64, by: i32| from + ((i64::from(by) * step) >> 6);
        let rough = Place { x: moved(centre.x, peak.x), y: moved(centre.y, peak.y), scale: centre.scale };
        let lattice = template(&grid, rough, AROUND);
        if !lattice.sample(frame, &mut self.view) {
            return (track.inside(rough), peak, 0);
        }
        let alpha = threshold::by_contrast(&self.last);
        let Self { view, last, slow, early, patch: lit, config, .. } = self;
        let (Ok(view), Ok(last), Ok(slow)) = (
            Image::new(view, lattice.columns, lattice.rows),
            Image::new(last, grid.columns, grid.rows),
            Image::new(slow.pixels(), grid.columns, grid.rows),
        ) else {
            return (track.inside(rough), peak, 0);
        };
        let tuning = config.tuning;
        let (mut place, mut at) = (rough, (i32::from(AROUND), i32::from(AROUND)));
        if tuning.fine {
            let scorer = scorer(config, alpha);
            if tuning.w_early > 0 {
                let was = threshold::Contrast::of(early.pixels().iter().copied());
                super::light::of(early.pixels(), was, last, lit);
            }
            let Ok(lit) = Image::new(if tuning.w_early > 0 { lit } else { early.pixels() }, grid.columns, grid.rows) else { return (rough, peak, 0) };
            let (right, down) = place::best(view, 1, [(last, tuning.w_last), (slow, tuning.w_slow), (lit, tuning.w_early)], &scorer);
            let part = |from: i64, by: i64| from + ((by * tuning.fine_mix / 256 * step) >> 12);
            place = Place { x: part(rough.x, right), y: part(rough.y, down), ..rough };
            let pixel = |by: i64| i32::try_from((by * tuning.fine_mix / 256 + PIXEL / 2) >> 12).unwrap_or(0);
            at = (at.0 + pixel(right), at.1 + pixel(down));
        }
        let scene = agreement::Scene { view, early: early.pixels(), columns: grid.columns, rows: grid.rows };
        let ratio = agreement::best(&scene, at, 1, lit, |alpha| scorer(config, alpha)).ratio;
        (track.inside(place), peak, ratio)
    }

    /// The scale at `place`: a little smaller, a little larger, or as it was.
    fn size(&mut self, frame: &Frame<'_>, track: &Track, place: Place, peak: Peak, coded: Coded) -> u32 {
        let tuning = self.config.tuning;
        let mut best = (peak.response, place.scale);
        let step = u64::from(tuning.size_step);
        let (larger, smaller) = ((u64::from(place.scale) * step) >> 16, (u64::from(place.scale) << 16) / step);
        for scale in [smaller, larger] {
            let scale = u32::try_from(scale).unwrap_or(SCALE).clamp(SCALE / 5, 5 * SCALE);
            self.see(frame, &track.grid, Place { scale, ..place }, tuning.size_reach);
            let peak = self.peak(&track.grid, coded, tuning.size_reach);
            let response = i32::try_from((i64::from(peak.response) * tuning.size_cost) >> 8).unwrap_or(0);
            if response > best.0 {
                best = (response, scale);
            }
        }
        best.1
    }

    /// The templates of the next frame.
    fn remember(&mut self, frame: &Frame<'_>, next: &mut Track, found_again: bool) {
        let tuning = self.config.tuning;
        if !template(&next.grid, next.place, 0).sample(frame, &mut self.last) {
            return;
        }
        if found_again {
            self.slow.start(self.early.pixels());
        } else {
            self.slow.learn(&self.last, tuning.slow_rate);
        }
        if next.state != State::Lost {
            self.early.learn(&self.last, tuning.early_rate);
        }
        if next.state == State::Tracking {
            next.believed = next.place.scale;
        }
    }
}

/// Where between its neighbours a maximum lies, in units of 1/256 of their distance, -128 to 128.
fn top(before: i32, at: i32, after: i32) -> i32 {
    let [before, at, after] = [before, at, after].map(i64::from);
    let bend = before - 2 * at + after;
    if bend >= 0 {
        return 0;
    }
    i32::try_from(((before - after) * 128 / bend).clamp(-128, 128)).unwrap_or(0)
}

/// The search window around `place`, with the pixel on each side that gradients need.
fn window(grid: &Grid, place: Place, reach: u16) -> Lattice {
    let side = |cells: u16| (cells + 2 * reach) * CELL + 2;
    let (columns, rows) = (side(grid.across), side(grid.down));
    Lattice { x: place.x, y: place.y, step: grid.step_at(place.scale), columns, rows }
}

/// The template at `place`, and so many pixels of the grid around it.
fn template(grid: &Grid, place: Place, around: u16) -> Lattice {
    let (columns, rows) = (grid.columns + 2 * around, grid.rows + 2 * around);
    Lattice { x: place.x, y: place.y, step: grid.step_at(place.scale), columns, rows }
}

/// The last position on an axis of so many pixels. Never below the first, which a clamp must be shown.
fn end_of(size: u16) -> i64 {
    i64::from(size.saturating_sub(1)) * PIXEL
}

#[inline(always)] // made where it stays
fn scorer(config: &Config, alpha: u16) -> Scorer {
    Scorer::new(config.backend.unwrap_or_else(Backend::best), config.table, alpha)
}

/// The evidence of a look in which all agrees, in units of 1/65536.
const CLEAR: i32 = 3 << 15;

/// What a look says for the target: how well the early template agrees, and half of the filter's response.
fn evidence(ratio: u16, peak: Peak) -> i32 {
    i32::from(ratio) + 2 * peak.response.clamp(0, 1 << 14)
}

impl Track {
    /// Where the target is expected in the next frame.
    fn expected(&self, tuning: &super::tuning::Tuning) -> Place {
        let Place { x, y, scale } = self.place;
        self.inside(Place { x: x + ((self.right * tuning.velocity) >> 8), y: y + ((self.down * tuning.velocity) >> 8), scale })
    }

    fn moved_to(&mut self, place: Place, found_again: bool) {
        let speed = |to: i64, from: i64, before: i64| if found_again { 0 } else { (to - from + before) >> 1 };
        self.right = speed(place.x, self.place.x, self.right);
        self.down = speed(place.y, self.place.y, self.down);
        self.place = place;
    }

    /// The place, moved into the frame.
    fn inside(&self, place: Place) -> Place {
        let Place { x, y, scale } = place;
        Place { x: x.clamp(0, end_of(self.bounds.width)), y: y.clamp(0, end_of(self.bounds.height)), scale }
    }

    /// The middle of the sweep's next window, at the scale that was last believed.
    fn sweep_place(&self) -> Place {
        let reach = i64::from(2 * REACH * CELL) * self.grid.step_at(self.believed);
        let (x, y) = self.sweep.place(reach, self.bounds);
        Place { x, y, scale: self.believed }
    }

    fn fine(&self) -> FineRect {
        let size = |size: u16| {
            u32::try_from((u64::from(size) * u64::from(self.place.scale) + (1 << 7)) >> 8).unwrap_or(u32::MAX)
        };
        let (width, height) = (size(self.width), size(self.height));
        let corner = |middle: i64, size: u32| {
            let corner = ((middle + PIXEL / 2) >> 4) - i64::from(size / 2);
            i32::try_from(corner).unwrap_or(0)
        };
        FineRect { x: corner(self.place.x, width), y: corner(self.place.y, height), width, height }
    }
}

fn whole(fine: FineRect) -> Rect {
    let round = |edge: i64| (edge + 128) >> 8;
    let (left, top) = (round(fine.x.into()), round(fine.y.into()));
    let side = |from: i32, size: u32, start: i64| {
        u16::try_from((round(i64::from(from) + i64::from(size)) - start).max(1)).unwrap_or(u16::MAX)
    };
    let (width, height) = (side(fine.x, fine.width, left), side(fine.y, fine.height, top));
    Rect::new(i32::try_from(left).unwrap_or(0), i32::try_from(top).unwrap_or(0), width, height)
}

/// The smallest that holds both.
fn union(a: Rect, b: Rect) -> Rect {
    let (left, top) = (a.x.min(b.x), a.y.min(b.y));
    let side = |from: i32, to: i32| u16::try_from(to.saturating_sub(from)).unwrap_or(u16::MAX);
    Rect::new(left, top, side(left, a.right().max(b.right())), side(top, a.bottom().max(b.bottom())))
}

/// Why a tracker does not start on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LockError {
    /// The box has no pixels.
    BoxEmpty,
    /// A part of the box lies outside the frame.
    BoxOutsideFrame,
    /// The part of the frame in memory does not cover the box and the pixels next to it.
    BoxNotInMemory,
}

impl fmt::Display for LockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BoxEmpty => "the box has no pixels: width and height must be at least 1",
            Self::BoxOutsideFrame => "the box is not wholly inside the frame",
            Self::BoxNotInMemory => "the part of the frame in memory does not cover the box and the pixels next to it",
        })
    }
}

impl core::error::Error for LockError {}

/// Why a frame was not searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum UpdateError {
    /// There is no target yet: call [`Tracker::lock`] first.
    NotLocked,
    /// The frame is not of the size of the frame that was locked on.
    FrameSizeChanged,
    /// The part of the frame in memory does not cover [`Tracker::window`].
    WindowNotInMemory,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotLocked => "there is no target yet: lock first",
            Self::FrameSizeChanged => "the frame is not of the size of the one that was locked on",
            Self::WindowNotInMemory => "the part of the frame in memory does not cover the search window",
        })
    }
}

impl core::error::Error for UpdateError {}
