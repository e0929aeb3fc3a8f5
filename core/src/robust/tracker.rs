//! The way of a frame through the robust tracker: window, peak, size, verification, templates, answer.

use super::agreement::{self, Agreement};
use super::cells;
use super::config::{Config, ThresholdRule};
use super::correlation::{self, Likely};
use super::grid::{Grid, Lattice, PIXEL, SCALE};
use super::sweep::Sweep;
use super::templates::Mean;
use super::trust::{self, Trust};
use super::{RADIUS, Search, light, peak, threshold};
use crate::Radius;
use crate::image::{Frame, Image, Rect};
use crate::search::{Peak, Scene, Wanted, Window};
use crate::similarity::{Backend, Scorer, Table};
use core::cmp::Reverse;
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
    /// How well the early template agrees, in units of 1/65535: the fourth least ratio of its 16 parts. Without verification,
    /// how well the templates match.
    pub ratio: u16,
    /// The target's size against that of the box that was locked on, in units of 1/65536.
    pub scale: u32,
    /// The threshold that this frame was scored with, in gray levels: a pixel counted if it differed by less.
    pub alpha: u16,
    /// The search's peak on the grid, by all templates: offsets from the window's first, 32 being the last position, and the
    /// score of the last patch twice, of the slow template, and of the anchor twice.
    pub peak: Peak,
    /// True if the sweep found the target, in this frame.
    pub found_again: bool,
    /// Comparisons of bytes that it took, at most, and products of the sweep.
    pub comparisons: u32,
}

/// Follows one target, whose size, light and view may change. `PIXELS` is the most pixels of the template on the grid, 1024
/// as it was measured; `WINDOW` the most of the search window. All memory is in here: about `2 * WINDOW + 9 * PIXELS` bytes.
///
/// ```
/// use smr_core::robust::{Config, State, Tracker};
/// use smr_core::{Frame, Image, Rect};
///
/// // A target of 40x40 pixels with some texture, on a plain ground.
/// fn picture(left: usize, top: usize) -> Vec<u8> {
///     let mut pixels = vec![90; 160 * 120];
///     for (y, x) in (0..40).flat_map(|y| (0..40).map(move |x| (y, x))) {
///         pixels[(top + y) * 160 + left + x] = ((x / 5 * 37 + y / 5 * 59) % 200) as u8;
///     }
///     pixels
/// }
///
/// let mut tracker: Tracker = Tracker::new(Config::robust());
/// let first = picture(20, 30);
/// tracker.lock(&Frame::whole(Image::new(&first, 160, 120)?), Rect::new(20, 30, 40, 40))?;
/// let second = picture(26, 33);
/// let answer = tracker.update(&Frame::whole(Image::new(&second, 160, 120)?))?;
/// assert_eq!((answer.bbox.x, answer.bbox.y), (26, 33));
/// assert_eq!(answer.state, State::Tracking);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Tracker<const PIXELS: usize = 1024, const WINDOW: usize = 12288> {
    config: Config,
    window: Vec<u8, WINDOW>,
    search: Search<WINDOW>,
    patch: Vec<u8, PIXELS>,
    last: Vec<u8, PIXELS>,
    slow: Mean<PIXELS>,
    early: Mean<PIXELS>,
    /// The early template in the light of the last patch.
    anchor: Vec<u8, PIXELS>,
    track: Option<Track>,
}

/// What is remembered of a target beside its templates.
#[derive(Clone, Copy)]
struct Track {
    bounds: Rect,
    /// Of the box that was locked on.
    width: u16,
    height: u16,
    grid: Grid,
    place: Place,
    alpha: u16,
    /// The scale when the target was last believed.
    believed: u32,
    trust: Trust,
    state: State,
    sweep: Sweep,
}

/// The target's middle and size.
#[derive(Clone, Copy)]
struct Place {
    x: i64,
    y: i64,
    scale: u32,
}

/// The running means' rates, as powers of two.
const SLOW: u32 = 5;
const EARLY: u32 = 8;
/// A growth in a frame, squared, in units of 1/65536: at most 1.05, at least 1 / 1.05.
const MOST_GROWTH: u32 = 72_253;
const LEAST_GROWTH: u32 = 59_443;
/// Grid pixels around the window that a larger patch at the peak may need.
const MARGIN: u16 = 4;
/// The same around the sweep's window, for the closer look at its edge.
const SWEEP_MARGIN: u16 = 2;
/// A closer look goes so far around, in pixels of the grid.
const CLOSER: u16 = 2;

impl<const PIXELS: usize, const WINDOW: usize> Tracker<PIXELS, WINDOW> {
    /// A tracker without a target.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new(config: Config) -> Self {
        const { assert!(PIXELS <= 1024 && PIXELS >= 16, "cells and scores are made for templates of 16 to 1024 pixels") };
        const { assert!(WINDOW >= 68 * 68, "the smallest template needs a window of 68x68") };
        Self {
            config,
            window: Vec::new(),
            search: Search::new(),
            patch: Vec::new(),
            last: Vec::new(),
            slow: Mean::new(),
            early: Mean::new(),
            anchor: Vec::new(),
            track: None,
        }
    }

    /// Starts on the target in `target`, at any time; whatever was followed before is forgotten. Only the pixels of the box
    /// and one more on each side are read.
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
        let grid = Grid::new(target, PIXELS, WINDOW, self.config.enlarging);
        let middle = |from: i32, size: u16| (2 * i64::from(from) + i64::from(size) - 1) * PIXEL / 2;
        let place = Place { x: middle(target.x, target.width), y: middle(target.y, target.height), scale: SCALE };
        if !lattice(&grid, place, 0).sample(frame, &mut self.patch) {
            return Err(LockError::BoxNotInMemory);
        }
        self.last.clear();
        // Cannot fail: both have the same capacity.
        let _ = self.last.extend_from_slice(&self.patch);
        self.slow.start(&self.patch);
        self.early.start(&self.patch);
        self.anchor.clear();
        let _ = self.anchor.extend_from_slice(&self.patch);
        let alpha = match self.config.threshold {
            ThresholdRule::Contrast => threshold::by_contrast(&self.patch),
            ThresholdRule::LargestChange(_) => FIRST_ALPHA,
        };
        self.track = Some(Track {
            bounds,
            width: target.width,
            height: target.height,
            grid,
            place,
            alpha,
            believed: SCALE,
            trust: Trust::new(),
            state: State::Tracking,
            sweep: Sweep::new(),
        });
        Ok(())
    }

    /// Looks for the target in the next frame.
    ///
    /// Of the frame only the pixels in [`Tracker::window`] are read. Cost: two searches of 65x65 offsets over the template's
    /// pixels, most of which are left out where the target is seen clearly, and at most 156,800 comparisons for the cells; while the
    /// target is lost or doubtful, one product more for each offset and each of a quarter of the template's pixels.
    ///
    /// # Errors
    /// [`UpdateError`]; the tracker is then as it was before.
    pub fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        let track = self.look(frame)?;
        let mut next = track;
        let scorer = scorer(&self.config, track.alpha);
        let (peak, mut comparisons) = self.follow(&track, &scorer, &mut next);
        let mut ratio = self.ratio_of_templates(&track, peak.score);
        let mut found_again = false;
        if self.config.verification {
            ratio = self.agreement(&track, &peak);
            comparisons = comparisons.saturating_add(9 * track.grid.pixels());
            next.trust = track.trust.after(ratio);
            next.state = next.trust.state(ratio);
            if next.trust.sweeps() && self.config.sweep {
                let (found, more) = self.sweep(frame, &track, ratio);
                comparisons = comparisons.saturating_add(more);
                next.sweep.advance();
                if let Some((place, agreement)) = found {
                    next = Track { place, trust: Trust::new(), state: State::Tracking, ..next };
                    (ratio, found_again) = (agreement, true);
                }
            }
        }
        self.learn(frame, &mut next, found_again);
        self.track = Some(next);
        let fine = next.fine();
        Ok(Answer {
            fine,
            bbox: whole(fine),
            state: next.state,
            ratio,
            scale: next.place.scale,
            alpha: track.alpha,
            peak,
            found_again,
            comparisons,
        })
    }

    /// The pixels of the frame that the next [`Tracker::update`] may read; `None` before the first lock. While the target is
    /// lost or doubtful the sweep's window is in it, too.
    #[must_use]
    pub fn window(&self) -> Option<Rect> {
        self.track.as_ref().map(|track| self.pixels_of(track))
    }

    /// The search window on the grid, as the next [`Tracker::update`] will see it in this frame: the templates are compared
    /// with its parts. Nothing but scratch memory changes.
    ///
    /// # Errors
    /// Those of [`Tracker::update`].
    pub fn window_on_grid(&mut self, frame: &Frame<'_>) -> Result<Image<'_>, UpdateError> {
        let Grid { columns, rows, .. } = self.look(frame)?.grid;
        // Cannot fail: the window is as large as it was just made.
        Image::new(&self.window, columns + 2 * RADIUS, rows + 2 * RADIUS).map_err(|_| UpdateError::WindowNotInMemory)
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

    /// The early template in the light of the last patch; `None` before the first lock.
    #[must_use]
    pub fn anchor(&self) -> Option<Image<'_>> {
        self.image(&self.anchor)
    }

    /// The grid; `None` before the first lock.
    #[must_use]
    pub fn grid(&self) -> Option<Grid> {
        self.track.map(|track| track.grid)
    }

    /// alpha of the next [`Tracker::update`]; 0 before the first lock.
    #[must_use]
    pub fn alpha(&self) -> u16 {
        self.track.map_or(0, |track| track.alpha)
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

    /// Samples the search window, if all that an update may read is there.
    fn look(&mut self, frame: &Frame<'_>) -> Result<Track, UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let window = lattice(&track.grid, track.place, RADIUS);
        if !frame.covered().contains(self.pixels_of(&track)) || !window.sample(frame, &mut self.window) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok(track)
    }

    /// What may be read: the window, a little around it for a patch that has grown, and the sweep's next window.
    fn pixels_of(&self, track: &Track) -> Rect {
        let near = lattice(&track.grid, track.place, RADIUS + MARGIN).pixels(track.bounds);
        if !self.config.sweep || !self.config.verification {
            return near;
        }
        // Whether this frame is the one in which the sweep begins is known only after it was looked at.
        if !track.trust.may_sweep_next() {
            return near;
        }
        union(near, track.sweep_window(SWEEP_MARGIN).pixels(track.bounds))
    }

    /// Peak, position and size in the window. Says what was found and what it cost.
    #[inline(never)] // one copy in flash
    fn follow(&mut self, track: &Track, scorer: &Scorer, next: &mut Track) -> (Peak, u32) {
        let grid = track.grid;
        let around = 2 * RADIUS;
        let Self { window, search, last, slow, anchor, config, .. } = self;
        let (Ok(window), Ok(last), Ok(slow), Ok(anchor)) = (
            Image::new(window, grid.columns + around, grid.rows + around),
            Image::new(last, grid.columns, grid.rows),
            Image::new(slow.pixels(), grid.columns, grid.rows),
            Image::new(anchor, grid.columns, grid.rows),
        ) else {
            return (CENTRE, 0);
        };
        let both = if config.slow_template { Some(slow) } else { None };
        let score = |x: i32, y: i32| {
            let patch = window.crop(Rect::new(x, y, grid.columns, grid.rows))?;
            let anchored = if config.anchor { 2 * scorer.score(patch, anchor) } else { 0 };
            Some(2 * scorer.score(patch, last) + scorer.score(patch, both.unwrap_or(last)) + anchored)
        };
        let mut comparisons = 0;
        let mut best = CENTRE;
        for template in [Some(last), both].into_iter().flatten() {
            let (found, work) = find(search, window, template, scorer, config.pruning);
            comparisons += work + 9 * 3 * u32::from(grid.columns) * u32::from(grid.rows);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let (x, y) = (found.x + dx, found.y + dy);
                if let Some(score) = score(x, y) {
                    let candidate = Peak { x, y, score };
                    if rank(&candidate) > rank(&best) {
                        best = candidate;
                    }
                }
            }
        }
        let step = grid.step_at(track.place.scale);
        let near = |dx: i32, dy: i32| score(best.x + dx, best.y + dy);
        let part = |before: Option<u32>, after: Option<u32>| match (before, after) {
            (Some(before), Some(after)) if config.sub_pixel => peak::top(before, best.score, after),
            _ => 0,
        };
        let (right, down) = (part(near(-1, 0), near(1, 0)), part(near(0, -1), near(0, 1)));
        let moved = |from: i64, offset: i32, part: i64, size: u16| {
            let grid_pixels = (i64::from(offset) - i64::from(RADIUS)) * PIXEL + part;
            (from + ((grid_pixels * step) >> 12)).clamp(0, end_of(size))
        };
        next.place.x = moved(track.place.x, best.x, right, track.bounds.width);
        next.place.y = moved(track.place.y, best.y, down, track.bounds.height);
        if config.cells {
            let scene = cells::Scene { window, last, slow: both.unwrap_or(last), x: best.x, y: best.y, scorer };
            comparisons += cells::comparisons(last);
            if let Some(growth) = cells::growth_squared(&scene) {
                next.place.scale = grown(track.place.scale, growth);
            }
        }
        (best, comparisons)
    }

    fn ratio_of_templates(&self, track: &Track, score: u32) -> u16 {
        let weights = if self.config.anchor { 5 } else { 3 };
        u16::try_from(score / (weights * track.grid.pixels()).max(1)).unwrap_or(Table::ONE)
    }

    /// The early template's best agreement at the peak and one pixel of the grid around it.
    fn agreement(&mut self, track: &Track, peak: &Peak) -> u16 {
        let (columns, rows) = (track.grid.columns, track.grid.rows);
        let Self { window, early, patch: lit, config, .. } = self;
        let Ok(view) = Image::new(window, columns + 2 * RADIUS, rows + 2 * RADIUS) else { return 0 };
        let scene = agreement::Scene { view, early: early.pixels(), columns, rows };
        agreement::best(&scene, (peak.x, peak.y), 1, lit, |alpha| scorer(config, alpha)).ratio
    }

    /// Looks for the early template in the sweep's next window. Says where it is, if it agrees there, and what it cost.
    #[inline(never)] // one copy in flash
    fn sweep(&mut self, frame: &Frame<'_>, track: &Track, followed: u16) -> (Option<(Place, u16)>, u32) {
        let (likely, cost) = self.likely(frame, track);
        let Some(place) = likely else { return (None, cost) };
        let cost = cost.saturating_add(u32::from(2 * CLOSER + 1).pow(2) * track.grid.pixels());
        let found = self.look_closer(frame, track, place);
        let clear =
            |(_, ratio): &(Place, u16)| *ratio >= trust::SEEN_AGAIN && *ratio >= followed.saturating_add(BETTER);
        (found.filter(clear), cost)
    }

    /// Where in the sweep's window the early template may be, at half the grid's resolution, and what it cost.
    #[inline(never)] // its stack is not that of the closer look
    fn likely(&mut self, frame: &Frame<'_>, track: &Track) -> (Option<Place>, u32) {
        let lattice = track.sweep_window(0);
        let Self { window, early, patch: half, .. } = self;
        let grid = track.grid;
        let Ok(early) = Image::new(early.pixels(), grid.columns, grid.rows) else { return (None, 0) };
        let (columns, rows) = correlation::halve(early, half);
        if !lattice.sample(frame, window) {
            return (None, 0);
        }
        let (Ok(window), Ok(half)) =
            (Image::new(window, lattice.columns, lattice.rows), Image::new(half, columns, rows))
        else {
            return (None, 0);
        };
        let place = correlation::find(window, half).map(|Likely { x, y }| track.at(&lattice, x, y, RADIUS));
        (place, correlation::products_in(window, half))
    }

    /// Where around `place` the early template agrees best, and how well.
    #[inline(never)] // its stack is not that of the coarse look
    fn look_closer(&mut self, frame: &Frame<'_>, track: &Track, place: Place) -> Option<(Place, u16)> {
        let Self { window, early, patch: lit, config, .. } = self;
        let lattice = lattice(&track.grid, place, CLOSER);
        if !lattice.sample(frame, window) {
            return None;
        }
        let view = Image::new(window, lattice.columns, lattice.rows).ok()?;
        let Grid { columns, rows, .. } = track.grid;
        let scene = agreement::Scene { view, early: early.pixels(), columns, rows };
        let middle = i32::from(CLOSER);
        let Agreement { ratio, x, y } =
            agreement::best(&scene, (middle, middle), middle, lit, |alpha| scorer(config, alpha));
        Some((track.at(&lattice, x, y, CLOSER), ratio))
    }

    /// The templates and alpha of the next frame.
    #[inline(never)] // one copy in flash
    fn learn(&mut self, frame: &Frame<'_>, next: &mut Track, found_again: bool) {
        if !lattice(&next.grid, next.place, 0).sample(frame, &mut self.patch) {
            return;
        }
        if found_again {
            self.slow.start(self.early.pixels());
        } else {
            self.slow.learn(&self.patch, SLOW);
        }
        next.alpha = match self.config.threshold {
            ThresholdRule::Contrast => threshold::by_contrast(&self.patch),
            ThresholdRule::LargestChange(k) => {
                let largest = self.last.iter().zip(&self.patch).map(|(old, new)| old.abs_diff(*new)).max().unwrap_or(0);
                let alpha = u16::try_from(k.ceil_of(largest)).unwrap_or(256).min(256);
                if largest == 0 { next.alpha } else { alpha }
            }
        };
        if next.state != State::Lost {
            self.early.learn(&self.patch, EARLY);
        }
        if next.state == State::Tracking {
            next.believed = next.place.scale;
        }
        self.last.clear();
        let _ = self.last.extend_from_slice(&self.patch);
        if let Ok(last) = Image::new(&self.last, next.grid.columns, next.grid.rows) {
            let early = self.early.pixels();
            let was = threshold::Contrast::of(early.iter().copied());
            light::of(early, was, last, &mut self.anchor);
        }
    }
}

/// alpha before the first update, under the paper's rule.
const FIRST_ALPHA: u16 = 13;
/// By so much better than what is followed the early template has to agree with what the sweep found.
const BETTER: u16 = 20_000;

/// Where nothing is found, which does not happen: the last position.
const CENTRE: Peak = Peak { x: RADIUS as i32, y: RADIUS as i32, score: 0 };

/// What makes one offset better than another: its score, then how close it is to the last position, then the upper and the
/// left one.
fn rank(peak: &Peak) -> (u32, Reverse<(i32, i32, i32)>) {
    let (dx, dy) = (peak.x - CENTRE.x, peak.y - CENTRE.y);
    (peak.score, Reverse((dx * dx + dy * dy, peak.y, peak.x)))
}

/// The peak of `template` in `window`, and what it cost.
fn find<const WINDOW: usize>(
    search: &mut Search<WINDOW>,
    window: Image<'_>,
    template: Image<'_>,
    scorer: &Scorer,
    pruning: bool,
) -> (Peak, u32) {
    let frame = Frame::whole(window);
    let target = Rect::new(CENTRE.x, CENTRE.y, template.width(), template.height());
    let offsets = Window::new(target, Radius { x: RADIUS, y: RADIUS }, frame.bounds(), 0);
    let scene = Scene { frame, template, window: offsets, scorer };
    search.begin(&scene.window, pruning, Wanted::Peak);
    let mut work = 0;
    while !search.is_done() {
        work += search.step(&scene, u32::MAX);
    }
    (search.found(&offsets).map_or(CENTRE, |found| found.peak), work)
}

/// `scale`, times the fourth root of `growth`, which is squared: half of the way, as logarithms go.
fn grown(scale: u32, growth: u32) -> u32 {
    let growth = u64::from(growth.clamp(LEAST_GROWTH, MOST_GROWTH));
    let factor = ((growth << 16).isqrt() << 16).isqrt();
    let scale = (u64::from(scale) * factor + (1 << 15)) >> 16;
    u32::try_from(scale).unwrap_or(SCALE).clamp(SCALE / 4, 4 * SCALE)
}

/// The template at `place`, and so many pixels of the grid around it.
fn lattice(grid: &Grid, place: Place, around: u16) -> Lattice {
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

impl Track {
    /// The sweep's next window, at half the grid's resolution and the scale that was last believed, with so much around it.
    fn sweep_window(&self, around: u16) -> Lattice {
        let Grid { columns, rows, .. } = self.grid;
        let side = |size: u16| size / 2 + 2 * (RADIUS + around);
        let step = 2 * self.grid.step_at(self.believed);
        let window = Lattice { x: 0, y: 0, step, columns: side(columns), rows: side(rows) };
        self.sweep.place(window, self.bounds)
    }

    /// The place at an offset of a window that reaches `radius` to each side of the template, at the believed scale.
    fn at(&self, window: &Lattice, x: i32, y: i32, radius: u16) -> Place {
        let at = |centre: i64, offset: i32, size: u16| {
            (centre + (i64::from(offset) - i64::from(radius)) * window.step).clamp(0, end_of(size))
        };
        Place { x: at(window.x, x, self.bounds.width), y: at(window.y, y, self.bounds.height), scale: self.believed }
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    #[test]
    fn memory_is_twice_the_window_and_nine_times_the_template() {
        let size = size_of::<Tracker>();
        println!("robust::Tracker: {size} bytes");
        assert!(size <= 2 * 12288 + 9 * 1024 + 2400, "{size} bytes");
        assert!(size <= 48 * 1024);
    }
}
