//! Generated recordings of a slow target on a textured background: dark, bright, textured, smooth and noisy targets.

use crate::PIXEL;
use crate::random::Random;
use crate::synthetic::{Keys, between};
use crate::texture::Texture;

pub const LENGTH: usize = 120;
pub const WIDTH: u16 = 160;
pub const HEIGHT: u16 = 120;
/// Width and height of the target, in pixels.
const SIDE: i32 = 36;

/// Key frames of the left and top edge of the target: frame number and position in pixels.
const X: &Keys = &[(0, 28), (70, 84), (119, 60)];
const Y: &Keys = &[(0, 52), (50, 30), (119, 66)];

struct Kind {
    name: &'static str,
    /// Cell sides in pixels of two grids of random levels, a coarse and a fine one; the texture averages both grids.
    grain: (i32, i32),
    levels: (i32, i32),
    /// Strength of the sensor noise; 1 is a standard deviation of 2.3 gray levels.
    noise: i32,
}

const KINDS: [Kind; 5] = [
    Kind { name: "dark", grain: (8, 4), levels: (5, 60), noise: 1 },
    Kind { name: "bright", grain: (8, 4), levels: (195, 250), noise: 1 },
    Kind { name: "textured", grain: (8, 4), levels: (10, 225), noise: 1 },
    Kind { name: "smooth", grain: (32, 16), levels: (60, 200), noise: 1 },
    Kind { name: "noisy", grain: (8, 4), levels: (10, 225), noise: 6 },
];

pub const COUNT: usize = KINDS.len();

/// Left and top edge of the target in frame `index`, in sixteenths of a pixel.
fn place(index: usize) -> (i32, i32) {
    let frame = i32::try_from(index).unwrap_or(i32::MAX);
    (between(X, frame, PIXEL), between(Y, frame, PIXEL))
}

/// Returns the target's box in frame `index`: left, top, width and height in pixels.
pub fn truth(index: usize) -> [f64; 4] {
    let pixels = |sixteenths: i32| f64::from(sixteenths) / f64::from(PIXEL);
    let ((x, y), side) = (place(index), f64::from(SIDE));
    [pixels(x), pixels(y), side, side]
}

/// A recording: its kind and its textures.
pub struct Slow {
    number: u64,
    kind: &'static Kind,
    target: Texture,
    ground: Texture,
}

impl Slow {
    /// Makes the textures of recording `number`, which must be below [`COUNT`].
    pub fn new(number: usize) -> Self {
        let (kind, number) = (&KINDS[number], number as u64);
        let target = Texture::new(0x7A00 + number, kind.grain, kind.levels);
        let ground = Texture::new(0x6B00 + number, (16, 8), (40, 200));
        Self { number, kind, target, ground }
    }

    pub fn name(&self) -> &'static str {
        self.kind.name
    }

    /// Returns a function of the gray level of the pixel (x, y) in frame `index`; the noise goes on at each call.
    pub fn frame(&self, index: usize) -> impl FnMut(i32, i32) -> u8 {
        let mut noise = Random(0x5107_0000 + (self.number << 12) + index as u64);
        let (left, top) = place(index);
        move |x, y| {
            // The target is sampled at the centre of a pixel, the background at its upper left corner.
            let (right, down) = (x * PIXEL + PIXEL / 2 - left, y * PIXEL + PIXEL / 2 - top);
            let inside = (0..SIDE * PIXEL).contains(&right) && (0..SIDE * PIXEL).contains(&down);
            let sampled =
                if inside { self.target.sample(right, down) } else { self.ground.sample(x * PIXEL, y * PIXEL) };
            let level = (sampled >> 8) + self.kind.noise * noise.noise();
            u8::try_from(level.clamp(0, 255)).unwrap_or(u8::MAX)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_move_slowly_and_stay_inside() {
        for index in 1..LENGTH {
            let ((x, y), (from_x, from_y)) = (place(index), place(index - 1));
            assert!((x - from_x).abs() <= 2 * PIXEL && (y - from_y).abs() <= 2 * PIXEL, "frame {index}");
            let inside = |at: i32, side: u16| 0 <= at && at + SIDE * PIXEL <= i32::from(side) * PIXEL;
            assert!(inside(x, WIDTH) && inside(y, HEIGHT), "frame {index}");
        }
    }

    #[test]
    fn each_target_is_what_it_is_called() {
        let means: Vec<u32> = (0..COUNT)
            .map(|number| {
                let slow = Slow::new(number);
                let mut level = slow.frame(0);
                (0..36 * 36).map(|at| u32::from(level(28 + at % 36, 52 + at / 36))).sum::<u32>() / (36 * 36)
            })
            .collect();
        assert!(means[0] < 60 && means[1] > 195, "{means:?}");
        assert!(means[2..].iter().all(|mean| (80..180).contains(mean)), "{means:?}");
    }
}
