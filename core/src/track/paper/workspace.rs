//! Scratch memory of the paper's tracker. One workspace serves any number of targets.

use crate::search::{Found, Search, Window};
use crate::similarity::CutTable;
use crate::track::update::UnderWay;
use core::fmt;

/// Scratch memory for an update: `PIXELS` bytes of ranges, `20 * SPAN` bytes of maxima and bounds, and a table.
///
/// ```
/// // Firmware often keeps it in a static.
/// static WORKSPACE: smr_core::paper::Workspace<4096, 33> = smr_core::paper::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 4096 + 20 * 33 + 900);
/// ```
// Fields with padding come before the vectors in `search`. In the other order the compiler builds the value on the
// stack and copies it instead of zeroing it in place.
#[repr(C)]
pub struct Workspace<const PIXELS: usize, const SPAN: usize> {
    pub(super) under_way: UnderWay,
    pub(super) window: Window,
    pub(super) table: CutTable,
    pub(super) search: Search<PIXELS, SPAN>,
}

impl<const PIXELS: usize, const SPAN: usize> Workspace<PIXELS, SPAN> {
    /// An empty workspace. All its bytes are 0, so a `static` takes no flash.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self {
            search: Search::new(),
            table: const { CutTable::EMPTY },
            under_way: const { UnderWay::NOTHING },
            window: const { Window::NONE },
        }
    }

    /// The peak and the runner-up of the last search, for checks, even if the gate refused the peak. `None` while a
    /// search is under way. The result of an update is its [`Answer`](crate::Answer).
    pub(crate) fn found(&self) -> Option<Found> {
        self.search.found(&self.window)
    }
}

impl<const PIXELS: usize, const SPAN: usize> fmt::Debug for Workspace<PIXELS, SPAN> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").field("found", &self.found()).finish_non_exhaustive()
    }
}

impl<const PIXELS: usize, const SPAN: usize> Default for Workspace<PIXELS, SPAN> {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}
