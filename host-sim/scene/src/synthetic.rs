//! A generated built-in recording, for tests on a machine without recordings.
//!
//! 240 frames of 160x120 pixels, the same on every platform: integers only, own random numbers, fixed seeds. A textured
//! target of 24x28 pixels moves in whole pixels over a textured background that pans in sixteenths of a pixel. The
//! sensor adds noise (standard deviation 2.3); the light drifts from 100 % to 78 % to 113 % to 98 %.
//!
//! | frames (from 0) | what happens |
//! |---|---|
//! | 0 to 80 | the target moves freely, at most 3 pixels a frame; from 50 on a post comes in from the right |
//! | 81 to 129 | the post slides slowly over the target, hides up to 10.8 of its 24 columns, and slowly withdraws |
//! | 130 to 167 | the post leaves to the right, the target goes to the left edge |
//! | 168 to 178 | the target leaves the picture; from 173 on more than half of it is outside: no truth |
//! | 179 to 195 | it is wholly outside |
//! | 196 to 203 | it comes back, in the same light as before; from 200 on more than half of it is inside |
//! | 204 to 239 | it moves on to the middle, while the light falls |

use super::random::Random;
use super::texture::Texture;
use super::{PIXEL, Sides};

pub const LENGTH: usize = 240;
pub const WIDTH: u16 = 160;
pub const HEIGHT: u16 = 120;

const TARGET_WIDTH: i32 = 24 * PIXEL;
const TARGET_HEIGHT: i32 = 28 * PIXEL;
const POST_WIDTH: i32 = 36 * PIXEL;

/// Key frames: pairs of a frame number and a value, with smooth interpolation between them.
pub(crate) type Keys = [(i32, i32)];

/// Left and top edge of the target, in whole pixels. At fractions of a pixel a tracker that replaces its template in
/// every frame would drift, but trackers must be able to follow this recording to its end.
const TARGET_X: &Keys =
    &[(0, 36), (32, 84), (66, 60), (134, 64), (160, 8), (184, -28), (190, -28), (224, 56), (239, 66)];
const TARGET_Y: &Keys = &[(0, 24), (32, 52), (66, 66), (134, 62), (184, 46), (190, 46), (239, 54)];
/// Left edge, in pixels, of a post that is as high as the picture and hides the target.
const POST_X: &Keys = &[(48, 161), (75, 85), (100, 76), (110, 76), (134, 88), (154, 161)];
/// Left and top edge of the picture in the background's texture, in pixels: too small for the texture to repeat.
const PAN_X: &Keys = &[(0, 0), (120, 70), (239, 10)];
const PAN_Y: &Keys = &[(0, 12), (80, 26), (160, 0), (239, 20)];
/// Brightness factor, in 256ths, for the textures' gray levels; constant while the target is outside the picture.
const LIGHT: &Keys = &[(0, 256), (80, 200), (150, 290), (210, 290), (239, 250)];

/// Returns the target's box in frame `index`; `None` if more than half the target is hidden or outside the picture.
pub fn truth(index: usize) -> Option<Sides> {
    let scene = Scene::at(index);
    let sides = [scene.target_x, scene.target_y, TARGET_WIDTH, TARGET_HEIGHT];
    (2 * scene.visible() >= TARGET_WIDTH * TARGET_HEIGHT).then_some(sides.map(|length| length / PIXEL))
}

struct Scene {
    target_x: i32,
    target_y: i32,
    post_x: i32,
    pan_x: i32,
    pan_y: i32,
    light: i32,
}

impl Scene {
    fn at(index: usize) -> Self {
        let frame = i32::try_from(index).unwrap_or(i32::MAX);
        let position = |keys| between(keys, frame, PIXEL);
        Self {
            target_x: between(TARGET_X, frame, 1) * PIXEL,
            target_y: between(TARGET_Y, frame, 1) * PIXEL,
            post_x: position(POST_X),
            pan_x: position(PAN_X),
            pan_y: position(PAN_Y),
            light: between(LIGHT, frame, 1),
        }
    }

    /// Returns the gray level, with sensor noise, of the pixel with top left corner (`x`, `y`), in sixteenths of a
    /// pixel.
    fn pixel(&self, textures: &Textures, x: i32, y: i32, noise: &mut Random) -> u8 {
        let lit = (self.texture(textures, x, y) * self.light) >> 16;
        u8::try_from((lit + noise.noise()).clamp(0, 255)).unwrap_or(u8::MAX)
    }

    /// Returns the gray level at (`x`, `y`), times 256: the post covers the target, and the target the background.
    fn texture(&self, textures: &Textures, x: i32, y: i32) -> i32 {
        // A pixel shows the texture at its centre.
        let (dx, dy) = (x - self.target_x + PIXEL / 2, y - self.target_y + PIXEL / 2);
        let post = x - self.post_x + PIXEL / 2;
        if (0..POST_WIDTH).contains(&post) {
            textures.post.sample(post, y)
        } else if (0..TARGET_WIDTH).contains(&dx) && (0..TARGET_HEIGHT).contains(&dy) {
            textures.target.sample(dx, dy)
        } else {
            textures.background.sample(x + self.pan_x, y + self.pan_y)
        }
    }

    /// Returns the area of the target inside the picture and not behind the post, in squared sixteenths of a pixel.
    fn visible(&self) -> i32 {
        let (width, height) = (i32::from(WIDTH) * PIXEL, i32::from(HEIGHT) * PIXEL);
        let inside = |from: i32, to: i32| (to.min(width) - from.max(0)).max(0);
        let (left, right) = (self.target_x, self.target_x + TARGET_WIDTH);
        let hidden = inside(left.max(self.post_x), right.min(self.post_x + POST_WIDTH));
        let rows = (self.target_y + TARGET_HEIGHT).min(height) - self.target_y.max(0);
        (inside(left, right) - hidden) * rows.max(0)
    }
}

/// Returns `unit` times the value in `frame`, interpolated between two keys by 3 t^2 - 2 t^3 with t from 0 to 1.
pub(crate) fn between(keys: &Keys, frame: i32, unit: i32) -> i32 {
    let next = keys.partition_point(|&(key, _)| key <= frame);
    let Some(&(start, from)) = keys.get(next.saturating_sub(1)) else { return 0 };
    let Some(&(end, to)) = keys.get(next.max(1)) else { return from * unit };
    let t = (frame - start).clamp(0, end - start) * 256 / (end - start);
    let smooth = (t * t * (3 * 256 - 2 * t)) >> 8; // of 65536
    from * unit + (((to - from) * unit * smooth) >> 16)
}

pub struct Textures {
    target: Texture,
    background: Texture,
    post: Texture,
}

impl Textures {
    pub fn new(seed: u64) -> Self {
        Self {
            target: Texture::new(3 * seed + 1, (8, 4), (10, 225)),
            background: Texture::new(3 * seed + 2, (16, 8), (40, 200)),
            post: Texture::new(3 * seed + 3, (32, 4), (20, 120)),
        }
    }

    /// Draws frame `index`, from 0, row by row; `noise` is the seed of its noise. After the last frame nothing moves.
    pub fn frame(&self, index: usize, noise: u64) -> impl Iterator<Item = u8> {
        let (scene, mut noise) = (Scene::at(index), Random(noise));
        let places = (0..i32::from(HEIGHT)).flat_map(|y| (0..i32::from(WIDTH)).map(move |x| (x, y)));
        places.map(move |(x, y)| scene.pixel(self, x * PIXEL, y * PIXEL, &mut noise))
    }
}
