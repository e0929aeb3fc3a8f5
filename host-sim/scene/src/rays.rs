//! Ray casting of balls and blocks in sunlight, for generated scenes.
//!
//! Uses only sums, products, quotients, remainders and square roots, which IEEE 754 rounds alike on every machine.

use super::sqrt::sqrt;
use super::texture::Texture;

/// A position or direction in meters (right, up, away), or a color (red, green, blue) from 0 to 1.
pub type Triple = [f64; 3];

pub const SUN: Triple = [-0.48, 0.77, -0.42];
const HAZE: Triple = [0.78, 0.84, 0.90];

/// Shades a color by sunlight, and by haze at the distance `far` in meters.
pub fn shown(color: Triple, normal: Triple, far: f64, is_lit: bool) -> Triple {
    let sun = if is_lit { 0.75 * dot(normal, SUN).max(0.0) } else { 0.0 };
    let light = 0.42 + 0.10 * normal[1] + sun;
    mixed(color.map(|channel| channel * light), HAZE, (far / 420.0).min(1.0))
}

pub fn levels(color: Triple) -> [u8; 3] {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
    color.map(|channel| (channel * 255.0) as u8)
}

/// A ball, or a block whose four side faces may be slanted.
pub struct Solid {
    pub origin: Triple,
    /// Direction of the front on the ground: right and away.
    heading: [f64; 2],
    /// Radius in meters of a bounding sphere around `origin`.
    reach: f64,
    /// For each face: outward normal, and distance of the face from the origin; `None` for a ball.
    faces: Option<[(Triple, f64); 6]>,
    base: Triple,
    paint: Paint,
}

/// A function that gives the color at a position and normal, in the solid's own axes; `leaves` is a texture of foliage.
pub type Paint = fn(base: Triple, at: Triple, normal: Triple, leaves: &Texture) -> Triple;

pub struct Hit<'a> {
    pub far: f64,
    solid: &'a Solid,
    /// Position of the hit. Like `normal`, it is in the solid's own axes.
    at: Triple,
    normal: Triple,
}

impl Hit<'_> {
    /// Returns the color, and the normal in the axes of the scene.
    pub fn seen(&self, leaves: &Texture) -> (Triple, Triple) {
        let (Solid { heading: [c, s], base, paint, .. }, [x, y, z]) = (self.solid, self.normal);
        (paint(*base, self.at, self.normal, leaves), [x * c - z * s, y, x * s + z * c])
    }
}

/// Back end, front end and half width of a block at one height, in meters.
pub type Ends = [f64; 3];

impl Solid {
    pub fn ball(origin: Triple, reach: f64, base: Triple, paint: Paint) -> Self {
        Self { origin, heading: [1.0, 0.0], reach, faces: None, base, paint }
    }

    pub fn block(
        origin: Triple,
        heading: [f64; 2],
        [low, high]: [f64; 2],
        [bottom, top]: [Ends; 2],
        base: Triple,
        paint: Paint,
    ) -> Self {
        let tall = high - low;
        let face = |normal: Triple, at: Triple| (unit(normal), dot(unit(normal), at));
        let faces = Some([
            face([0.0, 1.0, 0.0], [0.0, high, 0.0]),
            face([0.0, -1.0, 0.0], [0.0, low, 0.0]),
            face([-tall, top[0] - bottom[0], 0.0], [bottom[0], low, 0.0]),
            face([tall, bottom[1] - top[1], 0.0], [bottom[1], low, 0.0]),
            face([0.0, bottom[2] - top[2], tall], [0.0, low, bottom[2]]),
            face([0.0, bottom[2] - top[2], -tall], [0.0, low, -bottom[2]]),
        ]);
        let longest = |ends: Ends| ends[0].abs().max(ends[1].abs());
        let corner = [longest(bottom).max(longest(top)), low.abs().max(high.abs()), bottom[2].max(top[2])];
        Self { origin, heading, reach: length(corner), faces, base, paint }
    }

    /// False if no ray in the direction `along` that starts within `reach` of `place` meets the solid.
    pub fn may_meet(&self, place: Triple, along: Triple, reach: f64) -> bool {
        let apart = minus(self.origin, place);
        let ahead = dot(apart, along);
        dot(apart, apart) - ahead * ahead / dot(along, along) < (self.reach + reach) * (self.reach + reach)
    }

    fn inward(&self, [x, y, z]: Triple) -> Triple {
        let [c, s] = self.heading;
        [x * c + z * s, y, z * c - x * s]
    }

    fn hit(&self, from: Triple, along: Triple) -> Option<Hit<'_>> {
        let from = minus(from, self.origin);
        let (middle, apart) = (-dot(from, along), dot(from, from) - self.reach * self.reach);
        let within = middle * middle - apart;
        if within < 0.0 || (middle < 0.0 && apart > 0.0) {
            return None;
        }
        let (from, along) = (self.inward(from), self.inward(along));
        let (mut enter, mut leave, mut normal) = (0.0, f64::INFINITY, [0.0; 3]);
        if self.faces.is_none() {
            (enter, leave) = (middle - sqrt(within), middle);
            normal = onward(from, along, enter).map(|side| side / self.reach);
        }
        for &(face, far) in self.faces.iter().flatten() {
            let (toward, beyond) = (dot(face, along), dot(face, from) - far);
            if toward < 0.0 {
                if beyond / -toward > enter {
                    (enter, normal) = (beyond / -toward, face);
                }
            } else if toward > 0.0 {
                leave = leave.min(-beyond / toward);
            } else if beyond > 0.0 {
                return None;
            }
        }
        let at = onward(from, along, enter);
        (0.0 < enter && enter < leave).then_some(Hit { far: enter, solid: self, at, normal })
    }
}

pub fn is_met<'a>(solids: impl IntoIterator<Item = &'a Solid>, from: Triple, along: Triple) -> bool {
    solids.into_iter().any(|solid| solid.hit(from, along).is_some())
}

pub fn nearest<'a>(solids: impl IntoIterator<Item = &'a Solid>, from: Triple, along: Triple) -> Option<Hit<'a>> {
    solids.into_iter().filter_map(|solid| solid.hit(from, along)).min_by(|a, b| a.far.total_cmp(&b.far))
}

pub fn dot(a: Triple, b: Triple) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn minus(a: Triple, b: Triple) -> Triple {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn onward(from: Triple, along: Triple, far: f64) -> Triple {
    [from[0] + along[0] * far, from[1] + along[1] * far, from[2] + along[2] * far]
}

pub fn length(of: Triple) -> f64 {
    sqrt(dot(of, of))
}

pub fn unit(of: Triple) -> Triple {
    let length = length(of);
    of.map(|side| side / length)
}

pub fn mixed(a: Triple, b: Triple, part: f64) -> Triple {
    onward(a, minus(b, a), part)
}
