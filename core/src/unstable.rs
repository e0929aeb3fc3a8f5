//! **Unstable**: access to the inside of the trackers, for `host-sim` and the tests. May change in any version.

use crate::image::{FineRect, Frame};
use crate::track::paper::{self, Paper};
use crate::track::robust::{Robust, Size, Workspace};
use crate::track::{UpdateError, robust};

/// The weights of the refiner (a small network that corrects the box) as bytes, layer by layer.
#[cfg(feature = "refiner")]
pub const REFINER_WEIGHTS: &[u8] = robust::REFINER_WEIGHTS;
pub use crate::kernels::{CutTable, Scorer, check};
pub use crate::track::paper::search::{Peak, Peaks, Window};

/// The box that the correlation filter follows, before the refiner corrects it; `None` before the first lock.
#[must_use]
pub fn followed<S: Size>(target: &Robust<S>) -> Option<FineRect> {
    target.followed()
}

/// The correlation filter's weights, in units of 2^-30: `CHANNELS` for each cell. Empty before the first lock.
#[must_use]
pub fn weights<S: Size>(target: &Robust<S>) -> &[i32] {
    target.weights()
}

/// The radius of the next update's search window, in cells: `Config::reach`, or less around a calm target. `None` before
/// the first lock.
#[must_use]
pub fn reach<S: Size>(target: &Robust<S>) -> Option<u16> {
    target.reach()
}

/// The features that the next update would compute from `frame`, row by row: [`CHANNELS`](crate::robust::CHANNELS)
/// bytes for each cell of the search window, which exceeds the filter by [`reach`] cells on each side.
///
/// # Errors
/// As [`Target::update`](crate::Target::update). Cancels an update under way in this workspace.
pub fn features<'a, S: Size>(
    target: &Robust<S>,
    workspace: &'a mut Workspace<S>,
    frame: &Frame<'_>,
) -> Result<&'a [i8], UpdateError> {
    target.features(workspace, frame)
}

/// The correlation filter's responses to the [`features`], in units of 1/16384, without the distance penalty: entry
/// `[reach + y][reach + x]` for an offset of (x, y) cells. Entries with an index above 2 * [`reach`] are 0.
///
/// # Errors
/// As [`features`].
pub fn response_map<S: Size>(
    target: &Robust<S>,
    workspace: &mut Workspace<S>,
    frame: &Frame<'_>,
) -> Result<[[i32; robust::SPAN]; robust::SPAN], UpdateError> {
    target.response_map(workspace, frame)
}

/// The correlation filter's response on which the last answer is based, in units of 1/16384, with the distance penalty:
/// about 16,384 if the target looks as before, 0 after a lock.
#[must_use]
pub const fn response<S: Size>(workspace: &Workspace<S>) -> i32 {
    workspace.response()
}

/// The box positions that the next update of the paper tracker searches; `None` before the first lock.
#[must_use]
pub fn offsets<const PIXELS: usize, const SPAN: usize>(target: &Paper<PIXELS, SPAN>) -> Option<Window> {
    target.offsets()
}

/// The score of the box at (`x`, `y`) with the present template and alpha; `None` before the first lock, or if `frame`
/// lacks pixels of the box that lie inside its bounds.
#[must_use]
pub fn score_of<const PIXELS: usize, const SPAN: usize>(
    target: &Paper<PIXELS, SPAN>,
    frame: &Frame<'_>,
    (x, y): (i32, i32),
) -> Option<u32> {
    target.score_at(frame, x, y)
}

/// The peak and the runner-up of the last search, even if the gate refused the peak; `None` before the first search,
/// and while one is unfinished.
#[must_use]
pub fn peaks<const PIXELS: usize, const SPAN: usize>(workspace: &paper::Workspace<PIXELS, SPAN>) -> Option<Peaks> {
    workspace.peaks()
}
