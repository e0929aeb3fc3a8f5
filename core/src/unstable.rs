//! **Unstable**: gives `host-sim` and the tests access to the inside of the trackers. It is behind the feature
//! `unstable` and may change in any version. Firmware does not need it.

use crate::image::{FineRect, Frame, Image};
use crate::kernels::ALL_FOUR;
use crate::kernels::Blocks;
use crate::similarity::Scorer;
use crate::track::robust::{Config, Robust, Workspace};
use crate::track::{UpdateError, robust};

/// The bytes of the refiner's weights, layer by layer.
#[cfg(feature = "refiner")]
pub const REFINER_WEIGHTS: &[u8] = robust::REFINER_WEIGHTS;
pub use robust::config::Part;

/// Returns `config` without one part of the robust tracker.
///
/// ```
/// use smr_core::robust::Config;
/// use smr_core::unstable::{Part, has, without};
/// assert!(!has(&without(Config::robust(), Part::Velocity), Part::Velocity));
/// ```
#[must_use]
pub const fn without(config: Config, part: Part) -> Config {
    config.without(part)
}

/// True if `config` has a part.
#[must_use]
pub const fn has(config: &Config, part: Part) -> bool {
    config.has(part)
}

/// The box of the place and scale that the filter follows, before the refiner corrects it; `None` before the first
/// lock.
#[must_use]
pub fn followed(target: &Robust) -> Option<FineRect> {
    target.followed()
}

/// The filter's weights in units of 2^-16 / 16384, cell by cell and [`CHANNELS`](crate::robust::CHANNELS) in each; none
/// before the first lock.
#[must_use]
pub fn weights(target: &Robust) -> &[i32] {
    target.weights()
}

/// The features of the search window as the next update will see them in this frame: cell by cell, row by row,
/// [`CHANNELS`](crate::robust::CHANNELS) bytes in each. The window has the filter's cells and `Config::reach` more on
/// each side.
///
/// # Errors
/// Those of [`Target::update`](crate::Target::update). Cancels an update under way in this workspace.
pub fn features<'a>(target: &Robust, workspace: &'a mut Workspace, frame: &Frame<'_>) -> Result<&'a [i8], UpdateError> {
    target.features(workspace, frame)
}

/// The filter's responses to these features, in units of 1/16384, row by row: up to `Config::reach` cells from the
/// middle to each side, without the distance penalty. The rest is 0.
///
/// # Errors
/// As [`features`].
pub fn response_map(
    target: &Robust,
    workspace: &mut Workspace,
    frame: &Frame<'_>,
) -> Result<[[i32; robust::SPAN]; robust::SPAN], UpdateError> {
    target.response_map(workspace, frame)
}

/// The filter's response where the last finished update found the target, in units of 1/16384: about 1 if the target
/// looks as before.
#[must_use]
pub const fn response(workspace: &Workspace) -> i32 {
    workspace.response()
}

/// Computes the lowest and the highest pixel of each 4x4 block, by the backend of `scorer`. The block at index `i`
/// begins in column `i`. The rows have three more pixels than `low` and `high`.
///
/// ```
/// use smr_core::similarity::{Backend, CutTable, Scorer, Table};
/// use smr_core::unstable::spread;
/// let table = CutTable::new(&Table::PAPER, 13);
/// let rows = [[1, 5, 5, 5, 7], [5, 5, 5, 5, 5], [5, 5, 5, 5, 5], [5, 5, 9, 5, 5]];
/// let (mut low, mut high) = ([0; 2], [0; 2]);
/// spread(&Scorer::new(Backend::best(), &table), &rows.each_ref().map(|row| &row[..]), &mut low, &mut high);
/// assert_eq!((low, high), ([1, 5], [9, 9]));
/// ```
#[inline(always)] // benchmarks measure it alone
pub fn spread(scorer: &Scorer<'_>, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    scorer.spread(rows, low, high);
}

/// The offsets among four that may score at least `floor`, by the backend of `scorer`: bit i is clear only if the
/// offset i columns to the right cannot. The patch has three more columns than the template.
///
/// ```
/// use smr_core::Image;
/// use smr_core::similarity::{Backend, CutTable, Scorer, Table};
/// use smr_core::unstable::candidates;
/// let table = CutTable::new(&Table::PAPER, 13);
/// let patch = [0, 0, 90, 90, 90, 90, 0];
/// let (patch, template) = (Image::new(&patch, 7, 1)?, Image::new(&[90; 4], 4, 1)?);
/// // The offset 2 equals the template; others may be let through.
/// assert_eq!(candidates(&Scorer::new(Backend::best(), &table), patch, template, 4 * 65535) & 4, 4);
/// # Ok::<(), smr_core::ImageError>(())
/// ```
#[must_use]
pub fn candidates(scorer: &Scorer<'_>, patch: Image<'_>, template: Image<'_>, floor: u32) -> u8 {
    scorer.candidates(patch, template, floor, ALL_FOUR)
}

/// Computes the ranges of [`spread`] in the form that the backend of `scorer` needs for [`group_bound`]. `low` and
/// `high` begin at multiples of four bytes, and their length is a multiple of four.
pub fn ranges(scorer: &Scorer<'_>, rows: &[&[u8]; 4], low: &mut [u8], high: &mut [u8]) {
    scorer.ranges(rows, low, high);
}

/// An upper bound of the scores of all of 4x4 offsets; `None` if it is less than `floor`. `low` and `high` hold the
/// rows of their [`ranges`], `stride` bytes apart.
#[must_use]
pub fn group_bound(
    scorer: &Scorer<'_>,
    (low, high): (&[u8], &[u8]),
    stride: usize,
    template: Image<'_>,
    floor: u32,
) -> Option<u32> {
    scorer.bound(&Blocks { low, high, start: 0, stride }, template, floor)
}
