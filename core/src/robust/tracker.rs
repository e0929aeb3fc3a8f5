//! The way of a frame through the robust tracker: window, features, filter, size, verification, learning, answer.

use super::agreement::{self, Scene};
use super::config::Config;
use super::early::Early;
use super::features::{CELL, CHANNELS, Strip};
use super::filter::{Desk, Filter, Sample, layout};
use super::grid::{Grid, MOST_SIDE, SCALE};
use super::responses::{Peak, Responses, SPAN};
use super::track::{FineRect, Place, Track};
use super::trust::{Evidence, Trust};
use super::{MOST_CELLS, MOST_PIXELS, REACH};
use crate::image::{Frame, Image, Rect};
use crate::similarity::{Backend, Products};
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
    /// It has not agreed for some frames: the target is not seen. The box is what is followed meanwhile; nothing is learned
    /// from it, and the target is looked for elsewhere.
    Lost,
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
    /// How much speaks for it, 0 to 65535: a running mean of the early template's agreement, two thirds, and of the filter's
    /// response, one third. Below 15,733 the target is lost, below 26,666 it is uncertain.
    pub confidence: u16,
    /// How well the early template agrees in this frame, in units of 1/65535: the fourth least ratio of its 16 parts.
    pub ratio: u16,
    /// The filter's response at the place, in units of 1/16384: about 1 where the target looks as it did.
    pub response: i32,
    /// The target's size against that of the box that was locked on, in units of 1/65536.
    pub scale: u32,
    /// True if the sweep found the target, in this frame.
    pub found_again: bool,
    /// Products of the filter and comparisons of the template that it took.
    pub work: u32,
}

/// Bytes of the largest window of cells: the longest filter has the longest rim.
const WINDOW: usize =
    (MOST_SIDE + 2 * REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * REACH as usize) * CHANNELS;
/// Bytes of the largest window that sizes are looked for in.
const ASIDE: usize =
    (MOST_SIDE + 2 * SIZE_REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * SIZE_REACH as usize) * CHANNELS;
/// Pixels of the largest view, a template and a pixel on each side.
const VIEW: usize = 2048;
/// Steps of learning from the first frame.
const FIRST_STEPS: u32 = 25;
/// The scales beside the last one: 1.02 times and 1 / 1.02 times.
const SIZE_STEP: u64 = 66_847;
/// What their responses count, in units of 1/256.
const SIZE_PART: i64 = 252;
/// How far they are searched, in cells.
const SIZE_REACH: u16 = 1;
/// The least and the most that a target may have grown.
const LEAST_SCALE: u32 = SCALE / 5;
const MOST_SCALE: u32 = 5 * SCALE;

/// Follows one target, whose size, light and view may change. All memory is in here.
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
/// let mut tracker = Tracker::new(Config::robust());
/// let first = picture(20, 30);
/// tracker.lock(&Frame::whole(Image::new(&first, 160, 120)?), Rect::new(20, 30, 40, 40))?;
/// let second = picture(26, 33);
/// let answer = tracker.update(&Frame::whole(Image::new(&second, 160, 120)?))?;
/// assert_eq!((answer.bbox.x, answer.bbox.y), (26, 33));
/// assert_eq!(answer.state, State::Tracking);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Tracker {
    config: Config,
    track: Option<Track>,
    filter: Filter,
    early: Early,
    // Scratch from here on.
    strip: Strip,
    cells: Vec<i8, WINDOW>,
    responses: Responses,
    /// Cells of another scale.
    aside: Vec<i8, ASIDE>,
    desk: Desk,
    view: Vec<u8, VIEW>,
    lit: Vec<u8, MOST_PIXELS>,
}

/// What a look at a window says.
#[derive(Clone, Copy)]
struct Look {
    place: Place,
    peak: Peak,
    agreement: u16,
}

impl Look {
    fn evidence(&self) -> Evidence {
        Evidence::of(self.agreement, self.peak.response)
    }
}

impl Tracker {
    /// A tracker without a target.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new(config: Config) -> Self {
        Self {
            config,
            track: None,
            filter: Filter::new(),
            early: Early::new(),
            strip: Strip::new(),
            cells: Vec::new(),
            responses: Responses { rows: [[0; SPAN]; SPAN], span: SPAN },
            aside: Vec::new(),
            desk: Desk::new(),
            view: Vec::new(),
            lit: Vec::new(),
        }
    }

    /// Takes other numbers, in place. Whatever was followed before is forgotten.
    ///
    /// ```
    /// use smr_core::robust::{Config, Tracker};
    /// // As a `static` a tracker is not made on the stack.
    /// static EMPTY: Tracker = Tracker::new(Config::robust());
    /// # let mut tracker = Box::new(Tracker::new(Config::robust()));
    /// let mut config = Config::robust();
    /// config.size = false;
    /// tracker.configure(config);
    /// assert!(!tracker.config().size && tracker.window().is_none());
    /// ```
    pub const fn configure(&mut self, config: Config) {
        self.config = config;
        self.track = None;
    }

    /// The pixels of a frame with these bounds that [`Tracker::lock`] reads for this target.
    #[must_use]
    pub fn lock_window(bounds: Rect, target: Rect) -> Rect {
        Place::of(target).window(&Grid::new(target), REACH).pixels(bounds)
    }

    /// Starts on the target in `target`, at any time; whatever was followed before is forgotten.
    ///
    /// Of the frame only the pixels in [`Tracker::lock_window`] are read. Cost: 75 products for each of at most 2000 weights and
    /// 289 offsets, as much as 25 updates.
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
        if !frame.covered().contains(Self::lock_window(bounds, target)) {
            return Err(LockError::SurroundingsNotInMemory);
        }
        let track = Track::new(bounds, target);
        track.place.view(&track.grid).sample(frame, &mut self.view);
        self.early.start(middle(&track.grid, &self.view));
        self.filter.start(&track.grid);
        self.see(frame, &track.grid, track.place);
        for _ in 0..FIRST_STEPS {
            let shift = self.filter.code(&mut self.desk);
            self.respond(&track.grid, shift);
            self.learn(&track.grid, (0, 0));
        }
        self.track = Some(track);
        Ok(())
    }

    /// Looks for the target in the next frame.
    ///
    /// Of the frame only the pixels in [`Tracker::window`] are read. Cost, for a filter of W weights (at most 2000) and a template
    /// of P pixels (at most 1600): 307 W products to look for it and its size; then 578 W to learn, or, while it is lost, 289 W to look
    /// elsewhere; and 9 P comparisons for each look.
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
        let mut next = track;
        let centre = track.expected(self.config.velocity);
        let shift = self.filter.code(&mut self.desk);
        let mut look = self.look(frame, &track, centre, shift);
        let mut work = work_of_looking(&track.grid);
        if self.config.verification {
            next.trust = track.trust.after(look.evidence());
        }
        let lost = next.trust.state() == State::Lost;
        let learns = !lost && (look.evidence().teaches() || !self.config.caution || !self.config.verification);
        if !lost {
            self.early.learn(middle(&track.grid, &self.view));
        }
        let target = offset(&track.grid, centre, look.place);
        if self.config.size {
            look.place.scale = self.size(frame, &track, &look, shift);
            work += 2 * u32::from(2 * SIZE_REACH + 1).pow(2) * weights(&track.grid);
        }
        next.follow(look.place);
        let mut found_again = false;
        if lost && self.config.sweep {
            let elsewhere = self.look(frame, &track, track.sweep(), shift);
            work += work_of_looking(&track.grid);
            next.swept();
            if elsewhere.evidence().finds(look.evidence()) {
                next.find(elsewhere.place);
                next.trust = Trust::found(elsewhere.evidence());
                (look, found_again) = (elsewhere, true);
            }
        }
        if learns {
            // Cells and responses are those of the first look: only a lost target is looked for elsewhere.
            self.learn(&track.grid, target);
            work += 2 * u32::from(2 * REACH + 1).pow(2) * weights(&track.grid);
        }
        if next.trust.state() == State::Tracking {
            next.believe();
        }
        self.track = Some(next);
        let fine = next.bbox();
        Ok(Answer {
            fine,
            bbox: fine.whole(),
            state: next.trust.state(),
            confidence: next.trust.confidence(),
            ratio: look.agreement,
            response: look.peak.response,
            scale: next.place.scale,
            found_again,
            work,
        })
    }

    /// The pixels of the frame that the next [`Tracker::update`] may read; `None` before the first lock. It has room for the two scales that
    /// the size is looked for at; while the target is uncertain or lost the sweep's window is in it, too.
    #[must_use]
    pub fn window(&self) -> Option<Rect> {
        self.track.as_ref().map(|track| self.pixels_of(track))
    }

    /// The early template, by which the track is verified, row by row; `None` before the first lock. Its shape is that of
    /// [`Tracker::grid`].
    #[must_use]
    pub fn early_template(&self) -> Option<impl ExactSizeIterator<Item = u8>> {
        self.track.as_ref().map(|_| self.early.pixels())
    }

    /// The filter's weights, cell by cell and [`CHANNELS`] in each, in units of 1/65536 of a response's 1/16384; none before the
    /// first lock.
    #[must_use]
    pub fn weights(&self) -> &[i32] {
        self.filter.weights()
    }

    /// The cells of the search window as the next [`Tracker::update`] will see them in this frame, row by row and [`CHANNELS`] bytes
    /// in each: the filter's and [`REACH`] more on each side. Nothing but scratch memory changes.
    ///
    /// # Errors
    /// Those of [`Tracker::update`].
    pub fn features(&mut self, frame: &Frame<'_>) -> Result<&[i8], UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let centre = track.expected(self.config.velocity);
        if !self.see(frame, &track.grid, centre) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok(&self.cells)
    }

    /// The filter's responses to those cells, in units of 1/16384, row by row: up to [`REACH`] cells from the middle to each side, near
    /// and far ones alike. Nothing but scratch memory changes.
    ///
    /// # Errors
    /// Those of [`Tracker::update`].
    pub fn response_map(&mut self, frame: &Frame<'_>) -> Result<[[i32; SPAN]; SPAN], UpdateError> {
        self.features(frame)?;
        let shift = self.filter.code(&mut self.desk);
        let grid = self.grid().ok_or(UpdateError::NotLocked)?;
        self.respond(&grid, shift);
        Ok(self.responses.rows)
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

    fn backend(&self) -> Backend {
        self.config.backend.unwrap_or_else(Backend::best)
    }

    fn products(&self) -> Products {
        Products::new(self.backend())
    }

    /// What may be read: the window, what the size is looked for in wherever in it the target is, and the sweep's next window.
    fn pixels_of(&self, track: &Track) -> Rect {
        let Config { velocity, size, verification, sweep, .. } = self.config;
        let centre = track.expected(velocity);
        let mut near = centre.window(&track.grid, REACH).pixels(track.bounds);
        if size {
            for scale in other_scales(centre.scale) {
                let window = Place { scale, ..centre }.window(&track.grid, REACH + 2 * SIZE_REACH);
                near = union(near, window.pixels(track.bounds));
            }
        }
        // Whether this is the frame in which it is lost is known only after it was looked at.
        if !sweep || !verification || !track.trust.may_be_lost_next() {
            return near;
        }
        union(near, track.sweep().window(&track.grid, REACH).pixels(track.bounds))
    }

    /// Makes the cells of a search window.
    fn see(&mut self, frame: &Frame<'_>, grid: &Grid, place: Place) -> bool {
        self.strip.features(frame, &place.window(grid, REACH), &mut self.cells)
    }

    /// Makes the filter's responses to them.
    fn respond(&mut self, grid: &Grid, shift: u32) {
        let products = self.products();
        let Self { desk, cells, responses, .. } = self;
        desk.responses(products, shift, cells, layout(grid, SPAN), &mut responses.rows);
    }

    /// Learns from both that the target is at `target`.
    fn learn(&mut self, grid: &Grid, target: (i32, i32)) {
        let products = self.products();
        let Self { filter, desk, cells, responses, .. } = self;
        filter.learn(grid, &Sample { cells, responses, target }, desk, products);
    }

    /// Where the target is in the window around `centre`, and how well the early template agrees there.
    #[inline(never)] // one copy in flash
    fn look(&mut self, frame: &Frame<'_>, track: &Track, centre: Place, shift: u32) -> Look {
        let grid = track.grid;
        self.see(frame, &grid, centre);
        self.respond(&grid, shift);
        let peak = self.responses.peak(self.config.near);
        let step = grid.step_at(centre.scale);
        // 1/256 cell is 1/64 pixel of the grid.
        let moved = |from: i64, by: i32| from + ((i64::from(by) * step) >> 6);
        let place = Place { x: moved(centre.x, peak.x), y: moved(centre.y, peak.y), ..centre }.inside(track.bounds);
        let lattice = place.view(&grid);
        lattice.sample(frame, &mut self.view);
        let backend = self.backend();
        let Self { view, early, lit, config, .. } = self;
        let agreement = Image::new(view, lattice.columns, lattice.rows).map_or(0, |view| {
            let scene = Scene { view, early, columns: grid.columns, rows: grid.rows };
            agreement::best(&scene, lit, (backend, config.table))
        });
        Look { place, peak, agreement }
    }

    /// The scale of what was looked at: a little smaller, a little larger, or as it was.
    #[inline(never)] // its stack is not that of a look
    fn size(&mut self, frame: &Frame<'_>, track: &Track, look: &Look, shift: u32) -> u32 {
        let products = self.products();
        let (mut response, mut best) = (look.peak.response, look.place.scale);
        for scale in other_scales(look.place.scale) {
            let lattice = Place { scale, ..look.place }.window(&track.grid, SIZE_REACH);
            let Self { strip, aside, desk, .. } = self;
            strip.features(frame, &lattice, aside);
            let span = 2 * usize::from(SIZE_REACH) + 1;
            let mut responses = Responses { rows: [[0; SPAN]; SPAN], span };
            desk.responses(products, shift, aside, layout(&track.grid, span), &mut responses.rows);
            let peak = responses.peak(false);
            let counts = i32::try_from((i64::from(peak.response) * SIZE_PART) >> 8).unwrap_or(0);
            if counts > response {
                (response, best) = (counts, scale);
            }
        }
        best
    }
}

/// A little smaller, and a little larger.
fn other_scales(scale: u32) -> [u32; 2] {
    let scale = u64::from(scale);
    [(scale << 16) / SIZE_STEP, (scale * SIZE_STEP) >> 16]
        .map(|scale| u32::try_from(scale).unwrap_or(SCALE).clamp(LEAST_SCALE, MOST_SCALE))
}

/// The template in the middle of a view.
fn middle<'a>(grid: &Grid, view: &'a [u8]) -> impl Iterator<Item = u8> + use<'a> {
    let (columns, rows) = (usize::from(grid.columns), usize::from(grid.rows));
    view.chunks(columns + 2).skip(1).take(rows).flat_map(move |row| row.iter().skip(1).take(columns).copied())
}

/// Where the target is in a window, from its middle, in units of 1/256 cell.
fn offset(grid: &Grid, centre: Place, target: Place) -> (i32, i32) {
    let cell = (i64::from(CELL) * grid.step_at(centre.scale)).max(1);
    let part = |to: i64, from: i64| i32::try_from((to - from) * 256 / cell).unwrap_or(0);
    (part(target.x, centre.x), part(target.y, centre.y))
}

fn weights(grid: &Grid) -> u32 {
    u32::from(grid.across) * u32::from(grid.down) * u32::try_from(CHANNELS).unwrap_or(0)
}

fn work_of_looking(grid: &Grid) -> u32 {
    u32::from(2 * REACH + 1).pow(2) * weights(grid) + 9 * grid.pixels()
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
    /// The part of the frame in memory does not cover the target's surroundings, [`Tracker::lock_window`].
    SurroundingsNotInMemory,
}

impl fmt::Display for LockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BoxEmpty => "the box has no pixels: width and height must be at least 1",
            Self::BoxOutsideFrame => "the box is not wholly inside the frame",
            Self::SurroundingsNotInMemory => {
                "the part of the frame in memory does not cover what lock reads (the lock window)"
            }
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
