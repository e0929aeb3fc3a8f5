//! Tests [`Config::camera`]: a slight change of light after a still scene must not move the box.

use smr_core::paper::Config;
use smr_core::{Frame, Image, Paper, Rect, State, Tracker};

const TARGET: Rect = Rect::new(60, 40, 24, 24);

/// Noise of middle gray levels, `light` levels brighter; if `uneven`, every seventh pixel one level more.
fn picture(light: u8, uneven: bool) -> Vec<u8> {
    let mut state = 3_u32;
    let noise = std::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state.to_be_bytes()[0]
    });
    let uneven = |index: usize| u8::from(uneven && index.is_multiple_of(7));
    noise.take(160 * 120).enumerate().map(|(index, level)| level / 2 + 40 + light + uneven(index)).collect()
}

fn states(config: Config) -> Vec<(Rect, State)> {
    let pictures = [picture(0, false), picture(1, true), picture(3, false)];
    let frame = |pixels| Frame::whole(Image::new(pixels, 160, 120).expect("160x120 pixels"));
    let mut tracker = Tracker::<Paper<576, 200>>::with(config).expect("a configuration that can be used");
    tracker.lock(&frame(&pictures[0]), TARGET).expect("a box in the picture");
    let answers = pictures[1..].iter().map(|pixels| tracker.update(&frame(pixels)).expect("a frame of the same size"));
    answers.map(|answer| (answer.bbox, answer.state)).collect()
}

#[test]
fn two_gray_levels_of_light_after_a_still_scene_do_not_move_the_box() {
    assert_eq!(states(Config::camera()), [(TARGET, State::Tracking); 2]);
    // With the paper's rule alpha falls to one gray level, and no pixel of the target counts.
    let paper = states(Config::paper());
    assert_eq!(paper[0], (TARGET, State::Tracking));
    assert_ne!(paper[1], (TARGET, State::Tracking));
}

/// Without a least alpha hardly any pixel matches. A peak by chance is not accepted.
#[test]
fn a_peak_of_a_few_pixels_is_not_accepted() {
    let mut config = Config::camera();
    config.least_threshold = 0;
    assert_eq!(states(config)[1], (TARGET, State::Lost));
    config.least_ratio = 0;
    assert_ne!(states(config)[1].0, TARGET);
}
