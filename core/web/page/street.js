// The built-in recording: host-sim/recordings/src/street.rs describes it. Here the same numbers are computed in the same order, without those that
// change no pixel. It is drawn as it plays, because its noise makes it large however it is packed.

import { Random } from "./random.js";
import { Shade, Solid, isShaded, levels, minus, mixed, nearest, onward, shown, unit } from "./rays.js";
import { PIXEL, sample, texture } from "./texture.js";

const WIDTH = 320;
const HEIGHT = 240;
// Rays a pixel along each side.
const FINE = 3;
const RAYS = FINE * FINE;

const EYE = [0, 12, 0];
// Down by one meter in `1 / DOWN`.
const DOWN = 0.2;
// The focal length in pixels.
const FOCAL = 540;
const RED = [0.8, 0.1, 0.08];

let street = null;

/** Frame `index`, counted from 0, as a canvas has it: { width, height, data }, in red, green, blue and opacity. */
export function streetFrame(index) {
  street ??= new Street();
  const data = street.still.slice();
  const cars = carsOf(index);
  const solids = cars.flat();
  for (const [body] of cars) {
    around(body, (x, y) => street.draw(data, x, y, solids));
  }
  const random = new Random(0x57ee0000 + index);
  for (let at = 0; at < data.length; at += 4) {
    const noise = Math.trunc(random.noise() / 2);
    // They are clamped to 0 and 255.
    data[at] += noise;
    data[at + 1] += noise;
    data[at + 2] += noise;
  }
  return { width: WIDTH, height: HEIGHT, data };
}

// Where a ray of a pixel goes.
function direction(x, y, ray) {
  const within = (place) => (place + 0.5) / FINE;
  const right = x + within(ray % FINE) - WIDTH / 2;
  const up = HEIGHT / 2 - y - within(Math.floor(ray / FINE));
  return unit([right, up - DOWN * FOCAL, FOCAL + DOWN * up]);
}

// Calls `visit` for the pixels that a car and its shadow may reach.
function around(body, visit) {
  const [x, y, z] = minus(body.origin, EYE);
  const scale = (FOCAL * (1 + DOWN * DOWN)) / (z - DOWN * y);
  // `middle` and `reach` in meters.
  const side = (middle, reach, most) => [middle - reach, middle + reach].map((end) => Math.min(Math.max(Math.trunc(most / 2 + end * scale), 0), most));
  const [left, right] = side(x, 3.5, WIDTH);
  const [top, bottom] = side(-(y + DOWN * z) / (1 + DOWN * DOWN), 2.4, HEIGHT);
  for (let row = top; row < bottom; row++) {
    for (let column = left; column < right; column++) {
      visit(column, row);
    }
  }
}

// The car to follow, and its twin, which comes the other way.
function carsOf(frame) {
  // They brake a little.
  const gone = (0.24 - 0.00014 * frame) * frame;
  const on = (along, way) => {
    const [[x, z], [right, away]] = street.road.at(along);
    // On the right.
    return car([x + 1.7 * way * away, z - 1.7 * way * right], [way * right, way * away], RED);
  };
  return [on(33 + gone, 1), on(112 - gone, -1)];
}

function car([x, z], heading, base) {
  const block = (tall, ends, paint) => Solid.block([x, 0, z], heading, tall, ends, base, paint);
  return [
    block([0.05, 0.88], [[-2.08, 2.1, 0.9], [-2, 2, 0.84]], body),
    block([0.86, 1.46], [[-1.75, 1.05, 0.82], [-1.3, 0.4, 0.66]], cabin),
  ];
}

function body(base, [x, y, z], normal) {
  const [wheel, rise] = [Math.abs(x) - 1.32, y - 0.34];
  const round = wheel * wheel + rise * rise;
  const isSide = Math.abs(normal[2]) > 0.7;
  if (isSide && round < 0.13) {
    return gray(round < 0.04 ? 0.62 : 0.07);
  }
  const isEnd = Math.abs(normal[0]) > 0.7;
  if ((isSide && round < 0.17) || y < 0.24) {
    return gray(0.05);
  }
  if (isEnd && y >= 0.36 && y < 0.52) {
    return Math.abs(z) < 0.3 ? [0.92, 0.92, 0.86] : gray(0.12);
  }
  if (isEnd && y >= 0.55 && y < 0.78 && Math.abs(z) > 0.48) {
    return x > 0 ? [1, 0.98, 0.85] : [0.55, 0.02, 0.02];
  }
  const isGap = isSide && (Math.abs(x - 0.75) < 0.03 || Math.abs(x + 0.45) < 0.03);
  return isGap ? base.map((channel) => channel * 0.6) : base;
}

function cabin(base, [x, y], normal) {
  const isPillar = Math.abs(normal[2]) > 0.7 && (Math.abs(x + 0.45) < 0.06 || y > 1.38);
  return normal[1] > 0.8 || isPillar ? base : [0.13, 0.17, 0.22];
}

const gray = (level) => [level, level, level];

// Ends of bends, and between two of them the place where their tangents meet.
const BENDS = [[48, 62], [26, 62], [6, 62], [-12, 62], [-9.5, 48.5], [-7.1, 35.5], [5, 32.8], [22, 29], [39, 25.2]];

// The middle of the road, a point each few decimeters, with how far along it is.
class Road {
  #points = [];
  #grass = texture(11, 16, 4, 0, 255);
  #asphalt = texture(12, 32, 2, 0, 255);

  constructor() {
    let along = 0;
    for (let bend = 0; bend + 2 < BENDS.length; bend += 2) {
      const [start, corner, end] = BENDS.slice(bend, bend + 3);
      for (let step = 0; step < 100; step++) {
        const between = (a, b) => [0, 1].map((axis) => a[axis] + (b[axis] - a[axis]) * (step / 100));
        const [x, z] = between(between(start, corner), between(corner, end));
        const last = this.#points.at(-1);
        along = last === undefined ? 0 : along + distance(last.x - x, last.z - z);
        this.#points.push({ x, z, along });
      }
    }
  }

  /** The place so far along the road, and its heading. */
  at(along) {
    const next = this.#points.findIndex((point) => point.along > along);
    const [from, to] = this.#points.slice(next - 1, next + 1);
    const [right, away] = [to.x - from.x, to.z - from.z].map((side) => side / (to.along - from.along));
    return [[from.x + right * (along - from.along), from.z + away * (along - from.along)], [right, away]];
  }

  /** The color of the ground. */
  color([x, , z]) {
    const [off, along] = this.#closest(x, z);
    const grass = grain(this.#grass, 5 * (x + 22), 3 * z);
    const asphalt = grain(this.#asphalt, 6 * (x + 22), 3 * z);
    const isZebra = along >= 89.5 && along < 92.5;
    if (off < 3.3 && isZebra && (off + 0.25) % 1 < 0.5) {
      return gray(0.88);
    }
    if (off < 0.09 && along % 4 < 2 && !isZebra) {
      return gray(0.9);
    }
    if (off < 3.5) {
      return [0.33, 0.34, 0.36].map((level) => level + 0.12 * asphalt);
    }
    if (off < 3.7) {
      return gray(0.74);
    }
    if (off < 5.4) {
      const joint = along % 1.2 < 0.08 ? 0.12 : 0;
      return [0.64, 0.6, 0.55].map((level) => level + 0.1 * asphalt - joint);
    }
    return mixed([0.22, 0.4, 0.14], [0.52, 0.66, 0.28], grass);
  }

  // How far the middle of the road is, and how far along it.
  #closest(x, z) {
    let [off, along] = [Infinity, 0];
    for (let at = 0; at < this.#points.length; ) {
      const point = this.#points[at];
      const apart = distance(point.x - x, point.z - z);
      if (apart < off) {
        off = apart;
        along = point.along;
      }
      // From one point to the next it is less than 0.5 meters: those between are not nearer.
      at += Math.max(1, Math.ceil((apart - off) / 0.5));
    }
    return [off, along];
  }
}

// From 0 to 1.
function grain(levels, x, z) {
  return sample(levels, Math.trunc(x * PIXEL), Math.trunc(z * PIXEL)) / 65536;
}

// All that stands still. It is drawn once.
class Street {
  road = new Road();
  still = new Uint8ClampedArray(4 * WIDTH * HEIGHT).fill(255);
  #shade;
  // What each ray of each pixel meets: how far it is, and its color, in the sun, if nothing else is between, and in the shade.
  #far = new Float64Array(WIDTH * HEIGHT * RAYS);
  #lit = new Uint8Array(3 * WIDTH * HEIGHT * RAYS);
  #shaded = new Uint8Array(3 * WIDTH * HEIGHT * RAYS);

  constructor() {
    const solids = solidsOf();
    this.#shade = new Shade(solids);
    for (let pixel = 0; pixel < WIDTH * HEIGHT; pixel++) {
      const [x, y] = [pixel % WIDTH, Math.floor(pixel / WIDTH)];
      const near = metBy(x, y, solids);
      for (let ray = 0; ray < RAYS; ray++) {
        this.#meet(pixel * RAYS + ray, near, direction(x, y, ray));
      }
      this.draw(this.still, x, y, []);
    }
  }

  #meet(ray, solids, along) {
    const ground = along[1] < 0 ? EYE[1] / -along[1] : Infinity;
    const solid = nearest(solids, EYE, along);
    const isSolid = solid !== null && solid.far < ground;
    if (!isSolid && ground >= 400) {
      const sky = levels(mixed([0.8, 0.87, 0.93], [0.45, 0.65, 0.9], Math.min(Math.max(along[1] * 6, 0), 1)));
      this.#far[ray] = Infinity;
      this.#lit.set(sky, 3 * ray);
      return;
    }
    const { far, color, normal } = isSolid ? solid : { far: ground, color: this.road.color(onward(EYE, along, ground)), normal: [0, 1, 0] };
    const isLit = !this.#shade.isAt(onward(EYE, along, far - 0.01));
    this.#far[ray] = far;
    this.#lit.set(levels(shown(color, normal, far, isLit)), 3 * ray);
    this.#shaded.set(levels(shown(color, normal, far, false)), 3 * ray);
  }

  /** Draws a pixel with the cars there: the mean color of its rays. */
  draw(data, x, y, cars) {
    const pixel = y * WIDTH + x;
    const near = metBy(x, y, cars);
    let [red, green, blue] = [0, 0, 0];
    for (let ray = pixel * RAYS; ray < (pixel + 1) * RAYS; ray++) {
      const along = direction(x, y, ray % RAYS);
      const far = this.#far[ray];
      const car = nearest(near, EYE, along);
      const isCar = car !== null && car.far < far;
      const color = isCar ? this.#colorOf(car, cars, along) : far < Infinity && isShaded(cars, onward(EYE, along, far - 0.01)) ? this.#shaded : this.#lit;
      const at = isCar ? 0 : 3 * ray;
      red += color[at];
      green += color[at + 1];
      blue += color[at + 2];
    }
    data[4 * pixel] = Math.trunc(red / RAYS);
    data[4 * pixel + 1] = Math.trunc(green / RAYS);
    data[4 * pixel + 2] = Math.trunc(blue / RAYS);
  }

  #colorOf({ far, color, normal }, cars, along) {
    const at = onward(EYE, along, far - 0.01);
    return levels(shown(color, normal, far, !isShaded(cars, at) && !this.#shade.isAt(at)));
  }
}

// Those that rays of a pixel may meet. All are within 100 meters, where these rays are less than 0.2 meters apart.
function metBy(x, y, solids) {
  const middle = direction(x, y, Math.floor(RAYS / 2));
  return solids.filter((solid) => solid.mayMeet(EYE, middle, 0.2));
}

const HOUSES = [
  [-19, 77, 5, [0.9, 0.84, 0.7], [0.55, 0.25, 0.18]],
  [-5.5, 80, 6.2, [0.72, 0.42, 0.33], [0.33, 0.35, 0.4]],
  [8, 77, 5.2, [0.8, 0.86, 0.9], [0.58, 0.3, 0.2]],
  [21.5, 79, 6, [0.93, 0.9, 0.84], [0.36, 0.36, 0.42]],
];
// Right, away, height and width of each.
const TREES = [
  [3.4, 46, 3.3, 0.65], [-2.5, 45, 0.7, 0.7], [0.2, 40.6, 0.5, 0.6], [10.5, 41.5, 0.8, 0.8], [-7.9, 27.5, 0.6, 0.8], [-5.9, 26.6, 0.4, 0.6],
  [8.2, 25, 0.5, 0.6], [-18.5, 60, 4.2, 1], [1.5, 73, 4.4, 1.2], [15, 72.5, 4, 1.1], [-12.5, 73, 4.6, 1.2],
];
// Right, up, away and size of each ball of leaves.
const BALLS = [[0, 0, 0, 1.5], [-0.9, -0.5, -0.3, 1.1], [0.9, -0.4, -0.2, 1.15], [0.2, 0.9, 0.1, 1.1], [-0.1, -0.7, -0.7, 1.1]];

function solidsOf() {
  const spots = texture(13, 8, 4, 0, 255);
  const leaves = (base, [x, y, z]) => {
    const spot = grain(spots, 14 * (x + 0.6 * z), 14 * (y - 0.5 * z));
    return base.map((channel) => channel * (0.55 + 0.9 * spot));
  };
  const block = (x, y, z, tall, ends, base, paint) => Solid.block([x, y, z], [1, 0], [0, tall], ends, base, paint);
  const both = (ends) => [ends, ends];
  const houses = HOUSES.flatMap(([x, z, tall, wall, roof]) => [
    block(x, 0, z, tall, both([-4.6, 4.6, 3.6]), wall, front),
    block(x, tall, z, 3.2, [[-5, 5, 4.1], [-4.2, 4.2, 0]], roof, tiles),
  ]);
  const trees = TREES.flatMap(([x, z, tall, wide]) => [
    block(x, 0, z, tall, [[-0.2, 0.2, 0.2], [-0.12, 0.12, 0.12]], [0.38, 0.27, 0.18], plain),
    ...BALLS.map(([right, up, away, reach]) => Solid.ball(onward([x, tall, z], [right, up, away], wide), reach * wide, [0.24, 0.46, 0.16], leaves)),
  ]);
  const lamps = [[2.9, 26.9], [-5, 67.6], [11, 67.6]].flatMap(([x, z]) => [
    block(x, 0, z, 6, both([-0.07, 0.07, 0.07]), [0.36, 0.4, 0.42], plain),
    block(x, 6, z, 0.15, both([-0.1, 0.1, 1]), [0.36, 0.4, 0.42], plain),
  ]);
  const hedge = block(4, 0, 71, 1.1, both([-16, 16, 0.5]), [0.16, 0.34, 0.13], leaves);
  const parked = [car([18.5, 69], [-1, 0], [0.86, 0.87, 0.88]), car([-8.5, 69.4], [1, 0], [0.15, 0.3, 0.55])];
  return [...houses, ...trees, ...lamps, hedge, ...parked.flat()];
}

const plain = (base) => base;

// A wall with windows and a door.
function front(base, [x, y], normal) {
  const [beside, above] = [Math.abs(((x + 4.6) % 2.3) - 1.15), Math.abs(((y - 0.3) % 2.7) - 1.3)];
  const isDoor = x >= 0 && x < 2.3 && y < 2.2;
  if (Math.abs(normal[2]) <= 0.7) {
    return base;
  }
  if (isDoor) {
    return beside < 0.55 ? [0.35, 0.22, 0.16] : base;
  }
  if (beside < 0.5 && above < 0.65 && beside > 0.05 && above > 0.04) {
    return [0.22, 0.28, 0.34];
  }
  return beside < 0.62 && above < 0.77 ? gray(0.92) : base;
}

function tiles(base, [, y]) {
  return y % 0.5 < 0.1 ? base.map((channel) => channel * 0.75) : base;
}

function distance(x, z) {
  return Math.sqrt(x * x + z * z);
}
