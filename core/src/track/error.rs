//! Errors: one small enum per operation, the same for both trackers.

errors! {
    /// The reason why a configuration was refused.
    ConfigError {
        /// A value of a setting is outside its range.
        OutOfRange {
            /// The name of the setting.
            name: &'static str,
            /// The lowest allowed value.
            lowest: u16,
            /// The highest allowed value.
            highest: u16,
            /// The refused value.
            found: u16,
        } => "{name} is {lowest} to {highest}, not {found}",
        /// `window_limit` is smaller than `window`.
        LimitBelowWindow => "window_limit is smaller than window",
        /// `uncertain_below` is smaller than `lost_below`.
        UncertainBelowLost => "uncertain_below is smaller than lost_below",
        /// `window` has more offsets on an axis than the tracker's `SPAN`. Only from [`Paper`](crate::Paper).
        WindowTooLarge => "the window has more offsets on an axis than this tracker has room for",
        /// The refiner is on, in a build without the feature `refiner`.
        RefinerNotBuiltIn => "the refiner is on, and this build is without it (feature refiner)",
        /// No setting has this name: see [`Settings::SETTINGS`](crate::Settings::SETTINGS).
        UnknownSetting => "no setting of this tracker has this name",
        /// The count of values is not the one that the setting takes.
        WrongCount {
            /// The name of the setting.
            name: &'static str,
            /// The count of values that the setting takes.
            count: usize,
        } => "{name} takes {count} numbers",
    }

    /// The reason why a box was not locked.
    LockError {
        /// The box has no pixels.
        BoxEmpty => "the box has no pixels: width and height must be at least 1",
        /// The box is not wholly inside the frame.
        BoxOutsideFrame => "the box is not wholly inside the frame",
        /// The box has more than `PIXELS` pixels. Only from [`Paper`](crate::Paper).
        BoxTooLarge => "the box has more pixels than this tracker's template has room for",
        /// The window could exceed `SPAN` offsets on an axis: reduce `window_limit` or increase `SPAN`. Only from
        /// `Paper`.
        WindowTooLarge => "the window can grow to more offsets on an axis than this tracker has room for",
        /// [`Target::lock_window`](crate::Target::lock_window) is not wholly in memory.
        LockWindowNotInMemory => "the lock window is not wholly in memory",
    }

    /// The reason why a frame was not searched.
    UpdateError {
        /// There is no target yet: call `lock` first.
        NotLocked => "there is no target yet: lock first",
        /// The frame does not have the size of the frame in which the target was locked.
        FrameSizeChanged => "the frame has another size than the one that was locked on",
        /// [`Target::window`](crate::Target::window) or [`Target::sweep_window`](crate::Target::sweep_window) is not
        /// wholly in memory.
        WindowNotInMemory => "the search window is not wholly in memory",
    }

    /// The reason why a target was not saved.
    SaveError {
        /// There is no target yet: lock first.
        NotLocked => "there is no target yet: lock first",
        /// The buffer is smaller than [`Target::saved_size`](crate::Target::saved_size).
        /// [`Target::SAVED_SIZE`](crate::Target::SAVED_SIZE) bytes are always enough.
        BufferTooSmall => "the buffer is too small for the target",
    }

    /// The reason why a target was not restored.
    RestoreError {
        /// The bytes are not those of a saved target.
        NotSaved => "these are not the bytes of a saved target",
        /// Another version of the crate wrote the bytes.
        OtherVersion => "the target was saved by another version",
        /// The bytes end too early.
        Truncated => "the saved target ends too early",
        /// The bytes have changed since they were written.
        Damaged => "the saved target is damaged: its checksum is wrong",
        /// A tracker of the other kind (`Paper` or `Robust`) or of another [`Size`](crate::robust::Size) saved the target.
        OtherTracker => "the target was saved by another tracker, or by one of another size",
        /// The configuration is not the one the target was saved with. Contains the first setting that differs.
        OtherConfig(name: &'static str) => "the target was saved with another configuration: {name} differs",
        /// The template has more pixels, or the window more offsets, than this tracker has room for.
        TooLarge => "the saved target is too large for this tracker",
    }
}
