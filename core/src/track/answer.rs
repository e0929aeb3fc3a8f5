//! What a tracker says of its target after a frame.

use crate::image::{FineRect, Rect};

/// What the tracker holds of its target after a frame.
///
/// | | [`Paper`](crate::Paper) | [`Robust`](crate::Robust) |
/// |---|---|---|
/// | tracking | the target was found inside the picture | the early template agrees, part by part |
/// | leaving | it was found partly outside the picture | never |
/// | uncertain | never | the early template hardly agrees |
/// | lost | the peak did not stand out | it has not agreed for some frames |
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The target is where the box is.
    Tracking,
    /// The target is where the box is, partly outside the picture. The template is kept as it is.
    Leaving,
    /// The target is partly hidden or changes quickly, or something else is followed.
    Uncertain,
    /// The target is not seen. The box of [`Paper`](crate::Paper) is the last one that was believed; that of
    /// [`Robust`](crate::Robust) is what it follows meanwhile. Nothing is learned, and the search goes on.
    Lost,
}

/// The answer of an update. All integers; ratios and the confidence are in units of 1/65535, so 65535 is 1.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// The target's box in whole pixels.
    pub bbox: Rect,
    /// The same in units of 1/256 pixel. That of [`Paper`](crate::Paper) is always whole.
    pub fine: FineRect,
    /// Whether the box is to be believed.
    pub state: State,
    /// How much speaks for the box. [`Paper`](crate::Paper): the ratio, and 0 when lost. [`Robust`](crate::Robust): a running mean
    /// of the early template's agreement, two thirds, and of the filter's response, one third.
    pub confidence: u16,
    /// How similar what was found is to the template. [`Paper`](crate::Paper): the similarity matching ratio, which is the peak's
    /// score over the number of pixels, rounded down. [`Robust`](crate::Robust): the fourth least ratio of the 16 parts of the
    /// early template.
    pub ratio: u16,
    /// The ratio of the runner-up; 0 if the window does not reach beyond the peak's neighbourhood. `None` where nothing depended
    /// on it ([`RunnerUp`](crate::paper::RunnerUp)), and from [`Robust`](crate::Robust).
    pub runner_up_ratio: Option<u16>,
    /// The threshold that this frame was scored with: alpha, rounded up to whole gray levels. A pixel counted if it differed by
    /// less. `None` from [`Robust`](crate::Robust), which has one for each place.
    pub alpha: Option<u16>,
    /// The target's size against that of the box that was locked on, in units of 1/65536. Always 65536 from
    /// [`Paper`](crate::Paper).
    pub scale: u32,
    /// True if the target was lost before this frame and is not any more.
    pub found_again: bool,
}
