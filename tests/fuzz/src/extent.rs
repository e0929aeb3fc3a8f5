//! How large and how long the inputs of the trackers are: the same calls, wide and deep or short and many.

/// The most of everything in one input. A few inputs go beyond the sizes.
pub(crate) struct Extent {
    /// Sides of a frame, from and to.
    pub(crate) width: (u16, u16),
    pub(crate) height: (u16, u16),
    /// Side of a box.
    pub(crate) side: u16,
    /// Radius of the window, and to what it grows.
    pub(crate) window: u16,
    pub(crate) grown: u16,
    pub(crate) calls: u32,
    /// Updates of the paper's tracker, and of the robust one.
    pub(crate) updates: [u32; 2],
    /// Whether what is remembered is compared after each call, or before a lock and at the end.
    pub(crate) each_call: bool,
    /// Whether a tracker that is slow to lock goes on, mostly, with a target that was saved before.
    pub(crate) from_saved: bool,
}

/// Hundreds of executions a second.
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

/// Thousands: for millions of inputs.
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
