//! All numbers of the method that are not in [`Config`](super::Config), with their units.
//!
//! What each part of the tracker is worth was measured on 90 recordings: `host-sim/RESULTS.md`, "What each part is worth".

// Units.

/// One pixel of the frame, in units of positions.
pub(super) const PIXEL: i64 = 1 << PIXEL_BITS;
pub(super) const PIXEL_BITS: u32 = 12;
/// A scale of 1.
pub(super) const SCALE: u32 = 1 << 16;
/// A response or label of 1.
pub(super) const ONE: i32 = 1 << 14;

// Shapes.

// A cell has `CELL` x `CELL` pixels of the grid and `CHANNELS` features: nine orientations and gray.
pub use crate::kernels::{CELL, CHANNELS};
/// The most that the filter searches to each side, in cells: see `Config::reach`.
pub const REACH: u16 = 8;
/// Offsets on an axis of the largest search.
pub(crate) const SPAN: usize = 2 * REACH as usize + 1;
/// Pixels of the largest template. The grid's step is chosen so that a target has about as many.
pub(super) const MOST_PIXELS: usize = 1600;
/// Cells of the largest filter.
pub(super) const MOST_CELLS: usize = 200;
/// Weights of the largest filter.
pub(super) const WEIGHTS: usize = MOST_CELLS * CHANNELS;
/// The least and the most cells on a side of the filter.
pub(super) const LEAST_SIDE: u64 = 4;
pub(super) const MOST_SIDE: u16 = 32;
/// The filter covers 1.4 times the target on each side: 1.4 / `CELL` cells for each pixel of the grid, as a fraction.
pub(super) const COVER: [u64; 2] = [7, 20];
/// The smallest step of the grid, in positions: half a pixel. A small target is magnified no further.
pub(super) const LEAST_STEP: u64 = 2048;

// Gradients.

/// Added to the norm of the gradients around a cell, in units of 1/8 gray level: 2 gray levels a pixel, all over a cell. It keeps flat
/// cells from being lifted to full contrast.
pub(super) const NORM_FLOOR: u32 = 2 * 16 * 8;
/// A feature is this times a cell's gradient (in 1/4 gray level) over the norm (in 1/8): 0.4 of the norm becomes 127, so 2 * 127 / 0.4.
pub(super) const NORM_GAIN: u32 = 635;

// Response.

/// How much less a response counts at the search's edge, in units of 1/256. In between the penalty grows with the squared distance.
pub(super) const DISTANCE_PENALTY: u32 = 77;

// Displacement and refinement by the early template.

/// How far the template is displaced to each side, in pixels of the grid.
pub(super) const MARGIN: u16 = 3;
/// The same in whole cells.
pub(super) const MARGIN_CELLS: u16 = MARGIN.div_ceil(CELL);
/// Pixels between the first nine displacements; between the others it is 1.
pub(super) const COARSE_STEP: i16 = 2;
/// Displacements that are scored.
pub(super) const DISPLACEMENTS: u16 = 17;
/// The agreement from which place and size are refined, in units of 1/65535.
pub(super) const REFINED_FROM: u16 = 55_000;
/// The most that a Gauss-Newton step moves, in units of 1/64 pixel of the grid: one pixel.
pub(super) const MOST_MOVE: i64 = 64;
/// The most that it grows, in units of 1/65536: 2 %.
pub(super) const MOST_GROWTH: i32 = 1310;
/// Damping (Levenberg): each diagonal element of the normal equations grows by 2^-6 of itself, so that a lone edge does not slide along
/// itself.
pub(super) const DAMPING: u32 = 6;

// Verification.

/// Parts on a side of the template: 4 x 4.
pub(super) const PARTS: u16 = 4;
/// Which of the parts' ratios is the agreement, counted from the least: three parts may be hidden.
pub(super) const RANK: usize = 4;
/// The bounds of alpha, in gray levels.
pub(super) const LEAST_ALPHA: u32 = 8;
pub(super) const MOST_ALPHA: u32 = 100;
/// The least and the most gain of the template's contrast, in units of 1/256: half and twice.
pub(super) const LEAST_GAIN: i32 = 128;
pub(super) const MOST_GAIN: i32 = 512;
/// Alpha by which a target's quality is measured when it is locked, in gray levels: 0.05 of full scale.
pub(super) const QUALITY_ALPHA: u16 = 13;

// Scale.

/// The factor between two scales that are searched, in units of 1/65536: 1.02.
pub(super) const SCALE_STEP: u64 = 66_847;
/// What a response at another scale counts, in units of 1/256: 0.984.
pub(super) const SCALE_PENALTY: i64 = 252;
/// How far other scales are searched, in cells.
pub(super) const SCALE_REACH: u16 = 1;
/// The least and the most scale.
pub(super) const LEAST_SCALE: u32 = SCALE / 5;
pub(super) const MOST_SCALE: u32 = 5 * SCALE;

// Confidence, in units of 1/65536: 1 for full agreement, and 1/2 for a response of 1/2 or more.

/// The most evidence that there is: 1.5.
pub(super) const MOST_EVIDENCE: i32 = 3 << 15;
/// The least evidence from which a frame is learned.
pub(super) const LEARNED_FROM: i32 = 37_500;
/// A lost target is found again where there is this much evidence,
pub(super) const FOUND_FROM: i32 = 52_000;
/// and this much more than at its last place.
pub(super) const FOUND_LEAD: i32 = 16_000;
/// The confidence is at most this much above the evidence of the present frame, so one frame without evidence makes a target uncertain.
/// With the default thresholds it takes two to lose it.
pub(super) const CONFIDENCE_LEAD: i32 = 29_000;

// Learning.

/// The regularisation: what squared weights count. 0.05 where a feature of 1 is 318, which squared is 101,124.
pub(super) const REGULARISATION: i64 = 5056;
/// The largest error, in units of 1/16384: a larger one counts as this one (about 4).
pub(super) const MOST_ERROR: i32 = 65_535;
/// The largest coded error: 289 of them times a byte stay below 2^31.
pub(super) const MOST_CODED_ERROR: u32 = 16_383;
/// The label's standard deviation as a part of the root of the target's area, squared: 0.1^2.
pub(super) const LABEL_WIDTH: [u32; 2] = [1, 100];
/// The standard deviation of what cells learn on each axis, in units of 1/256 cell for each pixel of the template: half of its side.
pub(super) const LEARNED_WIDTH: u64 = 32;
/// Steps of steepest descent in the first frame.
pub(super) const FIRST_STEPS: u32 = 25;
/// The part of the exact step that each of them takes, in units of 1/256.
pub(super) const FIRST_RATE: u16 = 160;
