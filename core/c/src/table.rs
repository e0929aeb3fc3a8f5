//! Tables of the similarity for other scales than the paper's, in the caller's memory.

use crate::pointer;
use crate::status::{smr_status, status_of};
use smr_core::similarity::{Table, TableError};

/// A table of similarities: entry d is exp(-d / scale) in units of 1/65535. 512 bytes, filled by #smr_table_init.
///
/// You need one only for another scale than the paper's, 255, which is built in.
#[repr(C)]
pub struct smr_table {
    /// The similarity of two pixels, by their difference in gray levels.
    pub entries: [u16; 256],
}

// `smr_table_init` writes a `Table` to the memory of an `smr_table`: size and alignment must be equal.
const _: () = assert!(size_of::<Table>() == size_of::<smr_table>());
const _: () = assert!(align_of::<Table>() == align_of::<smr_table>());

/// Fills a table for #smr_config.
///
/// @param table  Memory for the table. Trackers configured with it read it in every update: it must stay where it is, unchanged,
///               as long as any of them is used.
/// @param scale  In gray levels, from 1 (almost only equal pixels are similar) to 4096 (almost all pixels are). The
/// paper's is 255. @return       #SMR_OK, #SMR_ERROR_NULL, #SMR_ERROR_MISALIGNED or #SMR_ERROR_SCALE_OUT_OF_RANGE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn smr_table_init(table: *mut smr_table, scale: u16) -> smr_status {
    // SAFETY: the caller gives memory for an smr_table, which has the size and alignment of a Table (asserted above).
    status_of(unsafe { init(table.cast(), scale) })
}

/// # Safety
/// A `table` that passes `pointer::check` points to memory for a `Table`.
unsafe fn init(table: *mut Table, scale: u16) -> Result<(), smr_status> {
    pointer::check(table)?;
    if !Table::SCALES.contains(&scale) {
        return Err(TableError::ScaleOutOfRange.into());
    }
    // SAFETY: there is memory for a Table, which is 256 u16 and nothing else, so zeroes are a valid one.
    let table = unsafe {
        table.write_bytes(0, 1);
        &mut *table
    };
    Ok(table.set(scale)?)
}

/// The table of a configuration. NULL stands for the paper's.
///
/// # Safety
/// A `table` that passes `pointer::check` points to an initialised [`smr_table`] that stays there, unchanged, as long
/// as the result is used. The result is `'static` because a tracker in C's storage has no lifetime that Rust knows.
pub(crate) unsafe fn given(table: *const smr_table) -> Result<&'static Table, smr_status> {
    if table.is_null() {
        return Ok(&Table::PAPER);
    }
    let table: *const Table = table.cast();
    pointer::check(table)?;
    // SAFETY: neither NULL nor misaligned. A Table is 256 u16 and nothing else, so any bytes are a Table; the caller
    // ensures that they stay.
    let table = unsafe { &*table };
    // exp(0) is 1.0 in every table that `init` fills, but not in zeroed memory.
    if table.similarity(0) == Table::ONE { Ok(table) } else { Err(smr_status::SMR_ERROR_NOT_INITIALISED) }
}
