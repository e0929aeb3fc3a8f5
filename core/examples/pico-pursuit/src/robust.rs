//! The robust tracker on a Pico: fewer frames a second, for targets that change their size and look.

use smr_core::Robust;
use smr_core::robust::Config;

/// Width and height of the target in pixels. When the button is pressed, the target must be in the middle of the frame.
pub const TARGET_PIXELS: u16 = 24;
pub type Chosen = Robust;

/// Speed of the head per error, for the 130 milliseconds that pass until a picture has turned the head.
pub const GAIN_PER_SECOND: f32 = 4.0;
/// It learns in updates, and needs no new lock.
pub const UPDATES_PER_TEMPLATE: u32 = u32::MAX;

pub const fn config() -> Config {
    Config::robust()
}
