//! `Paper`, the target of the paper tracker. The stages of an update: window, search, gate, template, answer.

use super::config::Config;
use super::gate::{ratio, searches};
use super::saved;
use super::search::{Extent, Peak, Peaks, Scene, Search, Window};
use super::template::Template;
use super::track::Track;
use crate::image::{FineRect, Frame, Image, Rect};
#[cfg(any(test, feature = "unstable"))]
use crate::similarity::score_at;
use crate::similarity::{Backend, Contrast, CutTable, Scorer};
use crate::track::saved::Refusal;
use crate::track::settings::Kind;
use crate::track::target::{Slot, lockable};
use crate::track::update::{Seal, Steps, Ticket, UnderWay};
use crate::track::{
    Answer, ConfigError, LockError, MostWork, Quality, RestoreError, SaveError, State, Target, UpdateError,
};
use core::fmt;

/// A target of the paper tracker: boxes of at most `PIXELS` pixels, windows of at most `SPAN` offsets on an axis. It
/// takes `PIXELS` bytes, its [`Workspace`] `PIXELS + 20 * SPAN`, both plus a constant. [`Target`] has an example.
#[repr(C)] // the template comes last: in another order the compiler builds the value on the stack and copies it
pub struct Paper<const PIXELS: usize, const SPAN: usize> {
    pub(super) config: Slot<Config>,
    pub(super) track: Slot<Track>,
    ticket: Ticket,
    template: Template<PIXELS>,
}

impl<const PIXELS: usize, const SPAN: usize> Paper<PIXELS, SPAN> {
    const DEFAULT: Config = {
        #[allow(clippy::cast_possible_truncation)] // at most 80
        Config::camera_within(if SPAN > 160 { 80 } else { (SPAN.saturating_sub(1) / 2) as u16 })
    };

    /// A target that is not locked, with [`Config::camera`] limited to windows that fit `SPAN`. All its bytes are 0, so
    /// a `static` takes no flash. For another configuration see [`Target::with`] and [`Target::configure`].
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { config: Slot::Empty, track: Slot::Empty, ticket: const { Ticket::NONE }, template: Template::new() }
    }

    #[cfg_attr(smr_small, inline(never))]
    fn configured(config: &Slot<Config>) -> &Config {
        config.or(&Self::DEFAULT)
    }

    #[cfg(any(test, feature = "unstable"))]
    pub(crate) fn offsets(&self) -> Option<Window> {
        self.track.get().map(|track| track.search_window(self.config()))
    }

    #[cfg(any(test, feature = "unstable"))]
    pub(crate) fn score_at(&self, frame: &Frame<'_>, x: i32, y: i32) -> Option<u32> {
        let table = CutTable::new(self.config().table, self.template.threshold());
        score_at(frame, self.template.image()?, x, y, &Scorer::new(Backend::Scalar, &table))
    }

    /// The template; `None` before the first lock.
    #[must_use]
    pub fn template(&self) -> Option<Image<'_>> {
        self.template.image()
    }

    /// alpha of the next update, rounded up to whole gray levels, 1 to 256; 0 before the first lock.
    #[must_use]
    pub fn alpha(&self) -> u16 {
        self.template.threshold()
    }

    /// Applies the gate to the result of the search, and sets the new state, box and template.
    fn decide(&mut self, frame: &Frame<'_>, track: Track, peaks: Peaks) -> Answer {
        let (pixels, threshold, before) = (track.target.area(), self.template.threshold(), track.state);
        let (target, state) = track.at(&peaks.peak);
        let passes = track.passes(&peaks, state, self.config());
        // A box that is partly outside the frame has no patch, so its contrast is not checked.
        let patch = if passes && self.config().least_ratio > 0 { frame.patch(target) } else { None };
        let seen = patch.map_or(Contrast::NONE, Contrast::of);
        let track = track.after(&peaks.peak, passes && (patch.is_none() || self.template.is_shown_by(seen)));
        if track.state != State::Lost
            && self.config().update_zone.kept_by(track.target, track.bounds)
            && let Some(patch) = frame.patch(track.target)
        {
            self.template.update(patch, seen, Self::configured(&self.config));
        }
        self.track = Slot::Full(track);
        let peak = ratio(peaks.peak.score, pixels);
        Answer {
            bbox: track.target,
            fine: track.target.into(),
            state: track.state,
            confidence: if track.state == State::Lost { 0 } else { peak },
            ratio: peak,
            runner_up_ratio: peaks.runner_up.map(|score| ratio(score, pixels)),
            alpha: Some(threshold),
            identity: None,
            scale: 1 << 16,
            found_again: before == State::Lost && track.state != State::Lost,
        }
    }
}

impl<const PIXELS: usize, const SPAN: usize> Default for Paper<PIXELS, SPAN> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const PIXELS: usize, const SPAN: usize> fmt::Debug for Paper<PIXELS, SPAN> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Paper").field("track", &self.track).field("alpha", &self.alpha()).finish_non_exhaustive()
    }
}

impl<const PIXELS: usize, const SPAN: usize> Target for Paper<PIXELS, SPAN> {
    type Config = Config;

    const SAVED_SIZE: usize = saved::size(PIXELS);
    const LETTER: u8 = Kind::Paper as u8;
    const UNLOCKED: Self = Self::new();
    const UNUSED: Self::Workspace = Workspace::new();

    #[inline(always)]
    fn unlocked() -> Self {
        Self::new()
    }

    /// Upper bounds of the work (see `MostWork`) with the largest window that the configuration and `SPAN` allow.
    fn most_work(config: &Config, width: u16, height: u16) -> MostWork {
        let axis = |radius: u16| (2 * usize::from(radius) + 1).min(SPAN);
        let window = (axis(config.window_limit.x), axis(config.window_limit.y));
        let extent = Extent { window, template: (width, height), pruning: config.pruning };
        let updates = searches(config).map(|(runner_up, again)| extent.most::<PIXELS, SPAN>(runner_up, again));
        MostWork {
            update: updates.max().unwrap_or(0),
            lock: 3 * u64::from(width) * u64::from(height),
            beyond_a_step: extent.most_beyond_a_step::<SPAN>(),
        }
    }

    fn check_config(config: &Config) -> Result<(), ConfigError> {
        config.check()?;
        if config.window.fits(SPAN) { Ok(()) } else { Err(ConfigError::WindowTooLarge) }
    }

    #[inline(always)]
    fn set_config(&mut self, config: Config) {
        (self.config, self.track) = (Slot::Full(config), Slot::Empty);
        self.ticket.end();
    }

    fn config(&self) -> &Config {
        Self::configured(&self.config)
    }

    fn lock_window(&self, bounds: Rect, bbox: Rect) -> Rect {
        if bounds.contains(bbox) { bbox } else { Rect::default() }
    }

    fn window(&self) -> Option<Rect> {
        self.track.get().map(|track| track.pixels(self.config()))
    }

    fn sweep_window(&self) -> Option<Rect> {
        None
    }

    fn bbox(&self) -> Option<FineRect> {
        self.track.get().map(|track| track.target.into())
    }

    fn state(&self) -> Option<State> {
        self.track.get().map(|track| track.state)
    }

    fn quality(&self) -> Option<Quality> {
        self.track.get().map(|track| track.quality)
    }

    fn moved(&mut self, right: i32, down: i32) {
        self.ticket.end();
        if let Some(track) = self.track.get_mut() {
            track.moved(right, down, Self::configured(&self.config).padding);
        }
    }

    fn saved_size(&self) -> Result<usize, SaveError> {
        saved::saved_size(self.track.get())
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, SaveError> {
        saved::save((self.config(), self.track.get(), &self.template), bytes)
    }

    #[inline(always)] // so that a program that does not name settings does not link their names
    fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let restored = saved::restore(Self::configured(&self.config), &mut self.template, SPAN, bytes);
        self.track = Slot::Full(restored.map_err(Refusal::named::<Config>)?);
        self.ticket.end();
        Ok(())
    }

    fn check_saved(&self, bytes: &[u8]) -> Result<(), RestoreError> {
        saved::reader(self.config(), bytes).map(drop).map_err(Refusal::named::<Config>)
    }
}

impl<const PIXELS: usize, const SPAN: usize> Steps for Paper<PIXELS, SPAN> {
    type Workspace = Workspace<PIXELS, SPAN>;

    fn under_way(workspace: &mut Self::Workspace, _: Seal) -> &mut UnderWay {
        &mut workspace.under_way
    }

    fn work(workspace: &Self::Workspace) -> u32 {
        workspace.under_way.budget.done()
    }

    fn ticket(&mut self, _: Seal) -> &mut Ticket {
        &mut self.ticket
    }

    #[inline(never)]
    fn check(&self, frame: &Frame<'_>, _: Seal) -> Result<(), UpdateError> {
        let track = self.track.get().ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        if frame.covers(track.pixels(self.config())) { Ok(()) } else { Err(UpdateError::WindowNotInMemory) }
    }

    fn check_lock(&self, frame: &Frame<'_>, bbox: Rect, _: Seal) -> Result<(), LockError> {
        let bounds = frame.bounds();
        lockable(bounds, bbox)?;
        Track::new(bounds, bbox).check_room(PIXELS, SPAN, self.config())?;
        if frame.covers(bbox) { Ok(()) } else { Err(LockError::LockWindowNotInMemory) }
    }

    fn start(&mut self, workspace: &mut Self::Workspace, _: Seal) {
        let Some(track) = self.track.get() else { return };
        let wanted = track.wanted(State::Tracking, self.config());
        workspace.window = track.search_window(self.config());
        workspace.search.begin(&workspace.window, self.config().pruning, wanted);
        workspace.table.set(self.config().table, self.template.threshold());
    }

    fn start_lock(&mut self, _: &mut Self::Workspace, _: Rect, _: Rect, _: Seal) {
        self.track = Slot::Empty;
    }

    #[inline(never)]
    fn step(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> bool {
        let Self { template, config, track, .. } = self;
        let config = Self::configured(config);
        let (Some(track), Some(image)) = (track.get(), template.image()) else { return true };
        let Workspace { search, table, under_way, window, .. } = workspace;
        let scorer = Scorer::new(config.backend.unwrap_or_else(Backend::best), table);
        let window = *window;
        let scene = Scene { frame: *frame, template: image, window, scorer: &scorer };
        under_way.budget.spend(search.step(&scene, under_way.budget.granted()));
        if !search.is_done() {
            return false;
        }
        match search.peaks(&window) {
            Some(Peaks { peak, runner_up: None }) if track.needs_second_search(&peak, config) => {
                search.begin_runner_up(&scene, config.neighbourhood);
                false
            }
            _ => true,
        }
    }

    /// A lock is one step: `commit_lock`.
    fn step_lock(&mut self, _: &mut Self::Workspace, _: &Frame<'_>, _: Seal) -> bool {
        true
    }

    fn commit(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> Answer {
        let track = self.track.get().copied().unwrap_or(Track::new(frame.bounds(), Rect::default()));
        self.decide(frame, track, workspace.peaks().unwrap_or(NOTHING))
    }

    #[inline(never)] // keeps its stack out of that of a step
    fn commit_lock(&mut self, workspace: &mut Self::Workspace, frame: &Frame<'_>, _: Seal) -> Quality {
        let Workspace { table, under_way, .. } = workspace;
        let (bounds, target) = under_way.locking();
        if let Some(patch) = frame.patch(target) {
            self.template.start(patch, Self::configured(&self.config));
        }
        under_way.budget.spend(3 * target.area());
        table.set(self.config().table, self.template.threshold());
        let quality = self.template.image().map_or(Quality::NONE, |image| Quality::of(image, table));
        self.track = Slot::Full(Track { quality, ..Track::new(bounds, target) });
        quality
    }
}

/// Stands in for the result of a search that scored no offset. That never happens: a window is never empty.
const NOTHING: Peaks = Peaks { peak: Peak { x: 0, y: 0, score: 0 }, runner_up: None };

/// Scratch memory for updates of any number of targets, one at a time: `PIXELS + 20 * SPAN` bytes, a constant, and a
/// similarity table (half a kilobyte, or one kilobyte where `Backend::Swar` is the fastest).
///
/// ```
/// // Firmware often keeps it in a static.
/// static WORKSPACE: smr_core::paper::Workspace<4096, 33> = smr_core::paper::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 4096 + 20 * 33 + 900);
/// ```
// The vectors in `search` come last: else the compiler builds the value on the stack and copies it.
#[repr(C)]
pub struct Workspace<const PIXELS: usize, const SPAN: usize> {
    pub(super) under_way: UnderWay,
    pub(super) window: Window,
    pub(super) table: CutTable,
    pub(super) search: Search<PIXELS, SPAN>,
}

impl<const PIXELS: usize, const SPAN: usize> Workspace<PIXELS, SPAN> {
    /// An empty workspace. All its bytes are 0, so a `static` takes no flash.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self {
            search: Search::new(),
            table: const { CutTable::EMPTY },
            under_way: const { UnderWay::NOTHING },
            window: const { Window::NONE },
        }
    }

    /// The peak and the runner-up of the last search, even if the gate refused the peak; `None` during a search.
    pub(crate) fn peaks(&self) -> Option<Peaks> {
        self.search.peaks(&self.window)
    }
}

impl<const PIXELS: usize, const SPAN: usize> fmt::Debug for Workspace<PIXELS, SPAN> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").field("peaks", &self.peaks()).finish_non_exhaustive()
    }
}

impl<const PIXELS: usize, const SPAN: usize> Default for Workspace<PIXELS, SPAN> {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}
