//! Synthetic pictures: each pixel is computed from a few numbers, so a frame of any size needs no memory.

use crate::extent::Extent;
use arbitrary::{Result, Unstructured};
use smr_core::{Frame, Image, Rect};

/// Largest number of pixels in a `Part`.
const MAX_AREA: u32 = 1 << 16;

pub(crate) const KINDS: u8 = 7;

#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) width: u16,
    pub(crate) height: u16,
    kind: u8,
    seed: u32,
    right: i32,
    down: i32,
    gain: u8,
}

/// A rectangle of the scene in memory: rows `stride` bytes apart, no byte after the last pixel.
pub(crate) struct Part {
    pixels: Vec<u8>,
    pub(crate) stride: usize,
    pub(crate) rect: Rect,
}

impl Scene {
    pub(crate) fn new(u: &mut Unstructured<'_>, extent: &Extent) -> Result<Self> {
        let (width, height) = match u.int_in_range(0..=9_u8)? {
            0 => (u.int_in_range(1..=u16::MAX)?, u.int_in_range(1..=u16::MAX)?),
            1 => (u.int_in_range(1..=8)?, u.int_in_range(1..=8)?),
            _ => {
                let (Extent { width, height, .. }, u) = (extent, &mut *u);
                (u.int_in_range(width.0..=width.1)?, u.int_in_range(height.0..=height.1)?)
            }
        };
        Ok(Self { width, height, kind: u.arbitrary()?, seed: u.arbitrary()?, right: 0, down: 0, gain: 64 })
    }

    /// Returns a scene of 64x48 pixels of the kind `kind`, not yet moved.
    pub(crate) fn of(kind: u8) -> Self {
        Self { width: 64, height: 48, kind, seed: 0x1234_5678, right: 0, down: 0, gain: 64 }
    }

    pub(crate) fn bounds(&self) -> Rect {
        Rect::new(0, 0, self.width, self.height)
    }

    /// Prepares the next frame: moves the scene, changes its brightness or its texture, or leaves it unchanged.
    pub(crate) fn change(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let by: [i8; 2] = [u.arbitrary()?, u.arbitrary()?];
        match u.int_in_range(0..=7_u8)? {
            0..=3 => {
                self.right = self.right.wrapping_add((by[0] >> 4).into());
                self.down = self.down.wrapping_add((by[1] >> 4).into());
            }
            4 => {
                (self.right, self.down) = (self.right.wrapping_add(by[0].into()), self.down.wrapping_add(by[1].into()));
            }
            5 => self.gain = by[0].cast_unsigned() >> 1,
            6 => (self.kind, self.seed) = (by[0].cast_unsigned(), self.seed ^ u32::from(by[1].cast_unsigned())),
            _ => {}
        }
        Ok(())
    }

    fn pixel(&self, x: i32, y: i32) -> u8 {
        let (x, y) = (x.wrapping_sub(self.right), y.wrapping_sub(self.down));
        let noise = |x: i32, y: i32| {
            let mixed =
                (x.cast_unsigned() ^ self.seed).wrapping_mul(0x9E37_79B1) ^ y.cast_unsigned().wrapping_mul(0x85EB_CA77);
            (mixed ^ (mixed >> 15)).wrapping_mul(0x2C1B_3C6D).to_be_bytes()[0]
        };
        let seen = match self.kind % KINDS {
            0 => noise(x >> 2, y >> 2),
            1 => noise(x, y),
            2 => self.seed.to_le_bytes()[0],
            3 => x.wrapping_mul(3).wrapping_add(y.wrapping_mul(5)).to_le_bytes()[0],
            4 => {
                if (x >> 1 ^ y >> 1) & 1 == 0 {
                    255
                } else {
                    0
                }
            }
            5 => {
                if (8..24).contains(&x) && (8..24).contains(&y) {
                    noise(x >> 1, y >> 1)
                } else {
                    90
                }
            }
            _ => self.seed.to_le_bytes()[(x.wrapping_add(y) & 3).unsigned_abs() as usize],
        };
        u8::try_from(u32::from(seen) * u32::from(self.gain) / 64).unwrap_or(255)
    }

    /// Copies a rectangle of the scene into memory; `None` if it is empty, outside the frame, or too large.
    pub(crate) fn part(&self, rect: Rect, gap: usize) -> Option<Part> {
        if rect.is_empty() || rect.area() > MAX_AREA || !self.bounds().contains(rect) {
            return None;
        }
        let stride = usize::from(rect.width) + gap;
        let mut pixels = Vec::with_capacity(stride * usize::from(rect.height));
        for y in rect.y..rect.bottom() {
            if y > rect.y {
                pixels.extend(std::iter::repeat_n(0xA5, gap));
            }
            pixels.extend((rect.x..rect.right()).map(|x| self.pixel(x, y)));
        }
        Some(Part { pixels, stride, rect })
    }
}

impl Part {
    fn image(&self) -> Image<'_> {
        Image::with_stride(&self.pixels, self.rect.width, self.rect.height, self.stride).expect("as many as it says")
    }

    fn corner(&self) -> (u16, u16) {
        let inside = |at: i32| u16::try_from(at).expect("it lies in the frame");
        (inside(self.rect.x), inside(self.rect.y))
    }
}

pub(crate) fn frame<'a>(scene: &Scene, first: &'a Part, second: Option<&'a Part>) -> Frame<'a> {
    let (x, y) = first.corner();
    let frame = Frame::part(first.image(), x, y, scene.width, scene.height).expect("it lies in the frame");
    second.map_or(frame, |second| {
        let (x, y) = second.corner();
        frame.and_part(second.image(), x, y).expect("it lies in the frame")
    })
}
