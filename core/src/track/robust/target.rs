//! The robust tracker's target: what is remembered, locked on, shown, and changed at the end of an update.

use super::config::Config;
use super::early::Early;
use super::exact::{Nearest, RIM};
use super::filter::{Filter, Sample, layout};
use super::grid::Grid;
use super::responses::SPAN;
use super::saved;
use super::track::{Place, Track};
use super::update::{SIZE_REACH, other_scales};
use super::workspace::Workspace;
use crate::image::{FineRect, Frame, Rect};
use crate::similarity::{Backend, Products};
use crate::track::update::Steps;
use crate::track::{Answer, ConfigError, LockError, RestoreError, SaveError, State, Target, UpdateError};

/// Steps of learning from the first frame.
const FIRST_STEPS: u32 = 25;
/// How far each of them goes of the best length, in units of 1/256.
const FIRST_RATE: u16 = 160;

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
    /// The number of the update that was begun last, in its workspace.
    pub(super) update: u32,
}

impl Robust {
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
        self.check(frame)?;
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        workspace.progress.begun = None;
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

    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    fn new(config: Config) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config, track: None, filter: Filter::new(), early: Early::new(), update: 0 })
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

    fn lock(&mut self, workspace: &mut Workspace, frame: &Frame<'_>, target: Rect) -> Result<(), LockError> {
        let bounds = frame.bounds();
        crate::track::target::lockable(bounds, target)?;
        if !frame.covers(self.lock_window(bounds, target)) {
            return Err(LockError::LockWindowNotInMemory);
        }
        let age = self.track.map_or(0, |track| track.age.wrapping_add(1));
        let track = Track::new(bounds, target, age);
        let grid = &track.grid;
        workspace.progress.begun = None;
        workspace.progress.nearest = Nearest::new();
        track.place.view(grid).sample(frame, workspace.strip.scratch(), &mut workspace.view);
        workspace.patch(grid).into_iter().for_each(|patch| self.early.start(patch));
        self.filter.start(grid);
        let (reach, layout) = (self.config.reach(), layout(grid, self.config.span()));
        workspace.see(frame, &track.place.window(grid, reach));
        let (products, rate) = (self.products(), FIRST_RATE);
        for _ in 0..FIRST_STEPS {
            workspace.respond(&self.filter, layout, products);
            let Workspace { strip, desk, cells, responses, .. } = workspace;
            let sample = Sample { cells, responses, target: (0, 0), reach };
            self.filter.learn(grid, &sample, desk, (products, rate), strip.room());
        }
        self.track = Some(track);
        Ok(())
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

    fn moved(&mut self, right: i32, down: i32) {
        if let Some(track) = &mut self.track {
            track.moved(right, down);
        }
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

    #[inline(always)] // made where it stays
    fn workspace() -> Workspace {
        Workspace::new()
    }

    fn check(&self, frame: &Frame<'_>) -> Result<(), UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let covered = frame.covers(self.near(&track)) && self.elsewhere(&track).is_none_or(|rect| frame.covers(rect));
        if covered { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
    }

    fn start(&mut self, workspace: &mut Workspace) {
        workspace.updates = workspace.updates.wrapping_add(1);
        self.update = workspace.updates;
        if let Some(target) = self.given() {
            target.begin(workspace, self.update);
        }
    }

    fn is_under_way(&self, workspace: &Workspace) -> bool {
        workspace.progress.begun.is_some() && workspace.progress.begun == self.track.map(|track| (track, self.update))
    }

    fn advance(&self, workspace: &mut Workspace, frame: &Frame<'_>, work: u32) -> bool {
        self.given().is_none_or(|target| target.step(workspace, frame, work))
    }

    fn work(workspace: &Workspace) -> u32 {
        workspace.progress.work
    }

    fn conclude(&mut self, workspace: &mut Workspace, frame: &Frame<'_>) -> Answer {
        while !self.advance(workspace, frame, u32::MAX) {}
        workspace.progress.begun = None;
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
            next.age = next.age.wrapping_add(1);
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
}

/// The smallest that holds both.
#[inline(never)] // one copy in flash
fn union(a: Rect, b: Rect) -> Rect {
    let (left, top) = (a.x.min(b.x), a.y.min(b.y));
    let side = |from: i32, to: i32| u16::try_from(to.saturating_sub(from)).unwrap_or(u16::MAX);
    Rect::new(left, top, side(left, a.right().max(b.right())), side(top, a.bottom().max(b.bottom())))
}
