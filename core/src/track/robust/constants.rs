//! The constants that several stages share, with their units. Others stand beside what they limit.

use crate::track::settings::Kind;

/// One pixel of the frame in the unit of positions, 1/4096 pixel.
pub(super) const PIXEL: i64 = 1 << PIXEL_BITS;
pub(super) const PIXEL_BITS: u32 = 12;
/// A scale of 1, in units of 1/65536: the target's size at the lock.
pub(super) const SCALE: u32 = 1 << 16;
/// A filter response or label of 1, in units of 1/16384.
pub(super) const ONE: i32 = 1 << 14;

// A cell has `CELL` x `CELL` pixels of the target's grid and `CHANNELS` features: nine gradient orientations and gray.
pub use crate::kernels::{CELL, CHANNELS};
/// The largest `Config::reach` of any size of tracker: the radius of the search window, in cells.
pub const REACH: u16 = 8;
/// The count of filter offsets on each axis of the largest search window. Neighbouring offsets are one cell apart.
pub(crate) const SPAN: usize = 2 * REACH as usize + 1;
/// The maximum side of the correlation filter, in cells.
pub(super) const MAX_SIDE: u16 = 32;

/// The farthest offset from the filter's peak at which the template is compared, in pixels of the grid on each axis.
pub(super) const MARGIN: u16 = 3;

/// A gain of 1, in units of 1/256: the patch has the contrast of the template.
pub(super) const ONE_GAIN: u32 = 256;

/// The radius of the search window at each scale of the scale search, in cells.
pub(super) const SCALE_REACH: u16 = 0;

/// The limits of a size of tracker. The stages take them as values, so that one copy of their code serves every size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// The letter of this size in saved targets and records.
    pub(super) kind: Kind,
    /// Pixels of the largest template. The target is resampled to a grid on which it has about this many pixels.
    pub(super) pixels: u16,
    /// Cells of the largest correlation filter.
    pub(super) cells: u16,
    /// The largest `Config::reach`.
    pub(super) reach: u16,
}

impl Limits {
    pub(super) const STANDARD: Self = Self { kind: Kind::Robust, pixels: 1600, cells: 200, reach: REACH };
    /// Four fifths of the pixels and cells, and of the cells of a search window.
    pub(super) const SMALL: Self = Self { kind: Kind::RobustSmall, pixels: 1296, cells: 162, reach: 7 };

    /// Weights of the largest correlation filter.
    pub(super) const fn weights(self) -> usize {
        self.cells as usize * CHANNELS
    }
}
