//! A built-in recording for demonstrations: a street seen from a mast, in color, with a red car as the target.
//!
//! 300 frames of 320x240 pixels, the same on every platform: see `rays.rs`.
//!
//! | frames (from 0) | what happens |
//! |---|---|
//! | 0 to 120 | the car comes from the right, seen from its side; from 25 to 62 a tree hides it in part |
//! | 39 to 48 | more than half of it is hidden: no truth |
//! | 121 to 230 | it turns, is seen from its front, and comes nearer |
//! | 170 to 215 | its twin, a car of the same make and color, comes the other way and passes beside it |
//! | 231 to 299 | it goes to the right, almost twice as wide as at first, and passes behind a lamp post |

use super::random::Random;
use super::rays::{Paint, SUN, Solid, Triple, is_met, length, levels, minus, mixed, nearest, onward, shown, unit};
use super::sqrt::sqrt;
use super::texture::Texture;
use super::{PIXEL, Sides};
use core::array;

pub const LENGTH: usize = 300;
pub const WIDTH: u16 = 320;
pub const HEIGHT: u16 = 240;
/// Number of rays along each side of a pixel; the pixel is the average of all its rays.
const FINE: u16 = 3;

const EYE: Triple = [0.0, 12.0, 0.0];
/// Slope of the view: meters down for each meter ahead.
const DOWN: f64 = 0.2;
const FOCAL: f64 = 540.0;
const RED: Triple = [0.80, 0.10, 0.08];

const RAYS: usize = FINE as usize * FINE as usize;
const PIXELS: usize = WIDTH as usize * HEIGHT as usize;
const SOLIDS: usize = 85;

/// Buffers in which the street is drawn: 12 MB, all zero before the first frame.
pub struct Street {
    /// Number of the frame in `pixels`, from 1; 0 if none is drawn.
    number: usize,
    pixels: [[u8; 4]; PIXELS],
    still: [[u8; 4]; PIXELS],
    rays: [[Ray; RAYS]; PIXELS],
    leaves: Texture,
}

impl Street {
    pub const BLANK: Self = Self {
        number: 0,
        pixels: [[0; 4]; PIXELS],
        still: [[0; 4]; PIXELS],
        rays: [[Ray { far: 0.0, lit: [0; 3], shaded: [0; 3] }; RAYS]; PIXELS],
        leaves: Texture::BLANK,
    };

    /// Draws frame `index`, from 0: red, green, blue and opacity of each pixel.
    pub fn frame(&mut self, index: usize) -> &[[u8; 4]] {
        if self.number == index.saturating_add(1) {
            return &self.pixels;
        }
        self.stand();
        self.number = index.saturating_add(1);
        let cars = cars(index);
        // No part of a car is farther than 4 meters from its centre.
        let shading = solids(&|solid| cars.iter().any(|car| solid.may_meet(car[0].origin, SUN, 4.0)));
        self.pixels = self.still;
        for (x, y) in cars.iter().flat_map(|car| around(car)) {
            let (pixel, rays) = (&mut self.pixels[place(x, y)], &self.rays[place(x, y)]);
            *pixel = mean(|ray| rays[ray].with(&cars, &shading, &self.leaves, direction(x, y, ray)));
        }
        let mut noise = Random(0x57EE_0000 + index as u64);
        for [colors @ .., _] in &mut self.pixels {
            let noise = i8::try_from(noise.noise() / 2).unwrap_or(0);
            *colors = colors.map(|level| level.saturating_add_signed(noise));
        }
        &self.pixels
    }

    /// Draws the still objects of the scene, on the first call only.
    fn stand(&mut self) {
        if self.still[0] != [0; 4] {
            return;
        }
        let texture = |seed, cells| Texture::new(seed, cells, (0, 255));
        self.leaves = texture(13, (8, 4));
        let (road, solids, textures) = (road(), solids(&|_| true), [texture(11, (16, 4)), texture(12, (32, 2))]);
        let ground = |place| ground(&road, &textures, place);
        for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
            // All solids are within 100 meters, where the rays of a pixel are less than 0.2 meters apart.
            let mut near = solids.iter().flatten().filter(|solid| solid.may_meet(EYE, direction(x, y, RAYS / 2), 0.2));
            let near: [Option<&Solid>; SOLIDS] = array::from_fn(|_| near.next());
            let rays = &mut self.rays[place(x, y)];
            *rays = array::from_fn(|ray| Ray::new(&near, &solids, &ground, &self.leaves, direction(x, y, ray)));
            self.still[place(x, y)] = mean(|ray| rays[ray].lit);
        }
    }

    /// Returns the box of the target car in frame `index`; `None` if more than half of the car is hidden.
    pub fn truth(&mut self, index: usize) -> Option<Sides> {
        self.stand();
        let cars = cars(index);
        let (mut all, mut seen) = (0, 0);
        let (mut least, mut most) = ([i32::MAX; 2], [0; 2]);
        for (x, y) in around(&cars[0]) {
            for ray in 0..RAYS {
                let along = direction(x, y, ray);
                let Some(car) = nearest(&cars[0], EYE, along) else { continue };
                let twin = nearest(&cars[1], EYE, along).is_some_and(|twin| twin.far < car.far);
                all += 1;
                seen += usize::from(!twin && car.far < self.rays[place(x, y)][ray].far);
                for (axis, at) in [x, y].map(i32::from).into_iter().enumerate() {
                    least[axis] = least[axis].min(at);
                    most[axis] = most[axis].max(at + 1);
                }
            }
        }
        (2 * seen >= all).then_some([least[0], least[1], most[0] - least[0], most[1] - least[1]])
    }
}

fn place(x: u16, y: u16) -> usize {
    usize::from(y) * usize::from(WIDTH) + usize::from(x)
}

fn direction(x: u16, y: u16, ray: usize) -> Triple {
    let within = |place: usize| (place as f64 + 0.5) / f64::from(FINE);
    let right = f64::from(x) + within(ray % usize::from(FINE)) - f64::from(WIDTH) / 2.0;
    let up = f64::from(HEIGHT) / 2.0 - f64::from(y) - within(ray / usize::from(FINE));
    unit([right, up - DOWN * FOCAL, FOCAL + DOWN * up])
}

/// Returns the pixels that a car and its shadow may cover.
fn around(car: &[Solid]) -> impl Iterator<Item = (u16, u16)> + use<> {
    let [x, y, z] = minus(car[0].origin, EYE);
    let scale = FOCAL * (1.0 + DOWN * DOWN) / (z - DOWN * y);
    // `middle` and `reach` are in meters.
    let side = |middle: f64, reach: f64, most: u16| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        let at = |place: f64| ((f64::from(most) / 2.0 + place * scale) as u16).min(most);
        at(middle - reach)..at(middle + reach)
    };
    let columns = side(x, 3.5, WIDTH);
    let rows = side(-(y + DOWN * z) / (1.0 + DOWN * DOWN), 2.4, HEIGHT);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

fn mean(color: impl Fn(usize) -> [u8; 3]) -> [u8; 4] {
    let mut sum = [0; 3];
    for ray in 0..RAYS {
        let color = color(ray);
        (0..3).for_each(|channel| sum[channel] += usize::from(color[channel]));
    }
    let [red, green, blue] = sum.map(|sum| u8::try_from(sum / RAYS).unwrap_or(u8::MAX));
    [red, green, blue, u8::MAX]
}

/// The nearest still object on a ray.
#[derive(Clone, Copy)]
struct Ray {
    far: f64,
    /// Color without a car's shadow: in sunlight, or in the shadow of another still object.
    lit: [u8; 3],
    shaded: [u8; 3],
}

impl Ray {
    fn new(
        near: &[Option<&Solid>],
        solids: &Solids,
        ground: &dyn Fn(Triple) -> Triple,
        leaves: &Texture,
        along: Triple,
    ) -> Self {
        let to_ground = if along[1] < 0.0 { EYE[1] / -along[1] } else { f64::INFINITY };
        let solid = nearest(near.iter().flatten().copied(), EYE, along).filter(|solid| solid.far < to_ground);
        let far = solid.as_ref().map_or(to_ground, |solid| solid.far);
        let (color, normal) = match solid {
            Some(solid) => solid.seen(leaves),
            None if far < 400.0 => (ground(onward(EYE, along, far)), [0.0, 1.0, 0.0]),
            None => {
                let sky = mixed([0.80, 0.87, 0.93], [0.45, 0.65, 0.90], (along[1] * 6.0).clamp(0.0, 1.0));
                return Self { far: f64::INFINITY, lit: levels(sky), shaded: levels(sky) };
            }
        };
        let is_lit = !is_met(solids.iter().flatten(), onward(EYE, along, far - 0.01), SUN);
        let [lit, shaded] = [is_lit, false].map(|is_lit| levels(shown(color, normal, far, is_lit)));
        Self { far, lit, shaded }
    }

    /// Returns the color of the ray with the cars in the scene; solids in `shading` may cast shadows on the cars.
    fn with(&self, cars: &[[Solid; 2]; 2], shading: &Solids, leaves: &Texture, along: Triple) -> [u8; 3] {
        let solids = cars.as_flattened();
        match nearest(solids, EYE, along).filter(|car| car.far < self.far) {
            Some(car) => {
                let at = onward(EYE, along, car.far - 0.01);
                let is_lit = !is_met(solids, at, SUN) && !is_met(shading.iter().flatten(), at, SUN);
                let (color, normal) = car.seen(leaves);
                levels(shown(color, normal, car.far, is_lit))
            }
            None if self.far < f64::INFINITY && is_met(solids, onward(EYE, along, self.far - 0.01), SUN) => self.shaded,
            None => self.lit,
        }
    }
}

/// Returns the target and its twin, which drives the other way; a car is a body and a cabin.
fn cars(index: usize) -> [[Solid; 2]; 2] {
    let frame = index.min(LENGTH - 1) as f64;
    // Distance driven, in meters; the cars slow down a little.
    let gone = (0.24 - 0.00014 * frame) * frame;
    let road = road();
    let on = |along: f64, way: f64| {
        let ([x, z], [right, away]) = at(&road, along);
        car([x + 1.7 * way * away, z - 1.7 * way * right], [way * right, way * away], RED)
    };
    [on(33.0 + gone, 1.0), on(112.0 - gone, -1.0)]
}

fn car([x, z]: [f64; 2], heading: [f64; 2], base: Triple) -> [Solid; 2] {
    let body: Paint = |base, [x, y, z], normal, _| {
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
    let cabin: Paint = |base, [x, y, _], normal, _| {
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

/// Centre line of the road: points less than half a meter apart, each with its distance along the road.
type Road = [([f64; 2], f64); 400];

fn road() -> Road {
    /// Control points (right, away) of Bezier curves, in meters: the ends of the bends and, between two ends, the point
    /// where the tangents at both ends meet.
    const BENDS: [f64; 18] =
        [48.0, 62.0, 26.0, 62.0, 6.0, 62.0, -12.0, 62.0, -9.5, 48.5, -7.1, 35.5, 5.0, 32.8, 22.0, 29.0, 39.0, 25.2];
    let bends = BENDS.as_chunks::<2>().0;
    let mut last = (bends[0], 0.0);
    array::from_fn(|point| {
        let (bend, step) = (&bends[2 * (point / 100)..], (point % 100) as f64 / 100.0);
        let between = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * step);
        let at = between(between(bend[0], bend[1]), between(bend[1], bend[2]));
        last = (at, last.1 + distance(last.0, at));
        last
    })
}

/// Returns the position at the distance `along` (meters) on the road, and the heading there.
fn at(road: &Road, along: f64) -> ([f64; 2], [f64; 2]) {
    let next = road.partition_point(|(_, length)| *length <= along).clamp(1, road.len() - 1);
    let ((from, start), (to, end)) = (road[next - 1], road[next]);
    let step = [0, 1].map(|axis| (to[axis] - from[axis]) / (end - start));
    ([0, 1].map(|axis| from[axis] + step[axis] * (along - start)), step)
}

fn ground(road: &Road, [grass, asphalt]: &[Texture; 2], [x, _, z]: Triple) -> Triple {
    // Compares squared distances, because square roots are slow.
    let (mut square, mut along) = (f64::INFINITY, 0.0);
    for &([right, away], length) in road {
        let (right, away) = (right - x, away - z);
        let apart = right * right + away * away;
        if apart < square {
            (square, along) = (apart, length);
        }
    }
    let off = sqrt(square);
    let grass = grain(grass, 5.0 * (x + 22.0), 3.0 * z);
    let asphalt = grain(asphalt, 6.0 * (x + 22.0), 3.0 * z);
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

/// Returns the brightness, from 0 to 1, of a texture at a position in pixels of the texture.
fn grain(texture: &Texture, x: f64, z: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation)] // it saturates
    let sixteenths = |side: f64| (side * f64::from(PIXEL)) as i32;
    f64::from(texture.sample(sixteenths(x), sixteenths(z))) / 65536.0
}

type Solids = [Option<Solid>; SOLIDS];

fn solids(wanted: &dyn Fn(&Solid) -> bool) -> Solids {
    let mut solids = [const { None }; SOLIDS];
    let mut count = 0;
    let mut add = |solid: Solid| {
        if wanted(&solid) {
            solids[count] = Some(solid);
            count += 1;
        }
    };
    const HOUSES: [(f64, f64, f64, Triple, Triple); 4] = [
        (-19.0, 77.0, 5.0, [0.90, 0.84, 0.70], [0.55, 0.25, 0.18]),
        (-5.5, 80.0, 6.2, [0.72, 0.42, 0.33], [0.33, 0.35, 0.40]),
        (8.0, 77.0, 5.2, [0.80, 0.86, 0.90], [0.58, 0.30, 0.20]),
        (21.5, 79.0, 6.0, [0.93, 0.90, 0.84], [0.36, 0.36, 0.42]),
    ];
    for &(x, z, tall, wall, roof) in &HOUSES {
        let wide = [-4.6, 4.6, 3.6];
        add(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, tall], [wide, wide], wall, front));
        let (eaves, ridge) = ([-5.0, 5.0, 4.1], [-4.2, 4.2, 0.0]);
        add(Solid::block([x, tall, z], [1.0, 0.0], [0.0, 3.2], [eaves, ridge], roof, tiles));
    }
    // Each tree: position to the right and away and height of the trunk, in meters; scale of the crown.
    const TREES: [f64; 44] = [
        3.4, 46.0, 3.3, 0.65, -2.5, 45.0, 0.7, 0.7, 0.2, 40.6, 0.5, 0.6, 10.5, 41.5, 0.8, 0.8, -7.9, 27.5, 0.6, 0.8,
        -5.9, 26.6, 0.4, 0.6, 8.2, 25.0, 0.5, 0.6, -18.5, 60.0, 4.2, 1.0, 1.5, 73.0, 4.4, 1.2, 15.0, 72.5, 4.0, 1.1,
        -12.5, 73.0, 4.6, 1.2,
    ];
    for &[x, z, tall, wide] in TREES.as_chunks().0 {
        tree(&mut add, [x, z], tall, wide);
    }
    for (x, z) in [(2.9, 26.9), (-5.0, 67.6), (11.0, 67.6)] {
        let (mast, arm) = ([-0.07, 0.07, 0.07], [-0.1, 0.1, 1.0]);
        let gray = [0.36, 0.40, 0.42];
        add(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, 6.0], [mast, mast], gray, plain));
        add(Solid::block([x, 6.0, z], [1.0, 0.0], [0.0, 0.15], [arm, arm], gray, plain));
    }
    let hedge = [-16.0, 16.0, 0.5];
    add(Solid::block([4.0, 0.0, 71.0], [1.0, 0.0], [0.0, 1.1], [hedge, hedge], [0.16, 0.34, 0.13], leaves));
    car([18.5, 69.0], [-1.0, 0.0], [0.86, 0.87, 0.88]).into_iter().for_each(&mut add);
    car([-8.5, 69.4], [1.0, 0.0], [0.15, 0.30, 0.55]).into_iter().for_each(&mut add);
    solids
}

fn tree(mut add: impl FnMut(Solid), [x, z]: [f64; 2], tall: f64, wide: f64) {
    let (low, high) = ([-0.2, 0.2, 0.2], [-0.12, 0.12, 0.12]);
    add(Solid::block([x, 0.0, z], [1.0, 0.0], [0.0, tall], [low, high], [0.38, 0.27, 0.18], plain));
    // Each ball of a tree's crown: offset to the right, up and away, and radius, in units of the crown's scale.
    const BALLS: [f64; 20] =
        [0.0, 0.0, 0.0, 1.5, -0.9, -0.5, -0.3, 1.1, 0.9, -0.4, -0.2, 1.15, 0.2, 0.9, 0.1, 1.1, -0.1, -0.7, -0.7, 1.1];
    for &[right, up, away, reach] in BALLS.as_chunks().0 {
        let place = onward([x, tall, z], [right, up, away], wide);
        add(Solid::ball(place, reach * wide, [0.24, 0.46, 0.16], leaves));
    }
}

fn plain(base: Triple, _: Triple, _: Triple, _: &Texture) -> Triple {
    base
}

fn leaves(base: Triple, [x, y, z]: Triple, _: Triple, texture: &Texture) -> Triple {
    let spots = grain(texture, 14.0 * (x + 0.6 * z), 14.0 * (y - 0.5 * z));
    base.map(|channel| channel * (0.55 + 0.9 * spots))
}

/// Paints a wall with windows and a door.
fn front(base: Triple, [x, y, _]: Triple, normal: Triple, _: &Texture) -> Triple {
    let (beside, above) = (((x + 4.6) % 2.3 - 1.15).abs(), ((y - 0.3) % 2.7 - 1.3).abs());
    let is_door = (0.0..2.3).contains(&x) && y < 2.2;
    match normal[2].abs() > 0.7 {
        true if is_door && beside < 0.55 => [0.35, 0.22, 0.16],
        true if !is_door && beside < 0.5 && above < 0.65 && beside > 0.05 && above > 0.04 => [0.22, 0.28, 0.34],
        true if !is_door && beside < 0.62 && above < 0.77 => [0.92; 3],
        _ => base,
    }
}

fn tiles(base: Triple, [_, y, _]: Triple, _: Triple, _: &Texture) -> Triple {
    if y % 0.5 < 0.1 { base.map(|channel| channel * 0.75) } else { base }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    length([a[0] - b[0], 0.0, a[1] - b[1]])
}
