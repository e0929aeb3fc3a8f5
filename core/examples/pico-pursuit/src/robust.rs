//! The robust tracker on a Pico: fewer frames a second, for targets that change their size and look.

use smr_core::Robust;
use smr_core::robust::Config;

/// Width and height of the target in pixels. When the button is pressed, the target must be in the middle of the frame.
pub const TARGET_PIXELS: u16 = 24;
pub type Chosen = Robust;

/// Speed of the head per error, lower than with the paper tracker, because the delay is longer.
pub const GAIN_PER_SECOND: f32 = 4.0;
/// It learns in updates, and needs no new lock.
pub const UPDATES_PER_TEMPLATE: u32 = u32::MAX;

/// A smaller window than the preset's, and less of the picture in each frame in which the target is lost: an update
/// that takes longer delays the head, which must then turn more slowly.
pub const fn config() -> Config {
    let mut config = Config::robust();
    config.reach = 5;
    config.sweep = 1;
    config
}
