//! Scratch memory of the paper's tracker: one serves any number of targets.

use super::gate::Track;
use crate::image::Rect;
use crate::search::{Found, Search, Window};
use crate::similarity::CutTable;
use crate::track::update::UnderWay;

/// What an update needs beside the target: `PIXELS` bytes for ranges, five words for each of `SPAN` offsets, and a
/// table.
///
/// ```
/// // In firmware it is often a static.
/// static WORKSPACE: smr_core::paper::Workspace<4096, 33> = smr_core::paper::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 4096 + 20 * 33 + 900);
/// ```
#[repr(C)] // what may end in padding stands before a vector: before zeroes, both are made on the stack and copied
pub struct Workspace<const PIXELS: usize, const SPAN: usize> {
    pub(super) under_way: UnderWay,
    /// What a lock under way will begin with.
    pub(super) locking: Track,
    /// What is searched in.
    pub(super) window: Window,
    /// What the update that is under way scores by.
    pub(super) table: CutTable,
    pub(super) search: Search<PIXELS, SPAN>,
}

impl<const PIXELS: usize, const SPAN: usize> Workspace<PIXELS, SPAN> {
    /// A workspace. All its bytes are 0, so that in a `static` it takes no flash.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new() -> Self {
        Self {
            search: Search::new(),
            table: const { CutTable::EMPTY },
            under_way: const { UnderWay::NOTHING },
            locking: const { Track::new(Rect::new(0, 0, 0, 0), Rect::new(0, 0, 0, 0)) },
            window: const { Window::NONE },
        }
    }

    /// What the last update here has found: the peak itself, believed or not, and the runner-up's score. `None` until all is searched.
    /// For checking; an [`Answer`](crate::Answer) says what follows from it.
    #[must_use]
    pub fn found(&self) -> Option<Found> {
        self.search.found(&self.window)
    }
}

impl<const PIXELS: usize, const SPAN: usize> Default for Workspace<PIXELS, SPAN> {
    #[inline(always)] // made where it stays
    fn default() -> Self {
        Self::new()
    }
}
