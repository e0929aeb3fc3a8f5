//! The paper tracker on a Pico, with settings for small targets and many frames a second.

use crate::camera::{HEIGHT, WIDTH};
use smr_core::Paper;
use smr_core::paper::{Config, Fraction, Margins, Radius};

/// Width and height of the target in pixels. When the button is pressed, the target must be in the middle of the frame.
pub const TARGET_PIXELS: u16 = 24;
pub type Chosen = Paper<{ TARGET_PIXELS as usize * TARGET_PIXELS as usize }, 33>;

/// Speed of the head per error. Times the delay from a picture to its pulse (see the README) it stays below 1/2.
pub const GAIN_PER_SECOND: f32 = 8.0;
/// Updates from one template to the next. Each template can be off by half a pixel. With a new one in every update, a
/// slow target would move by less than that, and be learnt without being followed.
pub const UPDATES_PER_TEMPLATE: u32 = 32;

pub fn config() -> Config {
    let mut config = Config::camera();
    config.window = Radius { x: 8, y: 8 };
    config.window_limit = Radius { x: 16, y: 16 };
    // Rejects a peak hardly above the runner-up, so that the head does not follow an object in front of the target.
    config.gate_tracking = Fraction::new(5, 4);
    config.neighbourhood = 5;
    // No box keeps that far from the edges: an update learns nothing, only a lock does.
    config.update_zone = Margins { left: WIDTH, top: HEIGHT, right: WIDTH, bottom: HEIGHT };
    config
}
