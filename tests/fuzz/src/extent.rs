//! Limits of the trackers' inputs: the same calls are tested with few large inputs or with many small ones.

/// Limits of one input. On purpose, some inputs have frames and boxes outside these limits.
pub(crate) struct Extent {
    pub(crate) width: (u16, u16),
    pub(crate) height: (u16, u16),
    pub(crate) side: u16,
    pub(crate) window: u16,
    pub(crate) grown: u16,
    pub(crate) calls: u32,
    /// Largest number of updates, of the paper tracker and of the robust tracker.
    pub(crate) updates: [u32; 2],
    /// Compares the saved bytes after each call, not only before a lock and at the end.
    pub(crate) each_call: bool,
    /// Makes a tracker that is slow to lock start mostly from a saved target.
    pub(crate) from_saved: bool,
}

pub(crate) const WIDE: Extent = Extent {
    width: (16, 80),
    height: (12, 64),
    side: 20,
    window: 12,
    grown: 20,
    calls: 40,
    updates: [12, 6],
    each_call: true,
    from_saved: false,
};

pub(crate) const SHORT: Extent = Extent {
    width: (12, 32),
    height: (10, 28),
    side: 9,
    window: 4,
    grown: 7,
    calls: 10,
    updates: [4, 2],
    each_call: false,
    from_saved: true,
};
