//! The built-in recording to look at: a street seen from a mast, drawn by code in color, with a red car to follow.
//!
//! 300 frames of 320x240 pixels, the same on every platform: see `rays.rs`. The still objects are drawn once; each
//! frame adds the two cars and their shadows.
//!
//! | frames (from 0) | what happens |
//! |---|---|
//! | 0 to 120 | the car comes from the right, seen from its side; from 25 to 62 a tree hides it in part |
//! | 39 to 48 | more than half of it is hidden: no truth |
//! | 121 to 230 | it turns, is seen from its front, and comes nearer |
//! | 170 to 215 | its twin, a car of the same make and color, comes the other way and passes beside it |
//! | 231 to 299 | it goes to the right, almost twice as wide as at first, and passes behind a lamp post |

use super::random::Random;
use super::rays::{Paint, SUN, Solid, Triple, is_met, levels, minus, mixed, nearest, onward, shown, unit};
use super::synthetic::{PIXEL, Texture};
use super::{BoundingBox, ColorFrame, GrayFrame, Sequence, Source, luma};
use std::sync::{LazyLock, Mutex, PoisonError};

pub const NAME: &str = "street";
pub const LENGTH: usize = 300;
const WIDTH: u16 = 320;
const HEIGHT: u16 = 240;
/// Rays along each side of a pixel.
const FINE: u16 = 3;

const EYE: Triple = [0.0, 12.0, 0.0];
/// Slope of the view: meters down for each meter ahead.
const DOWN: f64 = 0.2;
/// The focal length in pixels.
const FOCAL: f64 = 540.0;
const RED: Triple = [0.80, 0.10, 0.08];

pub(super) fn sequence() -> Sequence {
    let gray = |index| {
        let ColorFrame { width, height, pixels } = frame(index);
        GrayFrame { width, height, pixels: pixels.into_iter().map(luma).collect() }
    };
    let source = Source::Made(frame, LENGTH);
    Sequence { source, ..Sequence::made(NAME, (0..LENGTH).map(gray), (0..LENGTH).map(truth).collect()) }
}

/// Frame that was drawn last: a reader asks for it in gray, then in color.
static LAST: Mutex<Option<(usize, ColorFrame)>> = Mutex::new(None);

/// Returns frame `index`, counted from 0.
pub fn frame(index: usize) -> ColorFrame {
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match &*last {
        Some((at, frame)) if *at == index => frame.clone(),
        _ => last.insert((index, drawn(index))).1.clone(),
    }
}

fn drawn(index: usize) -> ColorFrame {
    let cars = cars(index);
    // No part of a car lies farther than 4 meters from its middle.
    let may_shade = |solid: &&Solid| cars.iter().any(|car| solid.may_shade(car[0].origin, 4.0));
    let shading: Vec<&Solid> = STREET.solids.iter().filter(may_shade).collect();
    let mut noise = Random(0x57EE_0000 + index as u64);
    let mut pixels = STREET.still.clone();
    for (x, y) in cars.iter().flat_map(|car| around(car)) {
        pixels[place(x, y)] = mean(|ray| STREET.rays[place(x, y)][ray].with(&cars, &shading, direction(x, y, ray)));
    }
    for pixel in &mut pixels {
        let noise = noise.noise() / 2;
        *pixel = pixel.map(|level| u8::try_from((i32::from(level) + noise).clamp(0, 255)).unwrap_or(u8::MAX));
    }
    ColorFrame { width: WIDTH, height: HEIGHT, pixels }
}

/// The box of the car in frame `index`; `None` where more than half of it is hidden.
pub fn truth(index: usize) -> Option<BoundingBox> {
    let cars = cars(index);
    let (mut all, mut seen) = (0, 0);
    let (mut least, mut most) = ([f64::MAX; 2], [0.0_f64; 2]);
    for (x, y) in around(&cars[0]) {
        for ray in 0..RAYS {
            let along = direction(x, y, ray);
            let Some((far, ..)) = nearest(&cars[0], EYE, along) else { continue };
            let twin = nearest(&cars[1], EYE, along).is_some_and(|(twin, ..)| twin < far);
            all += 1;
            seen += usize::from(!twin && far < STREET.rays[place(x, y)][ray].far);
            for (axis, at) in [x, y].map(f64::from).into_iter().enumerate() {
                least[axis] = least[axis].min(at);
                most[axis] = most[axis].max(at + 1.0);
            }
        }
    }
    let (width, height) = (most[0] - least[0], most[1] - least[1]);
    (2 * seen >= all).then_some(BoundingBox { x: least[0], y: least[1], width, height })
}

const RAYS: usize = FINE as usize * FINE as usize;

fn place(x: u16, y: u16) -> usize {
    usize::from(y) * usize::from(WIDTH) + usize::from(x)
}

/// Returns the direction of ray number `ray` of a pixel.
fn direction(x: u16, y: u16, ray: usize) -> Triple {
    let within = |place: usize| (place as f64 + 0.5) / f64::from(FINE);
    let right = f64::from(x) + within(ray % usize::from(FINE)) - f64::from(WIDTH) / 2.0;
    let up = f64::from(HEIGHT) / 2.0 - f64::from(y) - within(ray / usize::from(FINE));
    unit([right, up - DOWN * FOCAL, FOCAL + DOWN * up])
}

/// Returns the pixels that a car and its shadow may reach.
fn around(car: &[Solid]) -> impl Iterator<Item = (u16, u16)> + use<> {
    let [x, y, z] = minus(car[0].origin, EYE);
    let scale = FOCAL * (1.0 + DOWN * DOWN) / (z - DOWN * y);
    // `middle` and `reach` in meters.
    let side = |middle: f64, reach: f64, most: u16| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        let at = |place: f64| ((f64::from(most) / 2.0 + place * scale) as u16).min(most);
        at(middle - reach)..at(middle + reach)
    };
    let columns = side(x, 3.5, WIDTH);
    let rows = side(-(y + DOWN * z) / (1.0 + DOWN * DOWN), 2.4, HEIGHT);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

fn mean(color: impl Fn(usize) -> [u8; 3]) -> [u8; 3] {
    let mut sum = [0; 3];
    for ray in 0..RAYS {
        let color = color(ray);
        (0..3).for_each(|channel| sum[channel] += usize::from(color[channel]));
    }
    sum.map(|sum| u8::try_from(sum / RAYS).unwrap_or(u8::MAX))
}

/// The first still object that a ray meets.
struct Ray {
    far: f64,
    /// Color in the sun, if no other object stands between.
    lit: [u8; 3],
    shaded: [u8; 3],
}

impl Ray {
    fn new(solids: &[Solid], road: &Road, along: Triple) -> Self {
        let solid = nearest(solids, EYE, along);
        let ground = if along[1] < 0.0 { EYE[1] / -along[1] } else { f64::INFINITY };
        let (far, color, normal) = match solid {
            Some((far, color, normal)) if far < ground => (far, color, normal),
            _ if ground < 400.0 => (ground, road.color(onward(EYE, along, ground)), [0.0, 1.0, 0.0]),
            _ => {
                let sky = mixed([0.80, 0.87, 0.93], [0.45, 0.65, 0.90], (along[1] * 6.0).clamp(0.0, 1.0));
                return Self { far: f64::INFINITY, lit: levels(sky), shaded: levels(sky) };
            }
        };
        let shaded = levels(shown(color, normal, far, false));
        let is_lit = !is_met(solids, onward(EYE, along, far - 0.01), SUN);
        Self { far, lit: if is_lit { levels(shown(color, normal, far, true)) } else { shaded }, shaded }
    }

    /// Returns the color of the ray with the cars in the scene; solids in `shading` may cast shadows on the cars.
    fn with(&self, cars: &[[Solid; 2]; 2], shading: &[&Solid], along: Triple) -> [u8; 3] {
        let solids = cars.as_flattened();
        match nearest(solids, EYE, along).filter(|(far, ..)| *far < self.far) {
            Some((far, color, normal)) => {
                let at = onward(EYE, along, far - 0.01);
                let is_lit = !is_met(solids, at, SUN) && !is_met(shading.iter().copied(), at, SUN);
                levels(shown(color, normal, far, is_lit))
            }
            None if self.far < f64::INFINITY && is_met(solids, onward(EYE, along, self.far - 0.01), SUN) => self.shaded,
            None => self.lit,
        }
    }
}

/// The car to follow, and its twin, which comes the other way.
fn cars(index: usize) -> [[Solid; 2]; 2] {
    let frame = index.min(LENGTH - 1) as f64;
    // The cars brake a little.
    let gone = (0.24 - 0.00014 * frame) * frame;
    let on = |along: f64, way: f64| {
        let ([x, z], [right, away]) = STREET.road.at(along);
        // Each car drives on the right.
        car([x + 1.7 * way * away, z - 1.7 * way * right], [way * right, way * away], RED)
    };
    [on(33.0 + gone, 1.0), on(112.0 - gone, -1.0)]
}

fn car([x, z]: [f64; 2], heading: [f64; 2], base: Triple) -> [Solid; 2] {
    let body: Paint = |base, [x, y, z], normal| {
        let [wheel, rise] = [x.abs() - 1.32, y - 0.34];
        let round = wheel * wheel + rise * rise;
        let is_side = normal[2].abs() > 0.7;
        if is_side && round < 0.13 {
            return if round < 0.04 { [0.62; 3] } else { [0.07; 3] };
        }
        let is_end = normal[0].abs() > 0.7;
        match y {
            _ if is_side && round < 0.17 => [0.05; 3],
            ..0.24 => [0.05; 3],
            0.36..0.52 if is_end && z.abs() < 0.3 => [0.92, 0.92, 0.86],
            0.36..0.52 if is_end => [0.12; 3],
            0.55..0.78 if is_end && z.abs() > 0.48 && x > 0.0 => [1.0, 0.98, 0.85],
            0.55..0.78 if is_end && z.abs() > 0.48 => [0.55, 0.02, 0.02],
            _ if is_side && ((x - 0.75).abs() < 0.03 || (x + 0.45).abs() < 0.03) => base.map(|channel| channel * 0.6),
            _ => base,
        }
    };
    let cabin: Paint = |base, [x, y, _], normal| {
        let is_pillar = normal[2].abs() > 0.7 && ((x + 0.45).abs() < 0.06 || y > 1.38);
        if normal[1] > 0.8 || is_pillar { base } else { [0.13, 0.17, 0.22] }
    };
    let at = [x, 0.0, z];
    let block = |tall, ends, paint| Solid::block(at, heading, tall, ends, base, paint);
    [
        block([0.05, 0.88], [[-2.08, 2.1, 0.9], [-2.0, 2.0, 0.84]], body),
        block([0.86, 1.46], [[-1.75, 1.05, 0.82], [-1.3, 0.4, 0.66]], cabin),
    ]
}

/// Middle line of the road: points a few decimeters apart, each with its distance along the road.
struct Road {
    points: Vec<([f64; 2], f64)>,
    grass: Texture,
    asphalt: Texture,
}

impl Road {
    fn new() -> Self {
        /// Ends of bends in turn with the points where the tangents of two ends meet.
        const BENDS: [f64; 18] =
            [48.0, 62.0, 26.0, 62.0, 6.0, 62.0, -12.0, 62.0, -9.5, 48.5, -7.1, 35.5, 5.0, 32.8, 22.0, 29.0, 39.0, 25.2];
        let mut points: Vec<([f64; 2], f64)> = Vec::new();
        let bends = BENDS.as_chunks::<2>().0.windows(3).step_by(2);
        for (bend, step) in bends.flat_map(|bend| (0..100).map(move |step| (bend, f64::from(step) / 100.0))) {
            let between = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * step);
            let at = between(between(bend[0], bend[1]), between(bend[1], bend[2]));
            let length = points.last().map_or(0.0, |(last, length)| length + distance(*last, at));
            points.push((at, length));
        }
        let [grass, asphalt] = [(11, (16, 4)), (12, (32, 2))].map(|(seed, cells)| Texture::new(seed, cells, (0, 255)));
        Self { points, grass, asphalt }
    }

    /// Returns the place at a distance along the road, and the heading there.
    fn at(&self, along: f64) -> ([f64; 2], [f64; 2]) {
        let next = self.points.partition_point(|(_, length)| *length <= along).clamp(1, self.points.len() - 1);
        let ((from, start), (to, end)) = (self.points[next - 1], self.points[next]);
        let step = [0, 1].map(|axis| (to[axis] - from[axis]) / (end - start));
        ([0, 1].map(|axis| from[axis] + step[axis] * (along - start)), step)
    }

    /// Returns the color of the ground at a place.
    fn color(&self, [x, _, z]: Triple) -> Triple {
        let apart = |(at, along): &([f64; 2], f64)| (distance(*at, [x, z]), *along);
        let near = self.points.iter().map(apart).min_by(|a, b| a.0.total_cmp(&b.0));
        let (off, along) = near.unwrap_or((f64::INFINITY, 0.0));
        let grass = grain(&self.grass, 5.0 * (x + 22.0), 3.0 * z);
        let asphalt = grain(&self.asphalt, 6.0 * (x + 22.0), 3.0 * z);
        let is_zebra = (89.5..92.5).contains(&along);
        match off {
            off if off < 3.3 && is_zebra && (off + 0.25) % 1.0 < 0.5 => [0.88; 3],
            off if off < 0.09 && along % 4.0 < 2.0 && !is_zebra => [0.90; 3],
            off if off < 3.5 => [0.33, 0.34, 0.36].map(|gray| gray + 0.12 * asphalt),
            off if off < 3.7 => [0.74; 3],
            off if off < 5.4 => {
                let is_joint = along % 1.2 < 0.08;
                [0.64, 0.60, 0.55].map(|gray| gray + 0.10 * asphalt - if is_joint { 0.12 } else { 0.0 })
            }
            _ => mixed([0.22, 0.40, 0.14], [0.52, 0.66, 0.28], grass),
        }
    }
}

/// Returns the brightness of a texture at a place, from 0 to 1.
fn grain(texture: &Texture, x: f64, z: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation)] // it saturates
    let sixteenths = |side: f64| (side * f64::from(PIXEL)) as i32;
    f64::from(texture.sample(sixteenths(x), sixteenths(z))) / 65536.0
}

/// All objects that stand still.
struct Street {
    road: Road,
    solids: Vec<Solid>,
    /// The rays of each pixel.
    rays: Vec<[Ray; RAYS]>,
    still: Vec<[u8; 3]>,
}

static STREET: LazyLock<Street> = LazyLock::new(|| {
    let (road, solids) = (Road::new(), solids());
    let all = || (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let pixel = |(x, y)| std::array::from_fn(|ray| Ray::new(&solids, &road, direction(x, y, ray)));
    let rays: Vec<[Ray; RAYS]> = all().map(pixel).collect();
    let still = rays.iter().map(|rays| mean(|ray| rays[ray].lit)).collect();
    Street { road, solids, rays, still }
});

fn solids() -> Vec<Solid> {
    let mut solids = Vec::new();
    let houses = [
        (-19.0, 77.0, 5.0, [0.90, 0.84, 0.70], [0.55, 0.25, 0.18]),
        (-5.5, 80.0, 6.2, [0.72, 0.42, 0.33], [0.33, 0.35, 0.40]),
        (8.0, 77.0, 5.2, [0.80, 0.86, 0.90], [0.58, 0.30, 0.20]),
        (21.5, 79.0, 6.0, [0.93, 0.90, 0.84], [0.36, 0.36, 0.42]),
    ];
    for (x, z, tall, wall, roof) in houses {
        let wide = [-4.6, 4.6, 3.6];
        solids.push(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, tall], [wide, wide], wall, front));
        let (eaves, ridge) = ([-5.0, 5.0, 4.1], [-4.2, 4.2, 0.0]);
        solids.push(Solid::block([x, tall, z], [1.0, 0.0], [0.0, 3.2], [eaves, ridge], roof, tiles));
    }
    // Each tree: right, away, height and width.
    const TREES: [f64; 44] = [
        3.4, 46.0, 3.3, 0.65, -2.5, 45.0, 0.7, 0.7, 0.2, 40.6, 0.5, 0.6, 10.5, 41.5, 0.8, 0.8, -7.9, 27.5, 0.6, 0.8,
        -5.9, 26.6, 0.4, 0.6, 8.2, 25.0, 0.5, 0.6, -18.5, 60.0, 4.2, 1.0, 1.5, 73.0, 4.4, 1.2, 15.0, 72.5, 4.0, 1.1,
        -12.5, 73.0, 4.6, 1.2,
    ];
    for &[x, z, tall, wide] in TREES.as_chunks().0 {
        tree(&mut solids, [x, z], tall, wide);
    }
    for (x, z) in [(2.9, 26.9), (-5.0, 67.6), (11.0, 67.6)] {
        let (mast, arm) = ([-0.07, 0.07, 0.07], [-0.1, 0.1, 1.0]);
        let gray = [0.36, 0.40, 0.42];
        solids.push(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, 6.0], [mast, mast], gray, plain));
        solids.push(Solid::block([x, 6.0, z], [1.0, 0.0], [0.0, 0.15], [arm, arm], gray, plain));
    }
    let hedge = [-16.0, 16.0, 0.5];
    solids.push(Solid::block([4.0, 0.0, 71.0], [1.0, 0.0], [0.0, 1.1], [hedge, hedge], [0.16, 0.34, 0.13], leaves));
    solids.extend(car([18.5, 69.0], [-1.0, 0.0], [0.86, 0.87, 0.88]));
    solids.extend(car([-8.5, 69.4], [1.0, 0.0], [0.15, 0.30, 0.55]));
    solids
}

/// A trunk under balls of leaves.
fn tree(solids: &mut Vec<Solid>, [x, z]: [f64; 2], tall: f64, wide: f64) {
    let (low, high) = ([-0.2, 0.2, 0.2], [-0.12, 0.12, 0.12]);
    solids.push(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, tall], [low, high], [0.38, 0.27, 0.18], plain));
    // Each ball: right, up, away and size.
    const BALLS: [f64; 20] =
        [0.0, 0.0, 0.0, 1.5, -0.9, -0.5, -0.3, 1.1, 0.9, -0.4, -0.2, 1.15, 0.2, 0.9, 0.1, 1.1, -0.1, -0.7, -0.7, 1.1];
    for &[right, up, away, reach] in BALLS.as_chunks().0 {
        let place = onward([x, tall, z], [right, up, away], wide);
        solids.push(Solid::ball(place, reach * wide, [0.24, 0.46, 0.16], leaves));
    }
}

fn plain(base: Triple, _: Triple, _: Triple) -> Triple {
    base
}

fn leaves(base: Triple, [x, y, z]: Triple, _: Triple) -> Triple {
    let spots = grain(&LEAVES, 14.0 * (x + 0.6 * z), 14.0 * (y - 0.5 * z));
    base.map(|channel| channel * (0.55 + 0.9 * spots))
}

static LEAVES: LazyLock<Texture> = LazyLock::new(|| Texture::new(13, (8, 4), (0, 255)));

/// A wall with windows and a door.
fn front(base: Triple, [x, y, _]: Triple, normal: Triple) -> Triple {
    let (beside, above) = (((x + 4.6) % 2.3 - 1.15).abs(), ((y - 0.3) % 2.7 - 1.3).abs());
    let is_door = (0.0..2.3).contains(&x) && y < 2.2;
    match normal[2].abs() > 0.7 {
        true if is_door && beside < 0.55 => [0.35, 0.22, 0.16],
        true if !is_door && beside < 0.5 && above < 0.65 && beside > 0.05 && above > 0.04 => [0.22, 0.28, 0.34],
        true if !is_door && beside < 0.62 && above < 0.77 => [0.92; 3],
        _ => base,
    }
}

fn tiles(base: Triple, [_, y, _]: Triple, _: Triple) -> Triple {
    if y % 0.5 < 0.1 { base.map(|channel| channel * 0.75) } else { base }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, z) = (a[0] - b[0], a[1] - b[1]);
    (x * x + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_as_it_was() {
        let bytes = [0, 61, 150, 299].into_iter().flat_map(|index| frame(index).pixels).flatten();
        let fnv = crate::fnv(bytes);
        assert_eq!(fnv, 0x58A7_C6CF_3681_FB9C, "{fnv:#X}");
    }

    #[test]
    fn the_script_is_kept() {
        let hidden: Vec<usize> = (0..LENGTH).filter(|&index| truth(index).is_none()).collect();
        assert_eq!(hidden, (39..=48).collect::<Vec<_>>());
        let [first, last] = [0, LENGTH - 1].map(|index| truth(index).unwrap());
        assert!(last.width * last.height > 3.0 * first.width * first.height, "{first:?} {last:?}");
        assert_eq!(truth(LENGTH), Some(last), "it stands still at the end");
    }

    /// Red is inside the box, and nothing of the car is beside it.
    #[test]
    fn the_truth_lies_on_the_car() {
        for index in [0, 100, 140, 180, 260] {
            let (frame, truth) = (frame(index), truth(index).unwrap());
            let (right, bottom) = (truth.x + truth.width, truth.y + truth.height);
            let (mut inside, mut beside) = (0.0, 0.0);
            for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
                let [red, green, blue] = frame.pixels[place(x, y)].map(u16::from);
                let (x, y) = (f64::from(x), f64::from(y));
                if red > 60 && red > 2 * green.max(blue) && truth.y <= y && y < bottom {
                    inside += f64::from(u8::from(truth.x <= x && x < right));
                    beside += f64::from(u8::from(truth.x - 1.0 == x || x == right));
                }
            }
            assert!(inside > 0.2 * truth.width * truth.height && beside == 0.0, "{index}: {inside} {beside}");
        }
    }
}
