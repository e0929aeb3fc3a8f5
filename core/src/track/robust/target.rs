//! The public calls of the robust tracker's target.

use super::config::Config;
use super::constants::SCALE;
#[cfg(feature = "unstable")]
use super::constants::SPAN;
use super::decision::{Memory, Track, memory};
use super::features::Grid;
#[cfg(feature = "unstable")]
use super::run::pipeline;
use super::run::{Buffers, Inputs, LockPipeline, Pipeline, expected_pixels, lock_pixels, swept_pixels};
use crate::image::{FineRect, Frame, Rect};
use crate::track::saved::Refusal;
use crate::track::target::{Slot, lockable};
#[cfg(feature = "unstable")]
use crate::track::update::SEAL;
use crate::track::update::{Seal, Steps, Ticket, UnderWay};
use crate::track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, Tracker, UpdateError,
};

/// A target of the robust tracker. It may change in size, light and view.
///
/// ```
/// use smr_core::{Frame, Image, Rect, Robust, State, Tracker, robust::Config};
///
/// // A textured target of 40x40 pixels on a plain background.
/// fn picture(left: usize, top: usize) -> Vec<u8> {
///     let mut pixels = vec![90; 160 * 120];
///     for (y, x) in (0..40).flat_map(|y| (0..40).map(move |x| (y, x))) {
///         pixels[(top + y) * 160 + left + x] = ((x / 5 * 37 + y / 5 * 59) % 200) as u8;
///     }
///     pixels
/// }
///
/// let mut tracker = Tracker::<Robust>::new();
/// let first = picture(20, 30);
/// tracker.lock(&Frame::whole(Image::new(&first, 160, 120)?), Rect::new(20, 30, 40, 40))?;
/// let second = picture(26, 33);
/// let answer = tracker.update(&Frame::whole(Image::new(&second, 160, 120)?))?;
/// assert_eq!((answer.bbox.x, answer.bbox.y), (26, 33));
/// assert_eq!(answer.state, State::Tracking);
/// # Ok::<(), smr_core::Error>(())
/// ```
pub struct Robust {
    config: Slot<Config>,
    ticket: Ticket,
    memory: Memory,
}

impl Robust {
    const DEFAULT: Config = Config::robust();

    /// A target that is not locked, with [`Config::robust`]. All its bytes are 0, so that a `static` takes no flash. For
    /// another configuration see [`Target::with`] and [`Target::configure`].
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { config: Slot::Empty, ticket: const { Ticket::NONE }, memory: Memory::new() }
    }

    #[cfg_attr(smr_small, inline(never))]
    fn configured(config: &Slot<Config>) -> &Config {
        config.or(&Self::DEFAULT)
    }

    /// Pixels of the early template, row by row, in the shape of [`Robust::grid`]. `None` before the first lock.
    #[must_use]
    pub fn early_template(&self) -> Option<impl ExactSizeIterator<Item = u8>> {
        self.memory.track.as_ref().map(|_| self.memory.template.pixels())
    }

    /// The grid to which the target is resampled; `None` before the first lock.
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
        self.memory.track.map(|track| track.box_at(track.motion.place))
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn reach(&self) -> Option<u16> {
        self.memory.track.map(|track| track.reach(Self::configured(&self.config)))
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn features<'a>(
        &self,
        workspace: &'a mut Workspace,
        frame: &Frame<'_>,
    ) -> Result<&'a [i8], UpdateError> {
        self.check(frame, SEAL)?; // nothing below can fail
        let inputs = self.inputs().ok_or(UpdateError::NotLocked)?;
        workspace.under_way.end();
        if !pipeline::features(&inputs, &mut workspace.buffers, frame) {
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
        let inputs = self.inputs().ok_or(UpdateError::NotLocked)?;
        Ok(pipeline::responses(&inputs, &mut workspace.buffers, &mut workspace.under_way.budget))
    }

    fn inputs(&self) -> Option<Inputs<'_>> {
        let track = self.memory.track.as_ref()?;
        Some(Inputs { config: Self::configured(&self.config), memory: &self.memory, track })
    }
}

impl Default for Robust {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Debug for Robust {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Robust")
            .field("config", Self::configured(&self.config))
            .field("track", &self.memory.track)
            .finish_non_exhaustive()
    }
}

impl Target for Robust {
    type Config = Config;

    const SAVED_SIZE: usize = memory::SAVED_SIZE;

    /// Upper bounds of the work, the same for every box: see [`Config::most_work`].
    fn most_work(config: &Config, _: u16, _: u16) -> MostWork {
        config.most_work()
    }

    #[inline(always)]
    fn unlocked() -> Self {
        Self::new()
    }

    fn check_config(config: &Config) -> Result<(), ConfigError> {
        config.check()
    }

    #[inline(always)]
    fn set_config(&mut self, config: Config) {
        (self.config, self.memory.track) = (Slot::Full(config), None);
        self.ticket.end();
    }

    fn config(&self) -> &Config {
        Self::configured(&self.config)
    }

    /// The pixels that a lock reads: the search window around the box, and the refiner's crop (1.75 times the box).
    fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect {
        if bounds.contains(bbox) { lock_pixels(bounds, bbox, Self::configured(&self.config)) } else { Rect::default() }
    }

    fn window(&self) -> Option<Rect> {
        let track = self.memory.track.as_ref()?;
        Some(expected_pixels(track, Self::configured(&self.config)))
    }

    fn sweep_window(&self) -> Option<Rect> {
        let track = self.memory.track.as_ref()?;
        swept_pixels(track, Self::configured(&self.config))
    }

    fn bbox(&self) -> Option<FineRect> {
        self.memory.track.map(|track| track.bbox())
    }

    fn state(&self) -> Option<State> {
        self.memory.track.map(|track| track.state(Self::configured(&self.config)))
    }

    fn quality(&self) -> Option<Quality> {
        self.memory.track.map(|track| track.quality)
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.ticket.end();
        if let Some(track) = &mut self.memory.track {
            track.motion.shift(right, down, track.bounds);
        }
    }

    fn saved_size(&self) -> Result<usize, SaveError> {
        self.memory.saved_size(Self::configured(&self.config))
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        self.memory.save(Self::configured(&self.config), bytes)
    }

    #[inline(always)] // a program that does not name settings does not link their names
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        self.memory.restore(Self::configured(&self.config), bytes).map_err(Refusal::named::<Config>)?;
        self.ticket.end();
        Ok(())
    }

    fn check_saved(&self, bytes: &[u8]) -> Result<(), RestoreError> {
        memory::reader(Self::configured(&self.config), bytes).map(drop).map_err(Refusal::named::<Config>)
    }
}

impl Steps for Robust {
    type Workspace = Workspace;

    fn under_way(workspace: &mut Workspace, _: Seal) -> &mut UnderWay {
        &mut workspace.under_way
    }

    fn work(workspace: &Workspace) -> u32 {
        workspace.under_way.budget.done()
    }

    fn ticket(&mut self, _: Seal) -> &mut Ticket {
        &mut self.ticket
    }

    fn check(&self, frame: &Frame<'_>, _: Seal) -> Result<(), UpdateError> {
        let track = self.memory.track.as_ref().ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let covered = frame.covers(expected_pixels(track, Self::configured(&self.config)))
            && swept_pixels(track, Self::configured(&self.config)).is_none_or(|rect| frame.covers(rect));
        if covered { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
    }

    fn check_lock(&self, frame: &Frame<'_>, bbox: Rect, _: Seal) -> Result<(), LockError> {
        let bounds = frame.bounds();
        lockable(bounds, bbox)?;
        if frame.covers(self.lock_window(bounds, bbox)) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
    }

    fn start(&mut self, workspace: &mut Workspace, _: Seal) {
        let Workspace { progress, buffers, under_way } = workspace;
        if let Some(inputs) = self.inputs() {
            *progress = Progress::Update(Pipeline::begin(&inputs, buffers, &mut under_way.budget));
        }
    }

    #[inline(never)] // keeps its stack out of `step`
    fn start_lock(&mut self, workspace: &mut Workspace, bounds: Rect, bbox: Rect, _: Seal) {
        let Workspace { progress, buffers, .. } = workspace;
        let track = Track::new(bounds, bbox);
        *progress =
            Progress::Lock(LockPipeline::begin(track, Self::configured(&self.config), &mut self.memory, buffers));
    }

    fn step(&mut self, workspace: &mut Workspace, frame: &Frame<'_>, _: Seal) -> bool {
        let Workspace { progress, buffers, under_way } = workspace;
        match (self.inputs(), progress) {
            (Some(inputs), Progress::Update(update)) => update.step(&inputs, buffers, &mut under_way.budget, frame),
            _ => true,
        }
    }

    #[inline(never)] // keeps its stack out of `step`
    fn step_lock(&mut self, workspace: &mut Workspace, frame: &Frame<'_>, _: Seal) -> bool {
        let Workspace { progress: Progress::Lock(lock), buffers, under_way } = workspace else { return true };
        lock.step((Self::configured(&self.config), &mut self.memory), buffers, &mut under_way.budget, frame)
    }

    fn commit(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: Seal) -> Answer {
        let before = self.state();
        let mut ratio = 0;
        if let Workspace { progress: Progress::Update(update), buffers, .. } = workspace {
            update.commit(Self::configured(&self.config), &mut self.memory, buffers);
            ratio = update.candidate().agreement;
        }
        let fine = self.bbox().unwrap_or_default();
        let config = Self::configured(&self.config);
        let track = self.memory.track.as_ref();
        let (state, confidence, scale) = track.map_or((State::Lost, 0, SCALE), |track| {
            (track.state(config), track.confidence.value(), track.motion.place.scale)
        });
        Answer {
            bbox: fine.whole(),
            fine,
            state,
            confidence,
            ratio,
            runner_up_ratio: None,
            alpha: None,
            identity: track.filter(|_| config.refines()).map(|track| track.review.identity()),
            scale,
            found_again: before == Some(State::Lost) && state != State::Lost,
        }
    }

    #[inline(never)] // keeps its stack out of `step`
    fn commit_lock(&mut self, workspace: &mut Workspace, _: &Frame<'_>, _: Seal) -> Quality {
        let Workspace { progress: Progress::Lock(lock), buffers, .. } = workspace else { return Quality::NONE };
        lock.commit(Self::configured(&self.config), &mut self.memory, buffers)
    }
}

#[derive(Clone, Copy)]
#[repr(u32)] // `Nothing` is 0, so a `static` workspace is all zeroes and takes no flash
pub(super) enum Progress {
    Nothing,
    Update(Pipeline),
    Lock(LockPipeline),
}

/// Scratch memory of an update or a lock. It serves any number of targets, one call at a time.
///
/// ```
/// // Firmware often has it in a static.
/// static WORKSPACE: smr_core::robust::Workspace = smr_core::robust::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 48 * 1024);
/// ```
#[repr(C)] // see `Buffers`
pub struct Workspace {
    pub(super) progress: Progress,
    pub(super) under_way: UnderWay,
    pub(super) buffers: Buffers,
}

impl Workspace {
    /// A workspace whose bytes are all 0, so that in a `static` it takes no flash.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { progress: Progress::Nothing, under_way: UnderWay::NOTHING, buffers: Buffers::new() }
    }

    /// The filter's penalised response at the answer's peak, in units of 1/16384; 0 until that peak is refined.
    pub(crate) const fn response(&self) -> i32 {
        if let Progress::Update(update) = &self.progress { update.candidate().response } else { 0 }
    }
}

impl core::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Workspace").field("response", &self.response()).finish_non_exhaustive()
    }
}

impl Default for Workspace {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker<Robust> {
    /// A tracker without a target, with [`Config::robust`]. All its bytes are 0, so a `static` takes no flash:
    ///
    /// ```
    /// use smr_core::{Robust, Tracker, robust::Config};
    /// use std::sync::Mutex; // in firmware: the mutex of critical-section or Embassy
    ///
    /// static TRACKER: Mutex<Tracker<Robust>> = Mutex::new(Tracker::<Robust>::new());
    /// let mut config = Config::robust();
    /// config.reach = 6;
    /// TRACKER.lock().unwrap().configure(config)?;
    /// assert!(TRACKER.lock().unwrap().window().is_none());
    /// # Ok::<(), smr_core::Error>(())
    /// ```
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self::of(Robust::new(), Workspace::new())
    }
}
