//! The public calls of the robust tracker's target.

use super::config::Config;
#[cfg(feature = "unstable")]
use super::constants::SPAN;
use super::constants::{Limits, SCALE};
use super::decision::{Memory, MemoryMut, Track, memory};
use super::features::Grid;
use super::refiner::First;
#[cfg(feature = "unstable")]
use super::run::pipeline;
use super::run::{Buffers, Inputs, LockPipeline, Pipeline, Size, Standard, expected_pixels, lock_pixels, swept_pixels};
use crate::image::{FineRect, Frame, Rect};
use crate::track::saved::Refusal;
use crate::track::target::{Slot, lockable};
#[cfg(feature = "unstable")]
use crate::track::update::SEAL;
use crate::track::update::{Budget, Seal, Steps, Ticket, UnderWay};
use crate::track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, UpdateError,
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
///
/// `Robust<Small>` takes less memory and work: see [`Size`](super::Size).
///
/// ```
/// # use smr_core::{Frame, Image, Rect, State};
/// use smr_core::{Robust, Tracker, robust::{Config, Small}};
///
/// # let picture = |left: usize, top: usize| -> Vec<u8> {
/// #     let pixel = |x: usize, y: usize| match (x.wrapping_sub(left), y.wrapping_sub(top)) {
/// #         (x @ 0..40, y @ 0..40) => ((x / 5 * 37 + y / 5 * 59) % 200) as u8,
/// #         _ => 90,
/// #     };
/// #     (0..160 * 120).map(|at| pixel(at % 160, at / 160)).collect()
/// # };
/// # let (first, second) = (picture(20, 30), picture(26, 33));
/// # let first = Frame::whole(Image::new(&first, 160, 120)?);
/// # let second = Frame::whole(Image::new(&second, 160, 120)?);
/// let mut tracker = Tracker::<Robust<Small>>::new();
/// assert!(size_of_val(&tracker) < 45 * 1024);
/// tracker.lock(&first, Rect::new(20, 30, 40, 40))?;
/// assert_eq!(tracker.update(&second)?.state, State::Tracking);
///
/// // Its `reach` is at most 7. `within` lowers that of another configuration.
/// assert_eq!(tracker.configure(Config::robust()).unwrap_err().to_string(), "reach is 4 to 7, not 8");
/// tracker.configure(Config::robust().within::<Small>())?;
/// # Ok::<(), smr_core::Error>(())
/// ```
pub struct Robust<S: Size = Standard> {
    config: Slot<Config>,
    ticket: Ticket,
    track: Option<Track>,
    first: First,
    learned: S::Learned,
}

impl<S: Size> Robust<S> {
    const DEFAULT: Config = Config::robust().within::<S>();

    /// A target that is not locked, with [`Config::robust`] within the size. All its bytes are 0, so that a `static` takes
    /// no flash. For another configuration see [`Target::with`] and [`Target::configure`].
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self {
            config: Slot::Empty,
            ticket: const { Ticket::NONE },
            track: None,
            first: First::NONE,
            learned: S::UNLEARNED,
        }
    }

    fn configured(&self) -> &Config {
        self.config.or(const { &Self::DEFAULT })
    }

    /// Pixels of the early template, row by row, in the shape of [`Robust::grid`]. `None` before the first lock.
    #[must_use]
    pub fn early_template(&self) -> Option<impl ExactSizeIterator<Item = u8>> {
        let (_, template) = S::learned(&self.learned);
        self.track.as_ref().map(|_| template.pixels())
    }

    /// The grid to which the target is resampled; `None` before the first lock.
    #[must_use]
    pub fn grid(&self) -> Option<Grid> {
        self.track.map(|track| track.grid)
    }

    #[cfg(any(test, feature = "unstable"))]
    pub(crate) fn weights(&self) -> &[i32] {
        S::learned(&self.learned).0.weights()
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn followed(&self) -> Option<FineRect> {
        self.track.map(|track| track.box_at(track.motion.place))
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn reach(&self) -> Option<u16> {
        self.track.map(|track| track.reach(self.configured()))
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn features<'a>(
        &self,
        workspace: &'a mut Workspace<S>,
        frame: &Frame<'_>,
    ) -> Result<&'a [i8], UpdateError> {
        self.check(frame, SEAL)?; // nothing below can fail
        let inputs = inputs(self.configured(), self.memory()).ok_or(UpdateError::NotLocked)?;
        workspace.under_way.end();
        let mut buffers = S::buffers(&mut workspace.scratch);
        if !pipeline::features(&inputs, &mut buffers, frame) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok(buffers.large)
    }

    #[cfg(feature = "unstable")]
    pub(crate) fn response_map(
        &self,
        workspace: &mut Workspace<S>,
        frame: &Frame<'_>,
    ) -> Result<[[i32; SPAN]; SPAN], UpdateError> {
        self.features(workspace, frame)?;
        let inputs = inputs(self.configured(), self.memory()).ok_or(UpdateError::NotLocked)?;
        let mut buffers = S::buffers(&mut workspace.scratch);
        Ok(pipeline::responses(&inputs, &mut buffers, &mut workspace.under_way.budget))
    }

    fn memory(&self) -> Memory<'_> {
        let (filter, template) = S::learned(&self.learned);
        Memory { limits: S::LIMITS, track: self.track.as_ref(), filter, template, first: &self.first }
    }

    fn parts(&mut self) -> (&Config, MemoryMut<'_>) {
        let Self { config, track, first, learned, .. } = self;
        let (filter, template) = S::learned_mut(learned);
        let config = config.or(const { &Self::DEFAULT });
        (config, MemoryMut { limits: S::LIMITS, track, filter, template, first })
    }

    #[cfg_attr(smr_small, inline(never))]
    fn job<'a>(&'a mut self, workspace: &'a mut Workspace<S>) -> Job<'a> {
        let Workspace { progress, under_way: UnderWay { budget, .. }, scratch } = workspace;
        let (config, memory) = self.parts();
        Job { config, memory, progress, budget, buffers: S::buffers(scratch) }
    }
}

impl<S: Size> Default for Robust<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Size> core::fmt::Debug for Robust<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Robust").field("config", self.configured()).field("track", &self.track).finish_non_exhaustive()
    }
}

impl<S: Size> Target for Robust<S> {
    type Config = Config;

    const SAVED_SIZE: usize = memory::most_saved(S::LIMITS);
    const LETTER: u8 = S::LIMITS.kind as u8;
    const UNLOCKED: Self = Self::new();
    const UNUSED: Workspace<S> = Workspace::new();

    #[inline(always)]
    fn unlocked() -> Self {
        // A constant, so that the fields are not built on the stack and moved.
        const { Self::new() }
    }

    /// Upper bounds of the work, the same for every box: see [`Config::most_work_of`].
    fn most_work(config: &Config, _: u16, _: u16) -> MostWork {
        config.most_work_of::<S>()
    }

    fn check_config(config: &Config) -> Result<(), ConfigError> {
        config.check_for(S::REACH)
    }

    #[inline(always)]
    fn set_config(&mut self, config: Config) {
        (self.config, self.track) = (Slot::Full(config.within::<S>()), None);
        self.ticket.end();
    }

    fn config(&self) -> &Config {
        self.configured()
    }

    /// The pixels that a lock reads: the search window around the box, and the refiner's crop (1.75 times the box).
    fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect {
        if bounds.contains(bbox) { lock_pixels(bounds, bbox, self.configured(), S::LIMITS) } else { Rect::default() }
    }

    fn window(&self) -> Option<Rect> {
        Some(expected_pixels(self.track.as_ref()?, self.configured()))
    }

    fn sweep_window(&self) -> Option<Rect> {
        swept_pixels(self.track.as_ref()?, self.configured())
    }

    fn bbox(&self) -> Option<FineRect> {
        self.track.map(|track| track.bbox())
    }

    fn state(&self) -> Option<State> {
        self.track.map(|track| track.state(self.configured()))
    }

    fn quality(&self) -> Option<Quality> {
        self.track.map(|track| track.quality)
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.ticket.end();
        if let Some(track) = &mut self.track {
            track.motion.shift(right, down, track.bounds);
        }
    }

    fn saved_size(&self) -> Result<usize, SaveError> {
        self.memory().saved_size(self.configured())
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        self.memory().save(self.configured(), bytes)
    }

    #[inline(always)] // a program that does not name settings does not link their names
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let (config, mut memory) = self.parts();
        memory.restore(config, bytes).map_err(Refusal::named::<Config>)?;
        self.ticket.end();
        Ok(())
    }

    fn check_saved(&self, bytes: &[u8]) -> Result<(), RestoreError> {
        memory::reader(S::LIMITS, self.configured(), bytes).map(drop).map_err(Refusal::named::<Config>)
    }
}

/// Each call only takes target and workspace apart, so that the code behind it is compiled once for all sizes.
impl<S: Size> Steps for Robust<S> {
    type Workspace = Workspace<S>;

    fn under_way(workspace: &mut Workspace<S>, _: Seal) -> &mut UnderWay {
        &mut workspace.under_way
    }

    fn work(workspace: &Workspace<S>) -> u32 {
        workspace.under_way.budget.done()
    }

    fn ticket(&mut self, _: Seal) -> &mut Ticket {
        &mut self.ticket
    }

    fn check(&self, frame: &Frame<'_>, _: Seal) -> Result<(), UpdateError> {
        check(self.configured(), self.track.as_ref(), frame)
    }

    fn check_lock(&self, frame: &Frame<'_>, bbox: Rect, _: Seal) -> Result<(), LockError> {
        check_lock(self.configured(), S::LIMITS, frame, bbox)
    }

    fn start(&mut self, workspace: &mut Workspace<S>, _: Seal) {
        self.job(workspace).start();
    }

    fn start_lock(&mut self, workspace: &mut Workspace<S>, bounds: Rect, bbox: Rect, _: Seal) {
        self.job(workspace).start_lock(bounds, bbox);
    }

    fn step(&mut self, workspace: &mut Workspace<S>, frame: &Frame<'_>, _: Seal) -> bool {
        self.job(workspace).step(frame)
    }

    fn step_lock(&mut self, workspace: &mut Workspace<S>, frame: &Frame<'_>, _: Seal) -> bool {
        self.job(workspace).step_lock(frame)
    }

    fn commit(&mut self, workspace: &mut Workspace<S>, _: &Frame<'_>, _: Seal) -> Answer {
        self.job(workspace).commit()
    }

    fn commit_lock(&mut self, workspace: &mut Workspace<S>, _: &Frame<'_>, _: Seal) -> Quality {
        self.job(workspace).commit_lock()
    }
}

fn inputs<'a>(config: &'a Config, memory: Memory<'a>) -> Option<Inputs<'a>> {
    Some(Inputs { config, memory, track: memory.track? })
}

#[inline(never)] // one copy for all sizes
fn check(config: &Config, track: Option<&Track>, frame: &Frame<'_>) -> Result<(), UpdateError> {
    let track = track.ok_or(UpdateError::NotLocked)?;
    if track.bounds != frame.bounds() {
        return Err(UpdateError::FrameSizeChanged);
    }
    let covered = frame.covers(expected_pixels(track, config))
        && swept_pixels(track, config).is_none_or(|rect| frame.covers(rect));
    if covered { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
}

#[inline(never)] // one copy for all sizes
fn check_lock(config: &Config, limits: Limits, frame: &Frame<'_>, bbox: Rect) -> Result<(), LockError> {
    let bounds = frame.bounds();
    lockable(bounds, bbox)?;
    let window = lock_pixels(bounds, bbox, config, limits);
    if frame.covers(window) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
}

/// A target and a workspace of any size, for the calls of [`Steps`].
struct Job<'a> {
    config: &'a Config,
    memory: MemoryMut<'a>,
    progress: &'a mut Progress,
    budget: &'a mut Budget,
    buffers: Buffers<'a>,
}

// No call is inlined: there is one copy for all sizes, and the stack of one is not in another.
impl Job<'_> {
    #[inline(never)]
    fn start(&mut self) {
        if let Some(inputs) = inputs(self.config, self.memory.shared()) {
            *self.progress = Progress::Update(Pipeline::begin(&inputs, &mut self.buffers, self.budget));
        }
    }

    #[inline(never)]
    fn start_lock(&mut self, bounds: Rect, bbox: Rect) {
        let track = Track::new(bounds, bbox, self.memory.limits);
        *self.progress = Progress::Lock(LockPipeline::begin(track, self.config, &mut self.memory, &mut self.buffers));
    }

    #[inline(never)]
    fn step(&mut self, frame: &Frame<'_>) -> bool {
        let Self { config, memory, progress, budget, buffers } = self;
        match (inputs(config, memory.shared()), progress) {
            (Some(inputs), Progress::Update(update)) => update.step(&inputs, buffers, budget, frame),
            _ => true,
        }
    }

    #[inline(never)]
    fn step_lock(&mut self, frame: &Frame<'_>) -> bool {
        let Self { config, memory, progress: Progress::Lock(lock), budget, buffers } = self else { return true };
        lock.step((config, memory), buffers, budget, frame)
    }

    #[inline(never)]
    fn commit(&mut self) -> Answer {
        let Self { config, memory, progress, buffers, .. } = self;
        let before = memory.track.as_ref().map(|track| track.state(config));
        let mut ratio = 0;
        if let Progress::Update(update) = progress {
            update.commit(config, memory, buffers);
            ratio = update.candidate().agreement;
        }
        let track = memory.track.as_ref();
        let fine = track.map(Track::bbox).unwrap_or_default();
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

    #[inline(never)]
    fn commit_lock(&mut self) -> Quality {
        let Self { config, memory, progress: Progress::Lock(lock), buffers, .. } = self else { return Quality::NONE };
        lock.commit(config, memory, buffers)
    }
}

#[derive(Clone, Copy)]
#[repr(u32)] // `Nothing` is 0, so a `static` workspace is all zeroes and takes no flash
enum Progress {
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
#[repr(C)] // see `Scratch`
pub struct Workspace<S: Size = Standard> {
    progress: Progress,
    under_way: UnderWay,
    scratch: S::Scratch,
}

impl<S: Size> Workspace<S> {
    /// A workspace whose bytes are all 0, so that in a `static` it takes no flash.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { progress: Progress::Nothing, under_way: UnderWay::NOTHING, scratch: S::UNUSED }
    }

    /// The filter's penalised response at the answer's peak, in units of 1/16384; 0 until that peak is refined.
    pub(crate) const fn response(&self) -> i32 {
        if let Progress::Update(update) = &self.progress { update.candidate().response } else { 0 }
    }
}

impl<S: Size> core::fmt::Debug for Workspace<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Workspace").field("response", &self.response()).finish_non_exhaustive()
    }
}

impl<S: Size> Default for Workspace<S> {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}
