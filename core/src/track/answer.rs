//! The answer of an update (box, state, confidence), and upper bounds of the work that a tracker's calls do.

use crate::image::{FineRect, Rect};

/// The tracker's judgement of its target after a frame.
///
/// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
/// |---|---|---|
/// | tracking | the target was found inside the picture | the early template agrees, tile by tile |
/// | leaving | it was found partly outside the picture | never |
/// | uncertain | never | the early template hardly agrees |
/// | lost | the peak did not exceed the runner-up enough | it has not agreed for some frames |
///
/// With the refiner, `Robust` is also uncertain while the network does not recognise the target in the box, and
/// uncertain or lost while the network expects large errors.
///
/// A later version may add a state. Treat one that you do not know as uncertain: the box may be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum State {
    /// The target is in the box.
    Tracking = 0,
    /// The target is in the box, and the box is partly outside the picture. The template is not updated.
    Leaving = 1,
    /// The target is partly hidden or changes quickly, or the tracker follows something else.
    Uncertain = 2,
    /// The target is not visible. The box is the last accepted one ([`Paper`](crate::Paper)) or the current best guess
    /// ([`Robust`](crate::Robust)). The search goes on. Nothing is learned, unless the target is lost only because the
    /// refiner's network expects large errors of the box.
    Lost = 3,
}

impl State {
    /// All states, in the order of their codes.
    pub const ALL: [Self; 4] = [Self::Tracking, Self::Leaving, Self::Uncertain, Self::Lost];

    /// The code of this state in saved targets, flight records and the C interface; the same in all versions.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The name of this state: `tracking`, `leaving`, `uncertain` or `lost`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tracking => "tracking",
            Self::Leaving => "leaving",
            Self::Uncertain => "uncertain",
            Self::Lost => "lost",
        }
    }

    /// The state with this [`code`](Self::code); `None` for an unknown code.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Tracking),
            1 => Some(Self::Leaving),
            2 => Some(Self::Uncertain),
            3 => Some(Self::Lost),
            _ => None,
        }
    }
}

/// The answer of an update. Ratios and the confidence are in units of 1/65535, so 65535 is 1.0.
///
/// A later version may add fields. [`Answer::new`] makes an answer without a tracker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Answer {
    /// The target's box in whole pixels.
    pub bbox: Rect,
    /// The box in units of 1/256 pixel. [`Paper`](crate::Paper) always gives whole pixels.
    pub fine: FineRect,
    /// The tracker's judgement of the box.
    pub state: State,
    /// Confidence in the box. [`Paper`](crate::Paper): `ratio`, or 0 when lost. [`Robust`](crate::Robust): a running
    /// mean of 2/3 * `ratio` + 1/3 * min(2 * the filter's response, 1).
    pub confidence: u16,
    /// Similarity of the template to the patch at the peak of the search. [`Paper`](crate::Paper): the similarity
    /// matching ratio, which is the score divided by the number of pixels, rounded down. [`Robust`](crate::Robust): the
    /// fourth lowest of the similarity matching ratios of the 16 tiles of the early (slowly learned) template; 0 if the
    /// patch has too little contrast or too many pixels that are clipped to 0 or 255.
    pub ratio: u16,
    /// The similarity matching ratio of the runner-up, the best offset outside the peak's neighbourhood; 0 if the
    /// neighbourhood covers the window. `None` from `Robust`, and from `Paper` if no decision depended on the
    /// runner-up: see [`runner_up_always`](crate::paper::Config::runner_up_always).
    pub runner_up_ratio: Option<u16>,
    /// The threshold alpha of this frame, rounded up to whole gray levels: pixels that differ by less match. `None`
    /// from [`Robust`](crate::Robust), whose threshold follows the contrast of each patch.
    pub alpha: Option<u16>,
    /// The judgement of the refiner's network that the box shows the target of the lock, a running mean over about four
    /// frames: 65535 is certain, 32768 undecided, 0 certain that it shows something else. Below 38,229 the state is
    /// *uncertain* or *lost*. `None` without the refiner.
    pub identity: Option<u16>,
    /// The target's linear size relative to the locked box, in units of 1/65536. [`Paper`](crate::Paper): always 65536.
    pub scale: u32,
    /// True if the target was lost in the frame before and is found in this one.
    pub found_again: bool,
}

impl Answer {
    /// An answer without a tracker, for tests and simulations: [`bbox`](Self::bbox) is the box in whole pixels, `scale`
    /// 65536, all other numbers are 0 and all options `None`.
    ///
    /// ```
    /// use smr_core::{Answer, Rect, State};
    /// let mut answer = Answer::new(Rect::new(20, 10, 16, 16).into(), State::Tracking);
    /// answer.confidence = 40_000; // of 65535
    /// assert_eq!((answer.bbox.x, answer.scale, answer.alpha), (20, 65_536, None));
    /// ```
    #[must_use]
    pub fn new(fine: FineRect, state: State) -> Self {
        Self {
            bbox: fine.whole(),
            fine,
            state,
            confidence: 0,
            ratio: 0,
            runner_up_ratio: None,
            alpha: None,
            identity: None,
            scale: 1 << 16,
            found_again: false,
        }
    }
}

/// Upper bounds of a tracker's work for any frame, computed by [`Target::most_work`](crate::Target::most_work).
/// [`Tracker::update_step`](crate::Tracker::update_step) explains the unit of work.
///
/// ```
/// use smr_core::{Paper, Robust, Target, paper, robust};
/// // A box of 64x64 pixels in a window of +-16.
/// let mut config = paper::Config::camera();
/// config.window = paper::Radius { x: 16, y: 16 };
/// config.window_limit = config.window;
/// let most = Paper::<4096, 33>::most_work(&config, 64, 64);
/// let every_offset = 33 * 33 * 64 * 64;
/// // If the peak of a tracked target is partly outside the frame, the window is searched twice.
/// assert!(most.update > 2 * every_offset && most.update < every_offset * 9 / 4);
/// // For the robust tracker the size of the box does not matter.
/// assert_eq!(robust::Config::robust().most_work(), <Robust>::most_work(&robust::Config::robust(), 640, 480));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct MostWork {
    /// Upper bound of the work of an update.
    pub update: u64,
    /// Upper bound of the work of a lock.
    pub lock: u64,
    /// Upper bound of the work that a step does beyond its grant (`work`), because a piece of work cannot be divided.
    /// Excludes a lock of `Paper`, which is always one step, and the pass over the template (with `Robust`, also over
    /// the weights) in a call's last step.
    pub beyond_a_step: u32,
}
