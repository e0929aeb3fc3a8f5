//! Video without end: a textured target on a textured ground, with all that happens to one, and faults of the camera. The same for
//! the same seed.

use smr_core::Rect;
use smr_recordings::GrayFrame;
use smr_recordings::fault::Fault;
use smr_recordings::random::Random;

/// Width and height of a frame in pixels.
pub const WIDTH: u16 = 160;
pub const HEIGHT: u16 = 120;

const W: i64 = WIDTH as i64;
const H: i64 = HEIGHT as i64;

/// A scene under way.
pub struct Video {
    random: Random,
    seed: u64,
    ground: Texture,
    target: Texture,
    size: (i64, i64),
    /// Of the target's top left corner, and by how much that changes, in 256ths of a pixel.
    place: (i64, i64),
    velocity: (i64, i64),
    /// How far the ground has moved, in pixels.
    pan: (i64, i64),
    /// Light, 256 being that of the textures.
    light: i64,
    /// What hides the target: its left edge in pixels, and how many frames it will be there.
    post: (i64, u64),
    /// A fault, and its next frame.
    fault: Option<(Fault, usize)>,
    noise: Vec<i8>,
    faults: Vec<Fault>,
    /// Of faults that have begun.
    pub faulty: u64,
    before: GrayFrame,
    former: GrayFrame,
}

impl Video {
    pub fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x50AC);
        let coarse = 3 + random.below(8);
        let (ground, target) = (Texture::new(&mut random, coarse), Texture::new(&mut random, 4));
        let size = (12 + random.below(30), 12 + random.below(30));
        let noise = (0..1 << 14).map(|_| i8::try_from(random.below(7) - 3).unwrap_or(0)).collect();
        let place = (256 * random.below(W - size.0), 256 * random.below(H - size.1));
        let nothing = GrayFrame { width: WIDTH, height: HEIGHT, pixels: Vec::new() };
        let mut video = Self {
            random,
            seed,
            ground,
            target,
            size,
            place,
            velocity: (0, 0),
            pan: (0, 0),
            light: 256,
            post: (0, 0),
            fault: None,
            noise,
            faults: Fault::all(),
            faulty: 0,
            before: nothing.clone(),
            former: nothing,
        };
        video.former = video.scene();
        video.before = video.former.clone();
        video
    }

    /// The first frame, and the box of the target in it.
    pub fn first(&self) -> (&GrayFrame, Rect) {
        let at = |place: i64| i32::try_from(place >> 8).unwrap_or(0);
        let side = |side: i64| u16::try_from(side).unwrap_or(1);
        (&self.former, Rect::new(at(self.place.0), at(self.place.1), side(self.size.0), side(self.size.1)))
    }

    /// The next frame that comes: one that a fault swallows does not.
    pub fn frame(&mut self) -> GrayFrame {
        loop {
            self.step();
            let whole = self.scene();
            let shown = self.shown(&whole);
            self.former = whole;
            if let Some(shown) = shown {
                return shown;
            }
        }
    }

    fn shown(&mut self, whole: &GrayFrame) -> Option<GrayFrame> {
        if self.fault.is_none() && self.random.below(150) == 0 {
            let which = self.random.place(self.faults.len());
            self.fault = self.faults.get(which).map(|&fault| (fault, 0));
            self.before = self.former.clone();
            self.faulty += 1;
        }
        let Some((fault, index)) = self.fault else { return Some(whole.clone()) };
        self.fault = (index + 1 < fault.frames()).then_some((fault, index + 1));
        fault.of(index, whole, (&self.before, &self.former), self.seed ^ self.faulty)
    }

    /// Everything moves on.
    fn step(&mut self) {
        let random = &mut self.random;
        let mut drift = |of: i64, most: i64| (of + random.below(129) - 64).clamp(-most, most);
        self.velocity = (drift(self.velocity.0, 900), drift(self.velocity.1, 700));
        self.place = (self.place.0 + self.velocity.0, self.place.1 + self.velocity.1);
        // It may leave the picture, and turns when it is wholly outside.
        let turn = |place: i64, velocity: i64, size: i64, end: i64| {
            let outside = if place < -256 * size { 1 } else { -i64::from(place > 256 * end) };
            if outside == 0 { velocity } else { outside * velocity.abs().max(200) }
        };
        self.velocity =
            (turn(self.place.0, self.velocity.0, self.size.0, W), turn(self.place.1, self.velocity.1, self.size.1, H));
        self.pan = (self.pan.0 + random.below(3) - 1, self.pan.1 + random.below(3) - 1);
        self.light = (self.light + random.below(5) - 2).clamp(140, 330);
        if random.below(400) == 0 {
            // A jump of the light.
            self.light = 180 + random.below(130);
        }
        if self.post.1 > 0 {
            self.post.1 -= 1;
            self.post.0 -= 1;
        } else if random.below(200) == 0 {
            self.post = ((self.place.0 >> 8) + self.size.0, 60);
        }
        if random.below(2000) == 0 {
            // Elsewhere at once.
            self.place = (256 * random.below(W - self.size.0), 256 * random.below(H - self.size.1));
        }
    }

    fn scene(&mut self) -> GrayFrame {
        let lit: Vec<u8> =
            (0..256).map(|level: i64| u8::try_from(((level * self.light) >> 8).clamp(0, 255)).unwrap_or(255)).collect();
        let mut start = self.random.place(self.noise.len());
        let (left, top) = (self.place.0 >> 8, self.place.1 >> 8);
        let mut pixels = Vec::with_capacity(usize::from(WIDTH) * usize::from(HEIGHT));
        for y in 0..H {
            let target = (top..top + self.size.1).contains(&y);
            for x in 0..W {
                let level = if self.post.1 > 0 && (self.post.0..self.post.0 + 30).contains(&x) {
                    self.ground.at(3 * x, y)
                } else if target && (left..left + self.size.0).contains(&x) {
                    self.target.at(x - left, y - top)
                } else {
                    self.ground.at(x + self.pan.0, y + self.pan.1)
                };
                start = (start + 1) % self.noise.len();
                pixels.push(lit[usize::from(level)].saturating_add_signed(self.noise[start]));
            }
        }
        GrayFrame { width: WIDTH, height: HEIGHT, pixels }
    }
}

/// 256x256 gray levels that go on beyond their edges.
struct Texture(Vec<u8>);

impl Texture {
    /// Tiles of `tile` pixels, with their edges blurred.
    fn new(random: &mut Random, tile: i64) -> Self {
        let tiles: Vec<i64> = (0..1 << 12).map(|_| random.below(256)).collect();
        let at = |x: i64, y: i64| {
            let (column, row) = (x.rem_euclid(256) / tile, y.rem_euclid(256) / tile);
            tiles[usize::try_from((row * 57 + column) % (1 << 12)).unwrap_or(0)]
        };
        let blurred = |place: i64| {
            let (x, y) = (place % 256, place / 256);
            u8::try_from((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4).unwrap_or(0)
        };
        Self((0..1 << 16).map(blurred).collect())
    }

    fn at(&self, x: i64, y: i64) -> u8 {
        self.0[usize::from(y.to_le_bytes()[0]) << 8 | usize::from(x.to_le_bytes()[0])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_same_for_the_same_seed() {
        let frames = |seed| {
            let mut video = Video::new(seed);
            (0..300).map(|_| video.frame()).collect::<Vec<_>>()
        };
        let first = frames(3);
        assert_eq!(first, frames(3));
        assert_ne!(first[7], frames(4)[7]);
        let bounds = Rect::new(0, 0, WIDTH, HEIGHT);
        for seed in 0..50 {
            assert!(bounds.contains(Video::new(seed).first().1), "{seed}");
        }
    }

    #[test]
    fn faults_and_much_else_happen() {
        let mut video = Video::new(1);
        let frames: Vec<_> = (0..3000).map(|_| video.frame()).collect();
        assert!(video.faulty > 5, "{}", video.faulty);
        assert!(frames.iter().any(|frame| frame.pixels.iter().all(|&pixel| pixel == 0)), "a black frame");
        assert!(frames.iter().all(|frame| frame.pixels.len() == 160 * 120));
    }
}
