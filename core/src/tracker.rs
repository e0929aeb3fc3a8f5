//! States and decisions: lock, update, lost, reacquire.

use crate::config::{Config, ConfigError, Fraction, RunnerUp};
use crate::image::{Frame, Image, Rect};
use crate::search::{Found, Peak, Scene, Search, Wanted, Window};
use crate::similarity::{self, Backend, Scorer, Table};
use crate::template::Template;
use core::cmp::Ordering;
use core::fmt;

/// What the tracker holds of its target after a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The target was found inside the picture. Its patch is the new template if it lies in [`Config::update_zone`].
    Tracking,
    /// The target was found, partly outside the picture; the template is kept.
    Leaving,
    /// The peak did not stand out as the gate demands. The box is the last one that was believed, template and alpha
    /// are kept, and the window grows with every further frame.
    Lost,
}

/// The answer of [`Tracker::update`]. All integers; ratios in units of 1/65535, so 65535 is 1.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// The target's box; when lost, the last one that was believed.
    pub bbox: Rect,
    /// Whether the box is to be believed.
    pub state: State,
    /// The similarity matching ratio: the peak's score over the number of pixels, rounded down.
    pub ratio: u16,
    /// The same of the runner-up; 0 if the window does not reach beyond the peak's neighbourhood, `None` if nothing
    /// depended on it ([`Config::runner_up`]).
    pub runner_up_ratio: Option<u16>,
    /// The threshold that this frame was scored with: alpha, rounded up to whole gray levels. A pixel counted if it
    /// differed by less.
    pub alpha: u16,
    /// The peak itself: where it was and its score, believed or not, and the runner-up's score.
    pub found: Found,
}

/// Follows one target. `PIXELS` is the largest area of a box, `SPAN` the most offsets that the window may have on an
/// axis; both are memory (`2 * PIXELS` bytes, `20 * SPAN` bytes), beside less than 900 bytes.
///
/// Several targets are several trackers on the same frame. The [crate's example](crate) follows a target through whole
/// frames; this one reads out only what is needed of them:
///
/// ```
/// use smr_core::{Config, Frame, Image, Radius, Rect, Tracker};
/// # fn read_out(window: Rect) -> Vec<u8> {
/// #     let pixel = |x: i32, y: i32| ((x * x + 3 * y * y) % 251) as u8;
/// #     (window.y..window.bottom()).flat_map(|y| (window.x..window.right()).map(move |x| pixel(x, y))).collect()
/// # }
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// let mut config = Config::camera();
/// config.window = Radius { x: 8, y: 8 };
/// config.window_limit = config.window;
/// let mut tracker = Tracker::<64, 17>::new(config)?;
///
/// // A box of 8x8 pixels on a sensor of 320x240; nothing but the box is needed to lock on it.
/// let target = Rect::new(100, 50, 8, 8);
/// let pixels = read_out(target);
/// tracker.lock(&Frame::part(Image::new(&pixels, 8, 8)?, 100, 50, 320, 240)?, target)?;
/// assert_eq!((tracker.alpha(), tracker.template().map(|template| template.width())), (13, Some(8)));
///
/// // The next update wants the box and 8 pixels around it.
/// let window = tracker.window().unwrap();
/// assert_eq!(window, Rect::new(92, 42, 24, 24));
/// let pixels = read_out(window);
/// let frame = Frame::part(Image::new(&pixels, 24, 24)?, 92, 42, 320, 240)?;
///
/// // A map of scores, for those who want to see one.
/// let offsets = tracker.offsets().unwrap();
/// let scores = offsets.ys().flat_map(|y| offsets.xs().map(move |x| (x, y)));
/// let best = scores.filter_map(|(x, y)| tracker.score_at(&frame, x, y)).max();
///
/// let answer = tracker.update(&frame)?;
/// assert_eq!(best, Some(answer.found.peak.score));
/// assert_eq!(answer.found.runner_up, None); // nothing depended on it: see `Config::runner_up`
/// # Ok(())
/// # }
/// ```
pub struct Tracker<const PIXELS: usize, const SPAN: usize> {
    config: Config,
    template: Template<PIXELS>,
    search: Search<PIXELS, SPAN>,
    /// An update was begun and is not finished.
    begun: bool,
    track: Option<Track>,
}

/// What is remembered of a target beside its template.
#[derive(Clone, Copy)]
struct Track {
    target: Rect,
    bounds: Rect,
    state: State,
    /// A box partly outside the picture has been the best: returning takes more, until a lost target is found again.
    edge: bool,
    /// Frames since the target was last believed.
    lost_for: u16,
}

impl<const PIXELS: usize, const SPAN: usize> Tracker<PIXELS, SPAN> {
    /// A tracker without a target.
    ///
    /// # Errors
    /// [`ConfigError`], if a number of the configuration cannot be used.
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub fn new(config: Config) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self::with(config))
    }

    /// The same with the numbers of [`Config::camera`], for a `static`: on the way there a build that is not optimised makes
    /// copies of a tracker on the stack. [`Tracker::configure`] then sets other numbers.
    ///
    /// ```
    /// use smr_core::{Config, Tracker};
    /// static EMPTY: Tracker<64, 17> = Tracker::camera();
    /// assert_eq!(EMPTY.config().k, Config::camera().k);
    /// ```
    #[must_use]
    pub const fn camera() -> Self {
        Self::with(Config::camera())
    }

    #[inline(always)] // see `new`
    const fn with(config: Config) -> Self {
        Self { config, template: Template::new(), search: Search::new(), begun: false, track: None }
    }

    /// Takes other numbers, in place. Whatever was followed before is forgotten.
    ///
    /// # Errors
    /// [`ConfigError`], if a number of the configuration cannot be used; the tracker then goes on with what it had.
    ///
    /// ```
    /// use smr_core::{Config, Frame, Image, Rect, Tracker};
    /// # fn main() -> Result<(), Box<dyn core::error::Error>> {
    /// let mut tracker = Tracker::<64, 161>::camera();
    /// tracker.lock(&Frame::whole(Image::new(&[7; 400], 20, 20)?), Rect::new(5, 5, 8, 8))?;
    /// tracker.configure(Config::paper())?;
    /// assert_eq!((tracker.window(), tracker.alpha(), tracker.config().least_threshold), (None, 0, 0));
    /// assert!(tracker.template().is_none());
    /// # Ok(())
    /// # }
    /// ```
    pub fn configure(&mut self, config: Config) -> Result<(), ConfigError> {
        config.check()?;
        self.config = config;
        self.template.forget();
        self.begun = false;
        self.track = None;
        Ok(())
    }

    /// Starts on the target in `target`, at any time; whatever was followed before is forgotten. Only the pixels of
    /// the box are read.
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
        if !Template::<PIXELS>::holds(target) {
            return Err(LockError::BoxTooLarge);
        }
        let (columns, rows) = Window::largest_size(target, self.config.window_limit, bounds, self.config.padding);
        if columns.max(rows) > SPAN {
            return Err(LockError::WindowTooLarge);
        }
        let patch = frame.patch(target).ok_or(LockError::BoxNotInMemory)?;
        self.template.start(patch, &self.config);
        self.begun = false;
        self.track = Some(Track { target, bounds, state: State::Tracking, edge: false, lost_for: 0 });
        Ok(())
    }

    /// Looks for the target in the next frame.
    ///
    /// Of the frame only the pixels in [`Tracker::window`] are read; the rest need not be in memory.
    /// Cost: at most (offsets in the window) x (pixels of the template) comparisons and about an eighth of it more; far
    /// fewer where the target is seen clearly. In the frame in which a tracked target begins to leave the picture, at most
    /// twice that. [`Tracker::begin`] does the same in parts.
    ///
    /// # Errors
    /// [`UpdateError`]; the tracker is then as it was before.
    pub fn update(&mut self, frame: &Frame<'_>) -> Result<Answer, UpdateError> {
        Ok(self.begin(frame)?.finish())
    }

    /// The same update in steps of a bounded amount of work, for those who have a deadline; the answer does not depend on
    /// how it is cut.
    ///
    /// ```
    /// # use smr_core::{Config, Frame, Image, Rect, Tracker};
    /// # let pixels: Vec<u8> = (0..64 * 48).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    /// # let frame = Frame::whole(Image::new(&pixels, 64, 48)?);
    /// # let mut tracker = Tracker::<256, 161>::new(Config::camera())?;
    /// # tracker.lock(&frame, Rect::new(20, 10, 16, 16))?;
    /// let mut update = tracker.begin(&frame)?;
    /// while !update.step(10_000) {
    ///     // something else that must not wait
    /// }
    /// let answer = update.finish();
    /// assert_eq!(answer.bbox, Rect::new(20, 10, 16, 16));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`UpdateError`]; the tracker is then as it was before.
    pub fn begin<'a>(&'a mut self, frame: &Frame<'a>) -> Result<Update<'a, PIXELS, SPAN>, UpdateError> {
        let (track, window) = self.prepare(frame)?;
        self.search.begin(&window, self.config.pruning, track.wanted(State::Tracking, &self.config));
        self.begun = true;
        Ok(Update { tracker: self, frame: *frame, window, track, work: 0 })
    }

    /// Takes up an update that was begun and dropped before it was finished: for those who cannot keep it, C for one.
    ///
    /// # Errors
    /// [`UpdateError::NotBegun`] if there is none: it was finished, or the tracker has locked since. The others as for
    /// [`Tracker::begin`]. That `frame` holds the same pixels as before is up to the caller: of two frames the answer would
    /// be neither's.
    pub fn resume<'a>(&'a mut self, frame: &Frame<'a>) -> Result<Update<'a, PIXELS, SPAN>, UpdateError> {
        if !self.begun {
            return Err(UpdateError::NotBegun);
        }
        let (track, window) = self.prepare(frame)?;
        Ok(Update { tracker: self, frame: *frame, window, track, work: 0 })
    }

    #[inline(never)] // one copy in flash
    fn prepare(&self, frame: &Frame<'_>) -> Result<(Track, Window), UpdateError> {
        let track = self.track.ok_or(UpdateError::NotLocked)?;
        if track.bounds != frame.bounds() {
            return Err(UpdateError::FrameSizeChanged);
        }
        let window = self.search_window(&track);
        let pixels = window.pixels(track.target.width, track.target.height, track.bounds);
        if !pixels.is_empty() && !frame.covered().contains(pixels) {
            return Err(UpdateError::WindowNotInMemory);
        }
        Ok((track, window))
    }
}

/// An update under way, from [`Tracker::begin`].
///
/// Dropped before [`Update::finish`] it has changed nothing but the tracker's working memory: [`Tracker::resume`] takes it
/// up, [`Tracker::begin`] and [`Tracker::update`] start anew.
pub struct Update<'a, const PIXELS: usize, const SPAN: usize> {
    tracker: &'a mut Tracker<PIXELS, SPAN>,
    frame: Frame<'a>,
    window: Window,
    track: Track,
    work: u64,
}

impl<const PIXELS: usize, const SPAN: usize> Update<'_, PIXELS, SPAN> {
    /// Goes on until `work` comparisons of bytes have been made, and a few more to come to a stop: at most the template's
    /// pixels or twice the pixels of a row of [`Tracker::window`], whichever is more, and seven for each of `SPAN` offsets.
    /// With 0 it does as much as with 1, so that it comes to an end. True when nothing is left to do but
    /// [`Update::finish`], which goes through the template once more.
    #[inline(never)] // one copy in flash
    pub fn step(&mut self, work: u32) -> bool {
        let Tracker { search, template, config, .. } = &mut *self.tracker;
        let backend = config.backend.unwrap_or_else(Backend::best);
        let scorer = Scorer::new(backend, template.table());
        let Some(template) = template.image() else { return true };
        let scene = Scene { frame: self.frame, template, window: self.window, scorer: &scorer };
        self.work = self.work.saturating_add(search.step(&scene, work).into());
        if !search.is_done() {
            return false;
        }
        match search.found(&self.window) {
            Some(Found { peak, runner_up: None }) if self.track.asks_for_more(&peak, config) => {
                search.begin_runner_up(&scene, config.neighbourhood);
                false
            }
            _ => true,
        }
    }

    /// How many comparisons of bytes have been made since the update was begun or resumed, at most: what could be left out
    /// of a score is counted, too, and so is each word of the working memory that is gone through.
    #[must_use]
    pub const fn work(&self) -> u64 {
        self.work
    }

    /// Does what is left, and gives the answer.
    #[must_use]
    pub fn finish(mut self) -> Answer {
        self.run()
    }

    fn run(&mut self) -> Answer {
        while !self.step(u32::MAX) {}
        self.tracker.begun = false;
        let found = self.tracker.search.found(&self.window).unwrap_or(NOTHING);
        self.tracker.decide(&self.frame, self.track, found)
    }
}

/// What is found where nothing is searched, which does not happen: a window is never empty.
const NOTHING: Found = Found { peak: Peak { x: 0, y: 0, score: 0 }, runner_up: None };

impl<const PIXELS: usize, const SPAN: usize> Tracker<PIXELS, SPAN> {
    /// The pixels of the frame that the next [`Tracker::update`] may read; `None` before the first lock.
    ///
    /// Firmware may deliver just these, as a [`Frame::part`].
    #[must_use]
    pub fn window(&self) -> Option<Rect> {
        let track = self.track.as_ref()?;
        Some(self.search_window(track).pixels(track.target.width, track.target.height, track.bounds))
    }

    /// The offsets that the next [`Tracker::update`] scores; `None` before the first lock.
    #[must_use]
    pub fn offsets(&self) -> Option<Window> {
        self.track.as_ref().map(|track| self.search_window(track))
    }

    /// The score that the next [`Tracker::update`] would give to the box at (`x`, `y`): for maps of scores, and for
    /// checking; always by the plain loop. `None` before the first lock, or if a needed pixel is not in memory.
    ///
    /// Cost: one comparison for each pixel of the template.
    #[must_use]
    pub fn score_at(&self, frame: &Frame<'_>, x: i32, y: i32) -> Option<u32> {
        let scorer = Scorer::new(Backend::Scalar, self.template.table());
        similarity::score_at(frame, self.template.image()?, x, y, &scorer)
    }

    /// The template; `None` before the first lock.
    #[must_use]
    pub fn template(&self) -> Option<Image<'_>> {
        self.template.image()
    }

    /// alpha of the next [`Tracker::update`], rounded up to whole gray levels; 0 before the first lock.
    #[must_use]
    pub fn alpha(&self) -> u16 {
        self.template.threshold()
    }

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// What follows from what was found: state, box, template.
    #[inline(never)] // one copy in flash
    fn decide(&mut self, frame: &Frame<'_>, track: Track, found: Found) -> Answer {
        let (pixels, threshold) = (track.target.area(), self.template.threshold());
        let track = track.after(&found, &self.config);
        if track.state != State::Lost
            && self.config.update_zone.kept_by(track.target, track.bounds)
            && let Some(patch) = frame.patch(track.target)
        {
            self.template.update(patch, &self.config);
        }
        self.track = Some(track);
        Answer {
            bbox: track.target,
            state: track.state,
            ratio: ratio(found.peak.score, pixels),
            runner_up_ratio: found.runner_up.map(|score| ratio(score, pixels)),
            alpha: threshold,
            found,
        }
    }

    fn search_window(&self, track: &Track) -> Window {
        let grown = |radius: u16, limit: u16| {
            radius.saturating_add(self.config.growth.saturating_mul(track.lost_for)).min(limit)
        };
        let (radius, limit) = (self.config.window, self.config.window_limit);
        let radius = crate::Radius { x: grown(radius.x, limit.x), y: grown(radius.y, limit.y) };
        Window::new(track.target, radius, track.bounds, self.config.padding)
    }
}

impl Track {
    /// What is known after a frame in which `found` was found.
    fn after(self, found: &Found, config: &Config) -> Self {
        let (target, state) = self.at(&found.peak);
        let was_lost = self.state == State::Lost;
        let edge = self.edge || (!was_lost && state == State::Leaving);
        if self.believes(found, state, config) {
            Self { target, state, edge: edge && !was_lost, lost_for: 0, ..self }
        } else {
            Self { state: State::Lost, edge, lost_for: self.lost_for.saturating_add(1), ..self }
        }
    }

    /// The box at `peak`, and the state of a target that is there.
    fn at(&self, peak: &Peak) -> (Rect, State) {
        let target = Rect { x: peak.x, y: peak.y, ..self.target };
        (target, if self.bounds.contains(target) { State::Tracking } else { State::Leaving })
    }

    /// The gate: does the peak stand out clearly enough to go on to `state`?
    fn believes(&self, found: &Found, state: State, config: &Config) -> bool {
        let (gate, peak) = (&config.gate, found.peak.score);
        // Where it is not known it is less than the peak, and nothing more is asked.
        let runner_up = found.runner_up.unwrap_or(0);
        let leads = peak.saturating_sub(runner_up) > u32::from(gate.lead) * u32::from(Table::ONE);
        let stands_out = leads || self.ratio(state, config).exceeded_by(peak, runner_up);
        stands_out && ratio(peak, self.target.area()) >= gate.least_ratio
    }

    /// What must be known to decide whether to go on to `state`.
    fn wanted(&self, state: State, config: &Config) -> Wanted {
        let ratio = self.ratio(state, config);
        match ratio.numerator.cmp(&ratio.denominator) {
            _ if config.runner_up == RunnerUp::Always => Wanted::RunnerUp(config.neighbourhood),
            Ordering::Greater => Wanted::RunnerUp(config.neighbourhood),
            Ordering::Equal => Wanted::Equals(config.neighbourhood),
            Ordering::Less => Wanted::Peak,
        }
    }

    /// Whether the decision on `peak` takes more than was looked for from the beginning.
    fn asks_for_more(&self, peak: &Peak, config: &Config) -> bool {
        match (self.wanted(State::Tracking, config), self.wanted(self.at(peak).1, config)) {
            (Wanted::RunnerUp(_), _) | (_, Wanted::Peak) => false,
            (first, then) => first != then,
        }
    }

    /// How many times the runner-up a peak must exceed to go on to `state`.
    const fn ratio(&self, state: State, config: &Config) -> Fraction {
        match (self.state, state) {
            (State::Lost, _) => config.gate.lost,
            (_, State::Leaving) => config.gate.leaving,
            _ if self.edge => config.gate.returning,
            _ => config.gate.tracking,
        }
    }
}

/// `score` / `pixels` in units of 1/65535, rounded down.
fn ratio(score: u32, pixels: u32) -> u16 {
    u16::try_from(score / pixels.max(1)).unwrap_or(Table::ONE)
}

/// Why a tracker does not start on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LockError {
    /// The box has no pixels.
    BoxEmpty,
    /// A part of the box lies outside the frame.
    BoxOutsideFrame,
    /// The box has more than `PIXELS` pixels.
    BoxTooLarge,
    /// A part of the box lies within the frame, but not in the part of it that is in memory.
    BoxNotInMemory,
    /// The window could grow to more than `SPAN` offsets on an axis: make the window's limit smaller or `SPAN` larger.
    WindowTooLarge,
}

impl fmt::Display for LockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BoxEmpty => "the box has no pixels: width and height must be at least 1",
            Self::BoxOutsideFrame => "the box is not wholly inside the frame",
            Self::BoxTooLarge => "the box has more pixels than this tracker's template has room for",
            Self::BoxNotInMemory => "the part of the frame in memory does not cover the box",
            Self::WindowTooLarge => "the window could grow to more offsets on an axis than this tracker has room for",
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
    /// No update was begun, or it was finished, or the tracker has locked since: call [`Tracker::begin`] first.
    NotBegun,
}

impl fmt::Display for UpdateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotLocked => "there is no target yet: lock first",
            Self::FrameSizeChanged => "the frame is not of the size of the one that was locked on",
            Self::WindowNotInMemory => "the part of the frame in memory does not cover the search window",
            Self::NotBegun => "no update was begun",
        })
    }
}

impl core::error::Error for UpdateError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ImageError, Radius};
    use std::{println, vec, vec::Vec};

    type Small = Tracker<256, 41>;

    fn small_config() -> Config {
        let mut config = Config::camera();
        config.window = Radius { x: 10, y: 10 };
        config.window_limit = Radius { x: 20, y: 20 };
        config
    }

    /// A frame of noise that never repeats, with a textured target at (`x`, `y`), wherever that is.
    struct Scene {
        width: u16,
        height: u16,
        pixels: Vec<u8>,
    }

    impl Scene {
        fn noise(width: u16, height: u16, seed: u32) -> Self {
            let mut state = seed | 1;
            let mut pixels = Vec::new();
            for _ in 0..u32::from(width) * u32::from(height) {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                pixels.push((state >> 24) as u8);
            }
            Self { width, height, pixels }
        }

        fn with_target(mut self, x: i32, y: i32) -> Self {
            let target = Self::noise(12, 12, 99);
            for (j, row) in (0..).zip(target.pixels.chunks(12)) {
                for (i, &pixel) in (0..).zip(row) {
                    let (x, y) = (x + i, y + j);
                    if (0..i32::from(self.width)).contains(&x) && (0..i32::from(self.height)).contains(&y) {
                        self.pixels[(y * i32::from(self.width) + x) as usize] = pixel;
                    }
                }
            }
            self
        }

        fn image(&self) -> Image<'_> {
            Image::new(&self.pixels, self.width, self.height).unwrap()
        }

        fn frame(&self) -> Frame<'_> {
            Frame::whole(self.image())
        }
    }

    fn scene(seed: u32, x: i32, y: i32) -> Scene {
        Scene::noise(64, 48, seed).with_target(x, y)
    }

    fn locked_at(x: i32, y: i32) -> Small {
        let mut tracker = Small::new(small_config()).unwrap();
        tracker.lock(&scene(1, x, y).frame(), Rect::new(x, y, 12, 12)).unwrap();
        tracker
    }

    #[test]
    fn memory_is_twice_the_template_five_words_an_offset_and_a_table() {
        fn bounded<const PIXELS: usize, const SPAN: usize>(name: &str) {
            let size = size_of::<Tracker<PIXELS, SPAN>>();
            println!("Tracker<{PIXELS}, {SPAN}>: {size} bytes ({name})");
            assert!(size <= 2 * PIXELS + 20 * SPAN + 880, "{name}: {size} bytes");
        }
        bounded::<1024, 33>("32x32 pixels, +-16");
        bounded::<4096, 33>("64x64 pixels, +-16");
        bounded::<4096, 161>("64x64 pixels, the paper's window");
        bounded::<65536, 680>("256x256 pixels, the whole of 640x480");
    }

    #[test]
    fn a_target_is_followed_exactly() {
        let mut tracker = locked_at(20, 20);
        for (seed, (x, y)) in (2..).zip([(22, 21), (30, 15), (30, 15), (21, 24)]) {
            let answer = tracker.update(&scene(seed, x, y).frame()).unwrap();
            assert_eq!((answer.bbox, answer.state), (Rect::new(x, y, 12, 12), State::Tracking));
            assert_eq!(answer.ratio, 65535);
            assert_eq!(answer.runner_up_ratio, None, "inside the frame nothing depends on it");
            assert_eq!(answer.alpha, 13, "the template never changed, so alpha stays");
        }
    }

    #[test]
    fn the_runner_up_is_there_where_it_is_wanted_or_decides() {
        let mut config = small_config();
        config.runner_up = RunnerUp::Always;
        let mut tracker = Small::new(config).unwrap();
        tracker.lock(&scene(1, 20, 20).frame(), Rect::new(20, 20, 12, 12)).unwrap();
        let answer = tracker.update(&scene(2, 22, 21).frame()).unwrap();
        assert!(answer.runner_up_ratio.is_some_and(|ratio| 0 < ratio && ratio < 20000));

        let mut tracker = locked_at(5, 20);
        let answer = tracker.update(&scene(2, -3, 20).frame()).unwrap();
        assert_eq!(answer.state, State::Leaving);
        assert!(answer.runner_up_ratio.is_some(), "whether it leaves depends on it");
    }

    #[test]
    fn the_answer_does_not_depend_on_how_an_update_is_cut() {
        let places = [(22, 21), (28, 15), (70, 70), (25, 20), (-3, 20), (-5, 21), (2, 22)];
        for work in [1, 777, 50_000] {
            let (mut whole, mut cut, mut dropped) = (locked_at(20, 20), locked_at(20, 20), locked_at(20, 20));
            for (seed, (x, y)) in (2..).zip(places) {
                let scene = scene(seed, x, y);
                let expected = whole.update(&scene.frame()).unwrap();
                let frame = scene.frame();
                let mut update = cut.begin(&frame).unwrap();
                while !update.step(work) {
                    assert!(update.work() > 0);
                }
                assert_eq!(update.finish(), expected);
                let mut done = dropped.begin(&frame).unwrap().step(work);
                while !done {
                    done = dropped.resume(&frame).unwrap().step(work);
                }
                assert_eq!(dropped.resume(&frame).unwrap().finish(), expected);
                assert_eq!(dropped.resume(&frame).err(), Some(UpdateError::NotBegun));
            }
        }
    }

    /// Templates and windows of every proportion, up to the largest that the tracker holds, where nothing can be excluded and
    /// where much can.
    #[test]
    fn a_step_does_no_more_than_it_promises() {
        const SPAN: usize = 300;
        let (a, b) = (Scene::noise(300, 280, 3), Scene::noise(300, 280, 9));
        let constant = Scene { pixels: vec![9; 300 * 280], ..Scene::noise(300, 280, 1) };
        let mut tracker = std::boxed::Box::new(Tracker::<256, SPAN>::new(Config::camera()).unwrap());
        for (width, height, radius, always) in [
            (16, 16, (16, 16), true),
            (16, 16, (149, 149), false),
            (256, 1, (149, 149), true),
            (1, 256, (149, 149), true),
            (1, 1, (149, 149), true),
            (8, 4, (149, 3), true),
            (5, 7, (2, 149), false),
        ] {
            let window = Radius { x: radius.0, y: radius.1 };
            let runner_up = if always { RunnerUp::Always } else { RunnerUp::WhenItDecides };
            tracker.config = Config { window, window_limit: window, runner_up, ..Config::paper() };
            for (first, second) in [(&a, &b), (&a, &a), (&constant, &constant)] {
                tracker.lock(&first.frame(), Rect::new(20, 12, width, height)).unwrap();
                let row = u64::from(tracker.window().unwrap().width);
                let template = u64::from(width) * u64::from(height);
                for asked in [0, 1, 5000] {
                    let most = u64::from(asked).max(1) + template.max(2 * row) + 7 * SPAN as u64;
                    let frame = second.frame();
                    let mut update = tracker.begin(&frame).unwrap();
                    let mut before = 0;
                    loop {
                        let done = update.step(asked);
                        let made = update.work() - before;
                        assert!(made <= most, "{width}x{height} {radius:?} {asked}: {made} of {most}");
                        before = update.work();
                        if done {
                            break;
                        }
                        assert!(made > 0, "it goes on");
                    }
                }
            }
        }
    }

    #[test]
    fn an_update_that_was_given_up_leaves_nothing_behind() {
        let mut tracker = locked_at(20, 20);
        let (here, there) = (scene(2, 22, 21), scene(3, 27, 18));
        tracker.begin(&here.frame()).unwrap().step(5000);
        let answer = tracker.update(&there.frame()).unwrap();
        assert_eq!((answer.bbox, answer.state), (Rect::new(27, 18, 12, 12), State::Tracking));
        tracker.begin(&here.frame()).unwrap().step(5000);
        tracker.lock(&here.frame(), Rect::new(22, 21, 12, 12)).unwrap();
        assert_eq!(tracker.resume(&here.frame()).err(), Some(UpdateError::NotBegun));
    }

    #[test]
    fn a_leaving_target_keeps_its_template() {
        let mut tracker = locked_at(2, 20);
        let before: Vec<u8> = tracker.template().unwrap().rows().flatten().copied().collect();
        let answer = tracker.update(&scene(2, -3, 20).frame()).unwrap();
        assert_eq!((answer.bbox, answer.state), (Rect::new(-3, 20, 12, 12), State::Leaving));
        let after: Vec<u8> = tracker.template().unwrap().rows().flatten().copied().collect();
        assert_eq!(before, after);
        let answer = tracker.update(&scene(3, 3, 20).frame()).unwrap();
        assert_eq!((answer.bbox, answer.state), (Rect::new(3, 20, 12, 12), State::Tracking));
    }

    #[test]
    fn a_lost_target_is_found_again_by_a_growing_window() {
        let mut tracker = locked_at(20, 20);
        tracker.config.gate.tracking = Fraction::new(2, 1);
        for frames in 1..=4u16 {
            let answer = tracker.update(&Scene::noise(64, 48, u32::from(frames) + 40).frame()).unwrap();
            assert_eq!((answer.state, answer.bbox), (State::Lost, Rect::new(20, 20, 12, 12)));
            let reach = 10 + i32::from(frames);
            assert_eq!(tracker.offsets().unwrap().xs(), 20 - reach..=20 + reach);
        }
        let answer = tracker.update(&scene(2, 33, 8).frame()).unwrap();
        assert_eq!((answer.state, answer.bbox), (State::Tracking, Rect::new(33, 8, 12, 12)));
        assert_eq!(tracker.offsets().unwrap().xs(), 23..=43, "the window has shrunk again");
    }

    #[test]
    fn the_window_grows_to_its_limit_and_never_overflows() {
        let mut tracker = locked_at(20, 20);
        let nothing = vec![255; 64 * 48];
        let nothing = Frame::whole(Image::new(&nothing, 64, 48).unwrap());
        if let Some(track) = &mut tracker.track {
            track.lost_for = u16::MAX - 1;
            track.state = State::Lost;
        }
        for _ in 0..3 {
            assert_eq!(tracker.update(&nothing).unwrap().state, State::Lost);
            assert_eq!(tracker.offsets().unwrap().xs(), 0..=40);
        }
    }

    #[test]
    fn the_part_of_the_frame_in_the_window_is_enough() {
        for (x, y) in [(20, 20), (0, 0), (52, 36)] {
            let mut whole = locked_at(x, y);
            let mut part = locked_at(x, y);
            let (mut at_x, mut at_y) = (x, y);
            for seed in 2..8 {
                (at_x, at_y) = ((at_x + 3).min(60), (at_y - 4).max(-7));
                let scene = scene(seed, at_x, at_y);
                let window = part.window().unwrap();
                let cut = scene.image().crop(window).unwrap();
                let frame = Frame::part(cut, window.x as u16, window.y as u16, 64, 48).unwrap();
                assert_eq!(part.update(&frame), whole.update(&scene.frame()));
            }
        }
    }

    #[test]
    fn one_pixel_less_than_the_window_is_refused_and_changes_nothing() {
        let mut tracker = locked_at(20, 20);
        let scene = scene(2, 22, 22);
        let window = tracker.window().unwrap();
        assert_eq!(window, Rect::new(10, 10, 32, 32));
        for less in [
            Rect { width: 31, ..window },
            Rect { height: 31, ..window },
            Rect { x: 11, width: 31, ..window },
            Rect { y: 11, height: 31, ..window },
        ] {
            let cut = scene.image().crop(less).unwrap();
            let frame = Frame::part(cut, less.x as u16, less.y as u16, 64, 48).unwrap();
            assert_eq!(tracker.update(&frame), Err(UpdateError::WindowNotInMemory));
        }
        assert_eq!(tracker.update(&scene.frame()), locked_at(20, 20).update(&scene.frame()));
    }

    #[test]
    fn misuse_is_an_error_and_changes_nothing() {
        let mut tracker = Small::new(small_config()).unwrap();
        let scene = scene(1, 20, 20);
        let frame = scene.frame();
        assert_eq!(tracker.update(&frame), Err(UpdateError::NotLocked));
        assert_eq!((tracker.window(), tracker.alpha()), (None, 0));
        assert!(tracker.offsets().is_none() && tracker.template().is_none());
        assert_eq!(tracker.score_at(&frame, 0, 0), None);

        let mut lock = |x, y, width, height| tracker.lock(&frame, Rect::new(x, y, width, height));
        assert_eq!(lock(5, 5, 0, 7), Err(LockError::BoxEmpty));
        assert_eq!(lock(5, 5, 7, 0), Err(LockError::BoxEmpty));
        assert_eq!(lock(-1, 5, 7, 7), Err(LockError::BoxOutsideFrame));
        assert_eq!(lock(58, 5, 7, 7), Err(LockError::BoxOutsideFrame));
        assert_eq!(lock(i32::MAX, i32::MIN, u16::MAX, u16::MAX), Err(LockError::BoxOutsideFrame));
        assert_eq!(lock(5, 5, 17, 16), Err(LockError::BoxTooLarge));
        assert_eq!(lock(5, 5, 16, 16), Ok(()));

        let other = Scene::noise(48, 64, 1);
        assert_eq!(tracker.update(&other.frame()), Err(UpdateError::FrameSizeChanged));
        assert_eq!(tracker.lock(&other.frame(), Rect::new(1, 1, 60, 3)), Err(LockError::BoxOutsideFrame));
        assert!(tracker.update(&frame).is_ok(), "a refused lock leaves the former target");
        assert_eq!(tracker.lock(&other.frame(), Rect::new(1, 1, 6, 3)), Ok(()));
        assert!(tracker.update(&other.frame()).is_ok(), "locking again may change the frame's size");
    }

    #[test]
    fn locking_reads_only_the_box() {
        let scene = scene(1, 20, 20);
        let target = Rect::new(20, 20, 12, 12);
        let frame = Frame::part(scene.image().crop(target).unwrap(), 20, 20, 64, 48).unwrap();
        let mut tracker = Small::new(small_config()).unwrap();
        assert_eq!(tracker.lock(&frame, target), Ok(()));
        assert_eq!(tracker.lock(&frame, Rect::new(19, 20, 12, 12)), Err(LockError::BoxNotInMemory));
    }

    #[test]
    fn a_configuration_is_checked_when_the_tracker_is_built() {
        let refused = |change: fn(&mut Config)| {
            let mut config = Config::camera();
            change(&mut config);
            Small::new(config).err()
        };
        assert_eq!(refused(|_| ()), None);
        assert_eq!(refused(|config| config.k.denominator = 0), Some(ConfigError::ZeroDenominator));
        assert_eq!(refused(|config| config.gate.lost.denominator = 0), Some(ConfigError::ZeroDenominator));
        assert_eq!(refused(|config| config.k.numerator = 0), Some(ConfigError::NothingCounts));
        assert_eq!(refused(|config| config.first_threshold = 0), Some(ConfigError::NothingCounts));
        assert_eq!(refused(|config| config.window_limit.x = 59), Some(ConfigError::LimitBelowWindow));
    }

    #[test]
    fn a_window_that_could_outgrow_its_memory_is_refused_when_locking() {
        let scene = scene(1, 20, 20);
        let lock = |limit| {
            let config = Config { window_limit: Radius { x: limit, y: 10 }, ..small_config() };
            Small::new(config).unwrap().lock(&scene.frame(), Rect::new(20, 20, 12, 12))
        };
        assert_eq!(lock(20), Ok(()));
        assert_eq!(lock(21), Err(LockError::WindowTooLarge));
    }

    #[test]
    fn the_smallest_and_the_largest_frames_work() {
        let mut config = small_config();
        config.padding = 0;
        let mut tracker = Small::new(config).unwrap();
        let one = Image::new(&[7], 1, 1).unwrap();
        tracker.lock(&one.into(), Rect::new(0, 0, 1, 1)).unwrap();
        let answer = tracker.update(&one.into()).unwrap();
        assert_eq!((answer.bbox, answer.ratio, answer.runner_up_ratio), (Rect::new(0, 0, 1, 1), 65535, None));

        config.padding = u16::MAX;
        config.neighbourhood = u16::MAX;
        config.growth = u16::MAX;
        let pixels: Vec<u8> = (0..65535u32).map(|i| ((i * i) >> 7) as u8).collect();
        for (width, height) in [(65535, 1), (1, 65535)] {
            let line = Image::new(&pixels, width, height).unwrap();
            let end = Rect::new(i32::from(width) - 1, i32::from(height) - 1, 1, 1);
            let mut tracker = Small::new(config).unwrap();
            tracker.lock(&line.into(), end).unwrap();
            assert_eq!(tracker.update(&line.into()).unwrap().bbox, end);
        }
    }

    #[test]
    fn the_largest_template_has_a_ratio_of_one() -> Result<(), ImageError> {
        let pixels = vec![200; 256 * 256];
        let frame = Frame::whole(Image::new(&pixels, 256, 256)?);
        let config = Config { window: Radius { x: 1, y: 1 }, window_limit: Radius { x: 1, y: 1 }, ..Config::camera() };
        let mut tracker = std::boxed::Box::new(Tracker::<65536, 3>::new(config).unwrap());
        tracker.lock(&frame, frame.bounds()).unwrap();
        let answer = tracker.update(&frame).unwrap();
        assert_eq!((answer.ratio, answer.found.peak.score), (65535, 65536 * 65535));
        Ok(())
    }
}
