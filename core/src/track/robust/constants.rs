//! The constants of the method that are not in [`Config`](super::Config), with their units. A few others stand beside
//! their formula: in `features/motion.rs`, `decision/confidence.rs`, `refiner/crop.rs`, `refiner/correction.rs` and
//! `similarity/contrast.rs`. The units of work stand in the stages that spend them.
//!
//! *R with ...* gives the change of R with another value. R is the fraction of frames in which the box is right, as a
//! mean over 90 recordings that start from the first frame's annotated box; the differences are paired and have a
//! standard error. R is 0.802 with the values here (`host-sim eval --robustness --starts 1 --method robust`).
//! Constants without such a line were not measured one by one; `host-sim/RESULTS.md` of the project shows the effect of
//! each part of the tracker.

// Units.

/// One pixel of the frame, in units of positions: 1/4096 pixel.
pub(super) const PIXEL: i64 = 1 << PIXEL_BITS;
pub(super) const PIXEL_BITS: u32 = 12;
/// A scale of 1: the size at the lock.
pub(super) const SCALE: u32 = 1 << 16;
/// A response or label of 1.
pub(super) const ONE: i32 = 1 << 14;

// Shapes.

// A cell has `CELL` x `CELL` pixels of the grid and `CHANNELS` features: nine orientations and gray.
pub use crate::kernels::{CELL, CHANNELS};
/// The largest `Config::reach`: cells from the middle of the search to each side.
pub const REACH: u16 = 8;
/// Offsets of the largest search on each axis.
pub(crate) const SPAN: usize = 2 * REACH as usize + 1;
/// Pixels of the largest template. The grid's step is chosen so that a target has about this many pixels.
pub(super) const MOST_PIXELS: usize = 1600;
/// Cells of the largest filter.
pub(super) const MOST_CELLS: usize = 200;
/// Weights of the largest filter.
pub(super) const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The least and the most cells on a side of the filter.
pub(super) const LEAST_SIDE: u16 = 4;
pub(super) const MOST_SIDE: u16 = 32;
/// The filter is 1.4 times as wide and as high as the target: 1.4 / `CELL` cells for each pixel of the grid, as a
/// fraction.
pub(super) const COVER: [u32; 2] = [7, 20];
/// The smallest step of the grid, in positions: half a pixel. Smaller targets are not magnified further.
pub(super) const LEAST_STEP: u32 = 2048;

// Gradients.

/// The floor that is added to the norm of the gradients around a cell, in units of 1/8 gray level: 2 gray levels for
/// each pixel of a cell. Without it, noise in flat cells would get full contrast.
/// R with nearly no floor -0.067 +- 0.021; with twice as much -0.038 +- 0.018.
pub(super) const NORM_FLOOR: u32 = 2 * 16 * 8;
/// feature = gain * gradient (in 1/4 gray level) / norm (in 1/8). 0.4 of the norm becomes 127, so gain = 2 * 127 / 0.4.
pub(super) const NORM_GAIN: u32 = 635;

// Response.

/// The penalty of a response at the edge of the search window, in units of 1/256. It grows with the squared distance
/// from the middle.
/// R without -0.043 +- 0.016.
pub(super) const DISTANCE_PENALTY: u32 = 77;

// Alignment and refinement by the early template.

/// The farthest alignment to each side, in pixels of the grid.
pub(super) const MARGIN: u16 = 3;
/// `MARGIN` in whole cells, rounded up.
pub(super) const MARGIN_CELLS: u16 = MARGIN.div_ceil(CELL);
/// Pixels of the grid between the first nine alignments. Between the others it is 1.
pub(super) const COARSE_STEP: i16 = 2;
/// Alignments that are scored.
pub(super) const ALIGNMENTS: u16 = 17;
/// The agreement from which place and size are refined, in units of 1/65535.
/// R without refinement -0.025 +- 0.013.
pub(super) const REFINED_FROM: u16 = 55_000;
/// The largest move by a Gauss-Newton step, in units of 1/64 pixel of the grid: one pixel.
pub(super) const MOST_MOVE: i64 = 64;
/// The largest growth by a step, in units of 1/65536: 2 %.
pub(super) const MOST_GROWTH: i32 = 1310;
/// Damping (Levenberg): each diagonal element of the normal equations grows by 2^-6 of itself. Without it, a target
/// with a single edge could slide along that edge.
pub(super) const DAMPING: u32 = 6;

// Verification.

/// Tiles on a side of the template: 4 x 4.
pub(super) const TILES: u16 = 4;
/// The rank, from the lowest, of the tile's ratio that is the agreement. With 4, three tiles may be hidden.
/// R with the least tile (1) -0.139 +- 0.024; with the eighth (8) -0.048 +- 0.022, and 66 % of the wrong frames are
/// *tracking* instead of 23 %.
pub(super) const RANK: usize = 4;
/// The least and the most alpha, in gray levels. A matching pixel differs by less than alpha, so 2 allows the rounding
/// of both.
/// If the least were 8, a target with little contrast would match any patch as plain: `verification/lighting.rs`.
pub(super) const LEAST_ALPHA: u32 = 2;
pub(super) const MOST_ALPHA: u32 = 100;
/// The gain 1, in units of 1/256: the contrast of the template itself.
pub(super) const ONE_GAIN: u32 = 256;
/// The most expected gain: 16.
pub(super) const MOST_EXPECTED: u32 = 16 * ONE_GAIN;
/// The least contrast that a search window counts with, in units of 1/16 gray level: 1/4.
pub(super) const LEAST_WINDOW: u32 = 4;
/// The light moves by 1/8 of the way to the light of a frame. With 0 it takes that light at once: 0.05 more of the
/// wrong frames are called *tracking*, on half of the recordings.
pub(super) const FOLLOWED: u32 = 3;
/// Alpha for the quality of a target at the lock, in gray levels: 0.05 of full scale.
pub(super) const QUALITY_ALPHA: u16 = 13;

// Scale.

/// The factor between two neighbouring scales, in units of 1/65536: 1.02.
/// R with 1.04 -0.063 +- 0.023.
pub(super) const SCALE_STEP: i64 = 66_847;
/// The factor of a response at another scale than the last, in units of 1/256: 0.984.
/// R without -0.038 +- 0.016.
pub(super) const SCALE_PENALTY: i64 = 252;
/// The reach of the search at each scale, in cells.
pub(super) const SCALE_REACH: u16 = 1;
/// The least and the most scale.
pub(super) const LEAST_SCALE: u32 = SCALE / 5;
pub(super) const MOST_SCALE: u32 = 5 * SCALE;

// Confidence and evidence. Unit: 1/65536. Full agreement is 1; a response of 1/2 or more adds 1/2.

/// The largest evidence: 1.5.
pub(super) const MOST_EVIDENCE: i32 = 3 << 15;
/// The least evidence for which the filter learns from a frame.
pub(super) const LEARNED_FROM: i32 = 37_500;
/// The least evidence with which a lost target is found again.
pub(super) const FOUND_FROM: i32 = 52_000;
/// The least lead over the evidence at its last place, which is needed as well.
pub(super) const FOUND_LEAD: i32 = 16_000;
/// The running mean exceeds the evidence of the present frame by at most this much. So one frame without evidence makes
/// a target uncertain. With the default thresholds, two such frames make it lost.
/// R without +0.002 +- 0.002: it serves the state, not the place.
pub(super) const CONFIDENCE_LEAD: i32 = 29_000;

// Learning.

/// The regularisation lambda: 0.05 * 318^2, because the number 318 stands for a feature of 1.
pub(super) const REGULARISATION: i64 = 5056;
/// The largest error, in units of 1/16384 (about 4). Larger errors are clamped to it.
pub(super) const MOST_ERROR: i32 = 65_535;
/// The largest coded error: 289 of them times a byte stay below 2^31.
pub(super) const MOST_CODED_ERROR: u32 = 16_383;
/// (label's standard deviation / root of the target's area)^2: 0.1^2.
pub(super) const LABEL_WIDTH: [u32; 2] = [1, 100];
/// The standard deviation of the mask of learning on each axis, in units of 1/256 cell per pixel of the template: half
/// of its side.
pub(super) const LEARNED_WIDTH: u32 = 32;
/// Steps of conjugate gradients at the lock. More of them follow the first frame too closely.
/// R with 25 steps of steepest descent, at four times the work, +0.003 +- 0.005; with 9 steps -0.004 +- 0.006.
pub(super) const FIRST_STEPS: u32 = 7;
/// The learning rate of these steps, in units of 1/256.
pub(super) const WHOLE_STEP: u16 = 256;
