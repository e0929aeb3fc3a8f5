//! The size of a cell of the robust tracker's features.

/// Side of a cell in pixels of the grid.
pub const CELL: u16 = 4;
/// Bytes of a cell, one for each channel.
pub const CHANNELS: usize = 10;
/// Side of a cell with its neighbours, in pixels.
pub(crate) const SIDE: usize = CELL as usize + 2;
