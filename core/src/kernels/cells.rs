//! The size of a cell of the robust tracker's features.

/// Pixels of the grid on a side of a cell.
pub const CELL: u16 = 4;
/// Bytes of a cell.
pub const CHANNELS: usize = 10;
/// Pixels on a side of a cell with its neighbours.
pub(crate) const SIDE: usize = CELL as usize + 2;
