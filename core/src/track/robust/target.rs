//! The robust tracker's target: what is remembered, locked on, shown, and changed at the end of an update.

use super::config::Config;
use super::early::Early;
use super::exact::RIM;
use super::filter::{Filter, layout};
use super::grid::Grid;
use super::responses::SPAN;
use super::saved;
use super::track::{Place, Track};
use super::update::{SIZE_REACH, other_scales};
use super::workspace::Workspace;
use crate::image::{FineRect, Frame, Rect};
use crate::kernels::Products;
use crate::similarity::Backend;
use crate::track::target::{lock_goes_on, lockable};
use crate::track::update::{SEAL, Seal, Steps, Ticket, UnderWay};
use crate::track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, UpdateError,
};

/// The threshold by which a target is compared with itself when it is locked, in gray levels: 0.05 of full scale.
const FIRST_THRESHOLD: u16 = 13;

/// A target of the robust tracker: size, light and view may change.
///
/// ```
/// use smr_core::{Frame, Image, Rect, Robust, State, Tracker, robust::Config};
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
/// let mut tracker = Tracker::<Robust>::new(Config::robust())?;
/// let first = picture(20, 30);
/// tracker.lock(&Frame::whole(Image::new(&first, 160, 120)?), Rect::new(20, 30, 40, 40))?;
/// let second = picture(26, 33);
/// let answer = tracker.update(&Frame::whole(Image::new(&second, 160, 120)?))?;
/// assert_eq!((answer.bbox.x, answer.bbox.y), (26, 33));
/// assert_eq!(answer.state, State::Tracking);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Robust {
    pub(super) config: Config,
    pub(super) track: Option<Track>,
    pub(super) filter: Filter,
    pub(super) early: Early,
    pub(super) ticket: Ticket,
}

impl Robust {
    /// No target yet, for a `const` or a `static`. At run time see [`Target::new`].
    ///
    /// # Panics
    /// If a number of the configuration cannot be used: in a `const` or a `static` the compiler says so.
    #[must_use]
    #[allow(clippy::panic)] // the compiler's
    pub const fn const_new(config: Config) -> Self {
        match config.check() {
            Ok(()) => Self { config, track: None, filter: Filter::new(), early: Early::new(), ticket: Ticket::NEW },
            Err(_) => panic!("a number of the configuration cannot be used"),
        }
    }

    /// The early template, by which the track is verified, row by row; `None` before the first lock. Its shape is that of
    /// [`Robust::grid`].
    #[must_use]
    pub fn early_template(&self) -> Option<impl ExactSizeIterator<Item = u8>> {
        self.track.as_ref().map(|_| self.early.pixels())
    }

    /// The filter's weights, cell by cell and [`CHANNELS`](super::CHANNELS) in each, in units of 1/65536 of a response's 1/16384;
    /// none before the first lock.
    #[must_use]
    pub fn weights(&self) -> &[i32] {
        self.filter.weights()
    }

    /// The cells of the search window as the next update will see them in this frame, row by row and
    /// [`CHANNELS`](super::CHANNELS) bytes in each: the filter's and `Config::reach` more on each side.
    ///
    /// # Errors
    /// Those of [`Target::update`]. An update under way in this workspace is given up.
    pub fn features<'a>(&self, workspace: &'a mut Workspace, frame: &Frame<'_>) -> Result<&'a [i8], UpdateError> {
        self.check(frame, SEAL)?;
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        workspace.under_way.end();
        let window = track.expected(self.config.parts.velocity).window(&track.grid, self.config.reach());
        if !workspace.see(frame, &window) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok(&workspace.cells)
    }

    /// The filter's responses to those cells, in units of 1/16384, row by row: up to `Config::reach` cells from the middle to each
    /// side, near and far ones alike; what lies beyond is 0.
    ///
    /// # Errors
    /// As [`Robust::features`].
    pub fn response_map(
        &self,
        workspace: &mut Workspace,
        frame: &Frame<'_>,
    ) -> Result<[[i32; SPAN]; SPAN], UpdateError> {
        self.features(workspace, frame)?;
        let grid = self.grid().ok_or(UpdateError::NotLocked)?;
        workspace.responses.rows = [[0; SPAN]; SPAN];
        workspace.respond(&self.filter, layout(&grid, self.config.span()), self.products());
        Ok(workspace.responses.rows)
    }

    /// The grid; `None` before the first lock.
    #[must_use]
    pub fn grid(&self) -> Option<Grid> {
        self.track.map(|track| track.grid)
    }

    fn products(&self) -> Products {
        Products::new(self.config.backend.unwrap_or_else(Backend::best))
    }

    /// What may be read where the target is followed: the window, the view wherever in it the target is, and what the size is looked for in there.
    fn near(&self, track: &Track) -> Rect {
        let centre = track.expected(self.config.parts.velocity);
        let reach = self.config.reach();
        let mut near = centre.window(&track.grid, reach + RIM).pixels(track.bounds);
        if self.config.size {
            for scale in other_scales(centre.scale) {
                let window = Place { scale, ..centre }.window(&track.grid, reach + 2 * SIZE_REACH);
                near = union(near, window.pixels(track.bounds));
            }
        }
        near
    }

    /// What may be read where a lost target is looked for. Whether the next frame is the one in which it is lost is known only
    /// after it was looked at.
    fn elsewhere(&self, track: &Track) -> Option<Rect> {
        let reach = self.config.reach();
        let may_be_lost = self.config.sweeps() && track.trust.may_be_lost_next(&self.config);
        may_be_lost.then(|| track.sweep(reach).window(&track.grid, reach + RIM).pixels(track.bounds))
    }
}

impl Target for Robust {
    type Config = Config;

    const SAVED_SIZE: usize = saved::SIZE;

    /// The same for every box: see [`Config::most_work`].
    fn most_work(config: &Config, _: u16, _: u16) -> MostWork {
        config.most_work()
    }

    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    fn new(config: Config) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config, track: None, filter: Filter::new(), early: Early::new(), ticket: Ticket::NEW })
    }

    fn config(&self) -> &Config {
        &self.config
    }

    /// The box and its surroundings, as far as a search window reaches.
    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect {
        if bounds.contains(target) {
            Place::of(target).window(&Grid::new(target), self.config.reach()).pixels(bounds)
        } else {
            Rect::default()
        }
    }

    fn window(&self) -> Option<Rect> {
        self.track.as_ref().map(|track| self.near(track))
    }

    fn sweep_window(&self) -> Option<Rect> {
        self.track.as_ref().and_then(|track| self.elsewhere(track))
    }

    fn bbox(&self) -> Option<FineRect> {
        self.track.map(|track| track.bbox())
    }

    fn state(&self) -> Option<State> {
        self.track.map(|track| track.trust.state(&self.config))
    }

    fn quality(&self) -> Option<Quality> {
        self.track.map(|track| track.quality)
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.ticket.change();
        if let Some(track) = &mut self.track {
            track.moved(right, down);
        }
    }

    fn saved_size(&self) -> Result<usize, SaveError> {
        saved::saved_size(self)
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        saved::save(self, bytes)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        saved::restore(self, bytes)
    }
}

impl Steps for Robust {
    type Workspace = Workspace;

    fn ticket(&mut self, _: &Seal) -> &mut Ticket {
        &mut self.ticket
    }

    fn under_way<'a>(workspace: &'a mut Workspace, _: &Seal) -> &'a mut UnderWay {
        &mut workspace.under_way
    }

    fn work(workspace: &Workspace) -> u32 {
        workspace.under_way.done()
    }

    fn check(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let covered = frame.covers(self.near(&track)) && self.elsewhere(&track).is_none_or(|rect| frame.covers(rect));
        if covered { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
    }

    fn check_lock(&self, frame: &Frame<'_>, target: Rect, _: &Seal) -> Result<(), LockError> {
        let bounds = frame.bounds();
        lockable(bounds, target)?;
        if frame.covers(self.lock_window(bounds, target)) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
    }

    fn check_lock_under_way(&self, workspace: &Workspace, frame: &Frame<'_>, _: &Seal) -> Result<(), LockError> {
        let track = workspace.progress.next.ok_or(LockError::NotBegun)?;
        let window = track.place.window(&track.grid, self.config.reach()).pixels(track.bounds);
        lock_goes_on(frame, track.bounds, window)
    }

    fn start(&mut self, workspace: &mut Workspace, _: &Seal) {
        if let Some(track) = self.track {
            self.given(track).begin(workspace);
        }
    }

    #[inline(never)] // its stack is not that of a step
    fn start_lock(&mut self, workspace: &mut Workspace, bounds: Rect, target: Rect, _: &Seal) {
        let track = Track::new(bounds, target);
        self.track = None;
        self.filter.start(&track.grid);
        self.given(track).begin_lock(workspace);
    }

    fn advance(&mut self, workspace: &mut Workspace, frame: &Frame<'_>, _: &Seal) -> bool {
        while self.go_on(workspace, frame) {
            if !self.learns_again(workspace) {
                return true;
            }
        }
        false
    }

    fn conclude(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: &Seal) -> Answer {
        let before = self.state();
        if let Some(mut next) = workspace.progress.next {
            if workspace.progress.learns {
                let patch = workspace.patch(&next.grid);
                patch.into_iter().for_each(|patch| self.early.learn(patch, self.config.early_rate));
            }
            if let Some(change) = workspace.progress.change {
                self.filter.apply(&workspace.desk, change);
            }
            if next.trust.state(&self.config) == State::Tracking {
                next.believe();
            }
            self.track = Some(next);
        }
        let fine = self.bbox().unwrap_or_default();
        let progress = &workspace.progress;
        let (state, confidence, scale) = self.track.map_or((State::Lost, 0, 1 << 16), |track| {
            (track.trust.state(&self.config), track.trust.confidence(), track.place.scale)
        });
        Answer {
            bbox: fine.whole(),
            fine,
            state,
            confidence,
            ratio: progress.look.agreement,
            runner_up_ratio: None,
            alpha: None,
            scale,
            found_again: before == Some(State::Lost) && state != State::Lost,
        }
    }

    #[inline(never)] // its stack is not that of a step
    fn conclude_lock(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: &Seal) -> Quality {
        let Some(mut track) = workspace.progress.next else { return Quality::NONE };
        workspace.table.set(self.config.table, FIRST_THRESHOLD);
        if let Some(patch) = workspace.patch(&track.grid) {
            track.quality = Quality::of(patch, &workspace.table);
            self.early.start(patch);
        }
        self.track = Some(track);
        track.quality
    }
}

impl Robust {
    /// Goes on until what is granted is spent; true when a step of learning, or all else, is done.
    fn go_on(&self, workspace: &mut Workspace, frame: &Frame<'_>) -> bool {
        // A lock has its track in the workspace. Not by `or`, which would have both on the stack.
        let Some(track) = (if self.track.is_some() { &self.track } else { &workspace.progress.next }) else {
            return true;
        };
        self.given(*track).step(workspace, frame)
    }

    /// A step of learning of a lock is done: changes the weights. True if there is another one to come.
    #[inline(never)] // its stack is not that of a step
    fn learns_again(&mut self, workspace: &mut Workspace) -> bool {
        if workspace.progress.lessons == 0 {
            return false;
        }
        if let Some(change) = workspace.progress.change.take() {
            self.filter.apply(&workspace.desk, change);
        }
        workspace.progress.lessons -= 1;
        if workspace.progress.lessons > 0
            && let Some(track) = workspace.progress.next
        {
            self.given(track).next_lesson(workspace);
        }
        workspace.progress.lessons > 0
    }
}

/// The smallest that holds both.
#[inline(never)] // one copy in flash
fn union(a: Rect, b: Rect) -> Rect {
    let (left, top) = (a.x.min(b.x), a.y.min(b.y));
    let side = |from: i32, to: i32| u16::try_from(to.saturating_sub(from)).unwrap_or(u16::MAX);
    Rect::new(left, top, side(left, a.right().max(b.right())), side(top, a.bottom().max(b.bottom())))
}
