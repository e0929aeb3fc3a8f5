//! Scratch memory of the paper's tracker: one serves any number of targets.

use super::gate::Track;
use crate::image::Rect;
use crate::search::{Found, Search};
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
pub struct Workspace<const PIXELS: usize, const SPAN: usize> {
    pub(super) search: Search<PIXELS, SPAN>,
    /// What the update that is under way scores by.
    pub(super) table: CutTable,
    pub(super) under_way: UnderWay,
    /// What a lock under way will begin with.
    pub(super) locking: Track,
    pub(super) found: Option<Found>,
}

impl<const PIXELS: usize, const SPAN: usize> Workspace<PIXELS, SPAN> {
    /// A workspace.
    #[must_use]
    #[inline(always)] // made where it stays: as a call it takes its own size of stack and is copied
    pub const fn new() -> Self {
        Self {
            search: Search::new(),
            table: CutTable::EMPTY,
            under_way: UnderWay::NOTHING,
            locking: Track::new(Rect::new(0, 0, 0, 0), Rect::new(0, 0, 0, 0)),
            found: None,
        }
    }

    /// What the last update that was finished here has found: the peak itself, believed or not, and the runner-up's score. For
    /// checking; an [`Answer`](crate::Answer) says what follows from it.
    #[must_use]
    pub const fn found(&self) -> Option<Found> {
        self.found
    }
}

impl<const PIXELS: usize, const SPAN: usize> Default for Workspace<PIXELS, SPAN> {
    #[inline(always)] // made where it stays
    fn default() -> Self {
        Self::new()
    }
}
