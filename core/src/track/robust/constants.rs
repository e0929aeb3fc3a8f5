//! The constants of the method that are not in [`Config`](super::Config), with their units. A few others stand beside
//! their formulas: in `features/motion.rs`, `decision/confidence.rs`, `similarity/contrast.rs` and `refiner/`
//! (`crop.rs`, `correction.rs`, `opinion.rs`). Each stage's cost in units of work stands in its own file.
//!
//! R, the success rate, is the fraction of frames with an IoU above 0.25, as a mean over 90 recordings, started on the
//! first frame's annotated box. Changes of R with another value have a standard error (paired differences). R is 0.802
//! with the values here (`host-sim eval --robustness --starts 1 --method robust`). Constants without such a line were
//! not measured one by one; `host-sim/RESULTS.md` shows the effect of each part of the tracker.

/// One pixel of the frame in the unit of positions, 1/4096 pixel.
pub(super) const PIXEL: i64 = 1 << PIXEL_BITS;
pub(super) const PIXEL_BITS: u32 = 12;
/// A scale of 1, in units of 1/65536: the target's size at the lock.
pub(super) const SCALE: u32 = 1 << 16;
/// A filter response or label of 1, in units of 1/16384.
pub(super) const ONE: i32 = 1 << 14;

// A cell has `CELL` x `CELL` pixels of the target's grid and `CHANNELS` features: nine gradient orientations and gray.
pub use crate::kernels::{CELL, CHANNELS};
/// The largest `Config::reach`: the radius of the search window, in cells.
pub const REACH: u16 = 8;
/// The count of filter offsets on each axis of the largest search window. Neighbouring offsets are one cell apart.
pub(crate) const SPAN: usize = 2 * REACH as usize + 1;
/// Pixels of the largest template. The target is resampled to a grid on which it has about this many pixels.
pub(super) const MAX_PIXELS: usize = 1600;
/// Cells of the largest correlation filter.
pub(super) const MAX_CELLS: usize = 200;
/// Weights of the largest correlation filter.
pub(super) const WEIGHTS: usize = MAX_CELLS * CHANNELS;
/// The minimum and the maximum side of the correlation filter, in cells.
pub(super) const MIN_SIDE: u16 = 4;
pub(super) const MAX_SIDE: u16 = 32;
/// The filter's side in cells for each grid pixel of the target's side: 7/20. As a cell has 4x4 grid pixels, the
/// filter's side is 1.4 times the target's.
pub(super) const COVER: [u32; 2] = [7, 20];
/// The smallest step of the target's grid, in units of 1/4096 pixel: half a pixel, which enlarges a target twofold.
pub(super) const MIN_STEP: u32 = 2048;

/// The floor that is added to the norm of the gradients around a cell, in units of 1/8 gray level: 2 gray levels for
/// each pixel of a cell. Without it, noise in flat cells would be amplified to full contrast. A floor near 0 lowers the
/// success rate R by 0.067 +- 0.021, a doubled floor by 0.038 +- 0.018.
pub(super) const NORM_FLOOR: u32 = 2 * 16 * 8;
/// The gain in feature = gain * gradient / norm, with gradients in 1/4 and norms in 1/8 gray level. A gradient of 0.4
/// times the norm becomes 127, so gain = 2 * 127 / 0.4, where the 2 converts the units.
pub(super) const NORM_GAIN: u32 = 635;

/// The largest penalty of a filter response, in units of 1/256 of the response. The penalty grows with the squared
/// distance from the centre, up to the radius of the search window. Without penalties the success rate R is lower by
/// 0.043 +- 0.016.
pub(super) const DISTANCE_PENALTY: u32 = 77;

/// The farthest offset from the filter's peak at which the template is compared, in pixels of the grid on each axis.
pub(super) const MARGIN: u16 = 3;
/// `MARGIN` in whole cells, rounded up.
pub(super) const MARGIN_CELLS: u16 = MARGIN.div_ceil(CELL);
/// The spacing of the nine coarse offsets of the template, in pixels of the grid. The eight fine offsets are 1 apart.
pub(super) const COARSE_STEP: i16 = 2;
/// The count of offsets at which the early template is compared with the frame.
pub(super) const ALIGNMENTS: u16 = 17;
/// The least agreement with which the early template refines place and size, in units of 1/65535. Without refinement
/// the success rate R is lower by 0.025 +- 0.013.
pub(super) const REFINED_FROM: u16 = 55_000;
/// The largest move by the Gauss-Newton step of refinement on each axis, in units of 1/64 pixel of the grid: one pixel.
pub(super) const MAX_MOVE: i64 = 64;
/// The largest growth or shrinkage of the target by the Gauss-Newton step of refinement, in units of 1/65536: 2 %.
pub(super) const MAX_GROWTH: i32 = 1310;
/// The exponent of the damping (Levenberg) of refinement: each diagonal element of the normal equations grows by 2^-6
/// of itself. Without damping, a target with a single edge could slide along that edge.
pub(super) const DAMPING: u32 = 6;

/// Tiles of the early template on each axis. Each of the 4 x 4 tiles is compared with the frame.
pub(super) const TILES: u16 = 4;
/// The rank of the tile whose similarity ratio is the agreement; rank 1 is the tile with the lowest ratio. With rank 4,
/// three tiles may be hidden. Rank 1 lowers the success rate R by 0.139 +- 0.024. Rank 8 lowers it by 0.048 +- 0.022,
/// and raises the share of wrong frames that are *tracking* from 23 % to 66 %.
pub(super) const AGREEMENT_RANK: usize = 4;
/// The minimum and the maximum of the threshold alpha, in gray levels. Two pixels match if they differ by less than
/// alpha, so a minimum of 2 tolerates a rounding error of 1. With a minimum of 8, a target with little contrast would
/// match any plain patch (`verification/lighting.rs`).
pub(super) const MIN_ALPHA: u32 = 2;
pub(super) const MAX_ALPHA: u32 = 100;
/// A gain of 1, in units of 1/256: the patch has the contrast of the template.
pub(super) const ONE_GAIN: u32 = 256;
/// The largest expected gain of contrast from the template to the patch: a factor of 16, in units of 1/256.
pub(super) const MAX_EXPECTED: u32 = 16 * ONE_GAIN;
/// The minimum contrast of a search window: 1/4 gray level, in units of 1/16. Lower contrasts are raised to it.
pub(super) const MIN_WINDOW: u32 = 4;
/// The learning rate of the target's `Light`, as a right shift: each learned frame moves the target's `Light` by 2^-3
/// of the difference to the frame's `Light`. With 2^0 (the whole difference), the share of wrong frames that are
/// *tracking* would be higher by 0.05, measured on half of the recordings.
pub(super) const LIGHT_RATE: u32 = 3;
/// The threshold alpha, in gray levels, with which a lock measures how distinct its target is: 0.05 of full scale.
pub(super) const QUALITY_ALPHA: u16 = 13;

/// The ratio of neighbouring scales, in units of 1/65536: 1.02. At 1.04, the success rate R is lower by 0.063 +- 0.023.
pub(super) const SCALE_STEP: i64 = 66_847;
/// The factor of a response at a changed scale in the scale search, in units of 1/256: 0.984. A factor of 1 lowers the
/// success rate R by 0.038 +- 0.016.
pub(super) const SCALE_PENALTY: i64 = 252;
/// The radius of the search window at each scale of the scale search, in cells.
pub(super) const SCALE_REACH: u16 = 1;
/// The minimum and the maximum scale of a target, relative to its size at the lock.
pub(super) const MIN_SCALE: u32 = SCALE / 5;
pub(super) const MAX_SCALE: u32 = 5 * SCALE;

// Evidence and confidence, in units of 1/65536. Evidence sums the agreement (up to 1) and the response (up to 1/2).

/// The largest evidence of a frame for the target: 1.5, in units of 1/65536.
pub(super) const MAX_EVIDENCE: i32 = 3 << 15;
/// The least evidence for the target with which the filter learns from a frame.
pub(super) const LEARNED_FROM: i32 = 37_500;
/// The minimum evidence in a search window for finding a lost target there. `FOUND_LEAD` is required as well.
pub(super) const FOUND_FROM: i32 = 52_000;
/// The minimum lead of the evidence in a search window over the evidence at the place where the target was lost.
pub(super) const FOUND_LEAD: i32 = 16_000;
/// The maximum by which the running mean of the evidence may exceed the frame's evidence. With the default settings,
/// one frame without evidence thus makes a *tracking* target *uncertain*, and a second such frame makes it *lost*. The
/// bound improves the state, not the place: without the bound, the success rate R is higher by 0.002 +- 0.002.
pub(super) const CONFIDENCE_LEAD: i32 = 29_000;

/// The regularisation lambda of the ridge regression: 0.05 * 318^2, because a feature of 1 is the integer 318.
pub(super) const REGULARISATION: i64 = 5056;
/// The largest error of a response, in units of 1/16384: 65535, about 4.0. Larger errors are clamped to it.
pub(super) const MAX_ERROR: i32 = 65_535;
/// The bound of a 16-bit coded error (`coded_errors`). A sum of 289 products with 8-bit features stays below 2^31.
pub(super) const MAX_CODED_ERROR: u32 = 16_383;
/// The squared width of the Gaussian label, as a fraction: (standard deviation / root of the target's area)^2 = 0.1^2.
pub(super) const LABEL_WIDTH: [u32; 2] = [1, 100];
/// The standard deviation of the mask that weights the filter's cells in learning, per pixel of the template's side, in
/// units of 1/256 cell. On each axis, 32 makes the standard deviation half of the side, as a cell is 4 pixels wide.
pub(super) const MASK_WIDTH: u32 = 32;
/// Steps of conjugate gradients at the lock. More steps overfit the first frame: 9 lower the success rate R by 0.004 +-
/// 0.006. 25 steps of steepest descent, at four times the work, raise it by 0.003 +- 0.005.
pub(super) const FIRST_STEPS: u32 = 7;
/// The learning rate at the lock, in units of 1/256. At 256 each step has its full length.
pub(super) const WHOLE_STEP: u16 = 256;
