//! Scratch memory of the robust tracker. One workspace serves any number of targets, one update at a time.

use super::buffers::Buffers;
use super::lock::LockPipeline;
use super::pipeline::Pipeline;
use crate::track::update::UnderWay;

/// The progress of the present or last update or lock.
#[derive(Clone, Copy)]
#[repr(u32)] // `Nothing` is 0, so that a workspace in a `static` begins as zeroes
pub(super) enum Progress {
    Nothing,
    Update(Pipeline),
    Lock(LockPipeline),
}

/// The memory that an update needs in addition to the target.
///
/// ```
/// // Firmware often keeps it in a static.
/// static WORKSPACE: smr_core::robust::Workspace = smr_core::robust::Workspace::new();
/// assert!(size_of_val(&WORKSPACE) < 48 * 1024);
/// ```
#[repr(C)] // see `Buffers`
pub struct Workspace {
    pub(super) progress: Progress,
    pub(super) under_way: UnderWay,
    pub(super) buffers: Buffers,
}

impl Workspace {
    /// A workspace. All its bytes are 0, so that in a `static` it takes no flash.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        Self { progress: Progress::Nothing, under_way: UnderWay::NOTHING, buffers: Buffers::new() }
    }

    /// The filter's penalised response at the last update's peak, or at the peak of redetection if that found the
    /// target. Unit: 1/16384. 0 after a lock, and during an update until its candidate is refined.
    pub(crate) const fn response(&self) -> i32 {
        if let Progress::Update(update) = &self.progress { update.candidate().response } else { 0 }
    }
}

impl core::fmt::Debug for Workspace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Workspace").field("response", &self.response()).finish_non_exhaustive()
    }
}

impl Default for Workspace {
    #[inline(always)]
    fn default() -> Self {
        Self::new()
    }
}
