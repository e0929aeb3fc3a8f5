//! The calls of a target of the robust tracker.

use super::config::Config;
#[cfg(feature = "unstable")]
use super::constants::SPAN;
use super::constants::{MARGIN_CELLS, QUALITY_ALPHA, SCALE, SCALE_REACH};
use super::grid::Grid;
use super::memory::Memory;
use super::motion::Place;
use super::pipeline::Model;
use super::refiner::reachable;
use super::sampling::Lattice;
use super::saved;
use super::scale::other_scales;
use super::track::Track;
use super::workspace::Workspace;
use crate::image::{FineRect, Frame, Rect};
use crate::track::saved::Settings;
use crate::track::target::{lock_goes_on, lockable};
#[cfg(feature = "unstable")]
use crate::track::update::SEAL;
use crate::track::update::{Locking, Owner, Seal, Steps, UnderWay};
use crate::track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, UpdateError,
};

/// A target of the robust tracker: size, light and view may change.
///
/// ```
/// use smr_core::{Frame, Image, Rect, Robust, State, Tracker, robust::Config};
///
/// // A target of 40x40 pixels with some texture, on a plain background.
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
    config: Config,
    memory: Memory,
    locking: Locking,
}

impl Robust {
    /// A tracker state without a target, for a `const` or a `static`. At run time see [`Target::new`].
    ///
    /// # Panics
    /// If the configuration is invalid. In a `const` or a `static` this is a compile error.
    #[must_use]
    #[allow(clippy::panic)] // at compile time
    pub const fn const_new(config: Config) -> Self {
        match config.check() {
            Ok(()) => Self { config, memory: Memory::new(), locking: Locking::NOTHING },
            Err(_) => panic!("a number of the configuration cannot be used"),
        }
    }

    /// The early template, which verifies the target: its pixels, row by row. `None` before the first lock. Its shape
    /// is that of [`Robust::grid`].
    #[must_use]
    pub fn early_template(&self) -> Option<impl ExactSizeIterator<Item = u8>> {
        self.memory.track.as_ref().map(|_| self.memory.template.pixels())
    }

    /// The grid; `None` before the first lock.
    #[must_use]
    pub fn grid(&self) -> Option<Grid> {
        self.memory.track.map(|track| track.grid)
    }

    #[cfg(any(test, feature = "unstable"))]
    pub(crate) fn weights(&self) -> &[i32] {
        self.memory.filter.weights()
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn followed(&self) -> Option<FineRect> {
        self.memory.track.map(|track| track.followed())
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn features<'a>(
        &self,
        workspace: &'a mut Workspace,
        frame: &Frame<'_>,
    ) -> Result<&'a [i8], UpdateError> {
        self.check(frame, SEAL)?;
        let track = self.memory.track.ok_or(UpdateError::NotLocked)?;
        workspace.under_way.end();
        if !self.model(track).features(&mut workspace.buffers, frame) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok(&workspace.buffers.large)
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn response_map(
        &self,
        workspace: &mut Workspace,
        frame: &Frame<'_>,
    ) -> Result<[[i32; SPAN]; SPAN], UpdateError> {
        self.features(workspace, frame)?;
        let track = self.memory.track.ok_or(UpdateError::NotLocked)?;
        Ok(self.model(track).responses(&mut workspace.buffers, &mut workspace.under_way.budget))
    }

    fn model(&self, track: Track) -> Model<'_> {
        Model { config: &self.config, memory: &self.memory, track }
    }

    /// The pixels that an update may read around the expected place: the search window, the view of any place in it,
    /// the windows of other scales, and the refiner's crop.
    fn expected_pixels(&self, track: &Track) -> Rect {
        let centre = track.expected(&self.config);
        let reach = self.config.reach();
        let mut pixels = track.pixels(centre, reach + MARGIN_CELLS);
        if self.config.size {
            for scale in other_scales(centre.scale) {
                pixels = union(pixels, track.pixels(Place { scale, ..centre }, reach + 2 * SCALE_REACH));
            }
        }
        if self.config.refines() {
            pixels = union(pixels, track.refined_pixels(centre, reach));
        }
        pixels
    }

    /// The pixels that redetection may read. Only the update itself decides whether the target is lost, so this is
    /// `Some` whenever it may be.
    fn swept_pixels(&self, track: &Track) -> Option<Rect> {
        let reach = self.config.reach();
        let may_be_lost = self.config.sweeps() && track.confidence.may_be_lost_next(&self.config);
        may_be_lost.then(|| track.pixels(track.swept(reach), reach + MARGIN_CELLS))
    }
}

impl core::fmt::Debug for Robust {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Robust")
            .field("config", &self.config)
            .field("track", &self.memory.track)
            .finish_non_exhaustive()
    }
}

impl Target for Robust {
    type Config = Config;

    const SAVED_SIZE: usize = saved::SAVED_SIZE;

    /// The most work, which is the same for every box: see [`Config::most_work`].
    fn most_work(config: &Config, _: u16, _: u16) -> MostWork {
        config.most_work()
    }

    fn check_config(config: &Config) -> Result<(), ConfigError> {
        config.check()
    }

    #[inline(always)]
    fn of_checked(config: Config) -> Self {
        Self { config, memory: Memory::new(), locking: Locking::NOTHING }
    }

    fn config(&self) -> &Config {
        &self.config
    }

    /// The box and its surroundings, up to the reach of a search window, and the refiner's crop of the box.
    fn lock_window(&self, bounds: Rect, target: Rect) -> Rect {
        if bounds.contains(target) {
            let window = Lattice::search_window(Place::of(target), &Grid::new(target), self.config.reach());
            let window = window.pixels(bounds);
            if self.config.refines() {
                return union(window, reachable(Track::new(bounds, target).followed(), 0, bounds));
            }
            window
        } else {
            Rect::default()
        }
    }

    fn window(&self) -> Option<Rect> {
        self.memory.track.as_ref().map(|track| self.expected_pixels(track))
    }

    fn sweep_window(&self) -> Option<Rect> {
        self.memory.track.as_ref().and_then(|track| self.swept_pixels(track))
    }

    fn bbox(&self) -> Option<FineRect> {
        self.memory.track.map(|track| track.bbox())
    }

    fn state(&self) -> Option<State> {
        self.memory.track.map(|track| track.confidence.state(&self.config))
    }

    fn quality(&self) -> Option<Quality> {
        self.memory.track.map(|track| track.quality)
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.locking = Locking::NOTHING;
        if let Some(track) = &mut self.memory.track {
            track.motion.shift(right, down, track.bounds);
        }
    }

    fn saved_size(&self) -> Result<usize, SaveError> {
        self.memory.saved_size(&self.config)
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        self.memory.save(&self.config, bytes)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        self.memory.restore(&self.config, bytes)
    }

    fn check_saved(&self, bytes: &[u8]) -> Result<(), RestoreError> {
        saved::reader(&self.config, bytes).map(drop)
    }
}

impl Steps for Robust {
    type Workspace = Workspace;

    fn identify(&self, owner: &mut Owner, _: &Seal) {
        let numbers = saved::numbers(&self.config);
        Settings { table: self.config.table, numbers: &numbers }.each(|number| owner.add(number.into()));
        if self.memory.track.is_none() {
            self.locking.identify(owner);
        }
        self.memory.identify(owner);
    }

    fn under_way<'a>(workspace: &'a mut Workspace, _: &Seal) -> &'a mut UnderWay {
        &mut workspace.under_way
    }

    fn work(workspace: &Workspace) -> u32 {
        workspace.under_way.budget.done()
    }

    fn check(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), UpdateError> {
        let track = self.memory.track.as_ref().ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let covered =
            frame.covers(self.expected_pixels(track)) && self.swept_pixels(track).is_none_or(|rect| frame.covers(rect));
        if covered { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
    }

    fn check_lock(&self, frame: &Frame<'_>, target: Rect, _: &Seal) -> Result<(), LockError> {
        let bounds = frame.bounds();
        lockable(bounds, target)?;
        if frame.covers(self.lock_window(bounds, target)) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
    }

    fn check_lock_under_way(&self, frame: &Frame<'_>, _: &Seal) -> Result<(), LockError> {
        let bounds = self.locking.bounds();
        lock_goes_on(frame, bounds, self.lock_window(bounds, self.locking.target()))
    }

    fn start(&mut self, workspace: &mut Workspace, _: &Seal) {
        let Workspace { pipeline, buffers, under_way } = workspace;
        if let Some(track) = self.memory.track {
            self.model(track).begin(pipeline, buffers, &mut under_way.budget);
        }
    }

    #[inline(never)] // a step need not reserve its stack
    fn start_lock(&mut self, workspace: &mut Workspace, bounds: Rect, target: Rect, _: &Seal) {
        let track = Track::new(bounds, target);
        (self.memory.track, self.locking) = (None, Locking::new(bounds, target));
        self.memory.filter.start(track.grid.weights());
        self.model(track).begin_lock(&mut workspace.pipeline, &mut workspace.buffers);
    }

    fn step(&mut self, workspace: &mut Workspace, frame: &Frame<'_>, _: &Seal) -> bool {
        while self.step_pipeline(workspace, frame) {
            if !self.begin_another_step(workspace) {
                return true;
            }
        }
        false
    }

    fn conclude(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: &Seal) -> Answer {
        let before = self.state();
        let Workspace { pipeline, buffers, .. } = workspace;
        let outcome = &mut pipeline.outcome;
        if let Some(mut track) = outcome.track {
            if outcome.template_learns {
                let patch = outcome.patch(buffers, &track.grid);
                patch.into_iter().for_each(|patch| self.memory.template.learn(patch, self.config.early_rate));
            }
            outcome.make_step(&mut self.memory, buffers);
            if track.confidence.state(&self.config) == State::Tracking {
                track.tracked_scale = track.motion.place.scale;
            }
            self.memory.track = Some(track);
        }
        let fine = self.bbox().unwrap_or_default();
        let (state, confidence, scale) = self.memory.track.map_or((State::Lost, 0, SCALE), |track| {
            (track.confidence.state(&self.config), track.confidence.value(), track.motion.place.scale)
        });
        Answer {
            bbox: fine.whole(),
            fine,
            state,
            confidence,
            ratio: outcome.candidate.agreement,
            runner_up_ratio: None,
            alpha: None,
            scale,
            found_again: before == Some(State::Lost) && state != State::Lost,
        }
    }

    #[inline(never)] // a step need not reserve its stack
    fn conclude_lock(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: &Seal) -> Quality {
        let Workspace { pipeline, buffers, .. } = workspace;
        let Some(mut track) = pipeline.outcome.track else { return Quality::NONE };
        buffers.comparison.table_mut().set(self.config.table, QUALITY_ALPHA);
        if let Some(patch) = pipeline.outcome.patch(buffers, &track.grid) {
            track.quality = Quality::of(patch, buffers.comparison.table());
            self.memory.template.start(patch);
        }
        if self.config.refines() {
            self.memory.first.keep(&buffers.small);
        }
        self.memory.track = Some(track);
        track.quality
    }
}

impl Robust {
    /// Continues until the grant is spent. True if an update or a learning step of a lock is done.
    fn step_pipeline(&self, workspace: &mut Workspace, frame: &Frame<'_>) -> bool {
        let Workspace { pipeline, buffers, under_way } = workspace;
        // During a lock the track is in the workspace. `or` would put both on the stack.
        let track = if self.memory.track.is_some() { &self.memory.track } else { &pipeline.outcome.track };
        let Some(track) = *track else { return true };
        self.model(track).step(pipeline, buffers, &mut under_way.budget, frame)
    }

    /// Changes the weights after a learning step of a lock. True if another step has begun.
    #[inline(never)] // a step of an update need not reserve its stack
    fn begin_another_step(&mut self, workspace: &mut Workspace) -> bool {
        let Workspace { pipeline, buffers, under_way } = workspace;
        let outcome = &mut pipeline.outcome;
        if !outcome.is_lock() {
            return false;
        }
        outcome.make_step(&mut self.memory, buffers);
        under_way.change();
        let (another, track) = (outcome.has_another_step(), outcome.track);
        if another && let Some(track) = track {
            self.model(track).begin_step(pipeline, buffers, &mut under_way.budget);
        }
        another
    }
}

/// The smallest rectangle that holds both.
#[inline(never)]
fn union(a: Rect, b: Rect) -> Rect {
    let (left, top) = (a.x.min(b.x), a.y.min(b.y));
    let side = |from: i32, to: i32| u16::try_from(to.saturating_sub(from)).unwrap_or(u16::MAX);
    Rect::new(left, top, side(left, a.right().max(b.right())), side(top, a.bottom().max(b.bottom())))
}
