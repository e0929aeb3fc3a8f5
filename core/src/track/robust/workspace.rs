//! Scratch memory of the robust tracker: one serves any number of targets.

use super::exact::MARGIN;
use super::features::{CELL, CHANNELS, Strip};
use super::filter::Desk;
use super::grid::MOST_SIDE;
use super::responses::{Responses, SPAN};
use super::update::{Progress, SIZE_REACH};
use super::{MOST_CELLS, MOST_PIXELS, REACH};
use crate::similarity::CutTable;
use crate::track::update::UnderWay;
use heapless::Vec;

/// Bytes of the largest window of cells: the longest filter has the longest rim.
const WINDOW: usize =
    (MOST_SIDE + 2 * REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * REACH as usize) * CHANNELS;
/// Bytes of the largest window that sizes are looked for in.
const ASIDE: usize =
    (MOST_SIDE + 2 * SIZE_REACH) as usize * (MOST_CELLS / MOST_SIDE as usize + 2 * SIZE_REACH as usize) * CHANNELS;
/// Pixels of the largest view, a template and `MARGIN` on each side: the longest template has the longest rim.
const VIEW: usize = (MOST_SIDE * CELL + 2 * MARGIN) as usize
    * (MOST_PIXELS.div_ceil((MOST_SIDE * CELL) as usize) + 2 * MARGIN as usize);

/// What an update needs beside the target.
///
/// ```
/// // In firmware it is often a static.
/// static WORKSPACE: smr_core::robust::Workspace = smr_core::robust::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 48 * 1024);
/// ```
#[repr(C)] // what may end in padding stands before a vector: before zeroes, both are made on the stack and copied
pub struct Workspace {
    pub(super) progress: Progress,
    /// Cells of the window.
    pub(super) cells: Vec<i8, WINDOW>,
    pub(super) responses: Responses,
    /// What templates are compared by.
    pub(super) table: CutTable,
    pub(super) desk: Desk,
    /// Cells of another scale.
    pub(super) aside: Vec<i8, ASIDE>,
    pub(super) strip: Strip,
    pub(super) view: Vec<u8, VIEW>,
    pub(super) under_way: UnderWay,
    pub(super) lit: Vec<u8, MOST_PIXELS>,
}

impl Workspace {
    /// A workspace. All its bytes are 0, so that in a `static` it takes no flash.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new() -> Self {
        // These three as constants, for the same reason.
        Self {
            strip: const { Strip::new() },
            cells: Vec::new(),
            responses: Responses { rows: [[0; SPAN]; SPAN], span: 0 },
            aside: Vec::new(),
            desk: Desk::new(),
            view: Vec::new(),
            lit: Vec::new(),
            table: const { CutTable::EMPTY },
            progress: const { Progress::new() },
            under_way: UnderWay::NOTHING,
        }
    }
}

impl Workspace {
    /// The filter's response where the target was found by the last update that was finished here, in units of 1/16384: about 1
    /// where the target looks as it did. For checking; see [`Answer::confidence`](crate::Answer::confidence).
    #[must_use]
    pub const fn response(&self) -> i32 {
        self.progress.look.peak.response
    }
}

impl Default for Workspace {
    #[inline(always)] // made where it stays
    fn default() -> Self {
        Self::new()
    }
}
