// Rays that meet balls and blocks in sunlight, as in host-sim/recordings/src/rays.rs: the same numbers in the same order, so that each pixel is the
// same.

// Where it is seen.
const SUN = [-0.48, 0.77, -0.42];
const HAZE = [0.78, 0.84, 0.9];

/** A color at this distance, in the sun or in the shade. */
export function shown(color, normal, far, isLit) {
  const sun = isLit ? 0.75 * Math.max(dot(normal, SUN), 0) : 0;
  const light = 0.42 + 0.1 * normal[1] + sun;
  return mixed([color[0] * light, color[1] * light, color[2] * light], HAZE, Math.min(far / 420, 1));
}

/** The color in levels from 0 to 255, rounded down. */
export function levels(color) {
  return [level(color[0]), level(color[1]), level(color[2])];
}

function level(channel) {
  return Math.max(0, Math.min(255, Math.trunc(channel * 255)));
}

/** A ball, or a block with four sides that may lean: at `origin`, turned to `heading`. */
export class Solid {
  #base;
  #paint;
  #x;
  #y;
  #z;
  #c;
  #s;
  #reach;
  #square;
  #faces; // of each its outward normal, and how far it is from the origin; none of a ball

  constructor(origin, heading, reach, faces, base, paint) {
    [this.#x, this.#y, this.#z] = this.origin = origin;
    [this.#c, this.#s] = heading;
    [this.#reach, this.#square, this.#faces] = [reach, reach * reach, Float64Array.from(faces.flat())];
    [this.#base, this.#paint] = [base, paint];
  }

  static ball(origin, reach, base, paint) {
    return new Solid(origin, [1, 0], reach, [], base, paint);
  }

  /** `bottom` and `top`: its back end, front end and half width there. `paint` gives the color at a place with a normal. */
  static block(origin, heading, [low, high], [bottom, top], base, paint) {
    const tall = high - low;
    const face = (normal, at) => [...unit(normal), dot(unit(normal), at)];
    const faces = [
      face([0, 1, 0], [0, high, 0]),
      face([0, -1, 0], [0, low, 0]),
      face([-tall, top[0] - bottom[0], 0], [bottom[0], low, 0]),
      face([tall, bottom[1] - top[1], 0], [bottom[1], low, 0]),
      face([0, bottom[2] - top[2], tall], [0, low, bottom[2]]),
      face([0, bottom[2] - top[2], -tall], [0, low, -bottom[2]]),
    ];
    const longest = (ends) => Math.max(Math.abs(ends[0]), Math.abs(ends[1]));
    const corner = [Math.max(longest(bottom), longest(top)), Math.max(Math.abs(low), Math.abs(high)), Math.max(bottom[2], top[2])];
    return new Solid(origin, heading, Math.sqrt(dot(corner, corner)), faces, base, paint);
  }

  /** How far it is; `Infinity` if the ray passes. It is called for every ray and solid, so it makes no arrays. */
  far(from, along) {
    const [right, up, away] = [along[0], along[1], along[2]];
    const [x, y, z] = [from[0] - this.#x, from[1] - this.#y, from[2] - this.#z];
    const middle = -(x * right + y * up + z * away);
    const apart = x * x + y * y + z * z - this.#square;
    const within = middle * middle - apart;
    if (within < 0 || (middle < 0 && apart > 0)) {
      return Infinity;
    }
    if (this.#faces.length === 0) {
      const enter = middle - Math.sqrt(within);
      return enter <= 0 || enter >= middle ? Infinity : enter;
    }
    return this.#farOfBlock(x * this.#c + z * this.#s, y, z * this.#c - x * this.#s, right * this.#c + away * this.#s, up, away * this.#c - right * this.#s);
  }

  #farOfBlock(x, y, z, right, up, away) {
    const faces = this.#faces;
    let enter = 0;
    let leave = Infinity;
    for (let at = 0; at < faces.length; at += 4) {
      const toward = faces[at] * right + faces[at + 1] * up + faces[at + 2] * away;
      const beyond = faces[at] * x + faces[at + 1] * y + faces[at + 2] * z - faces[at + 3];
      if (toward < 0) {
        enter = Math.max(enter, beyond / -toward);
      } else if (toward > 0) {
        leave = Math.min(leave, -beyond / toward);
      } else if (beyond > 0) {
        return Infinity;
      }
    }
    return enter <= 0 || enter >= leave ? Infinity : enter;
  }

  /** Whether it may be met by this ray, or by another that stays so near to it. */
  mayMeet(from, along, apart) {
    const [x, y, z] = [from[0] - this.#x, from[1] - this.#y, from[2] - this.#z];
    const middle = x * along[0] + y * along[1] + z * along[2];
    const reach = this.#reach + apart;
    return x * x + y * y + z * z - middle * middle < reach * reach;
  }

  /** Its color and its normal where the ray meets it. */
  surface(start, way, far) {
    const [from, along] = [this.#inward(minus(start, this.origin)), this.#inward(way)];
    const at = onward(from, along, far);
    const normal = this.#faces.length === 0 ? at.map((side) => side / this.#reach) : this.#normal(from, along, far);
    const color = this.#paint(this.#base, at, normal);
    return { color, normal: [normal[0] * this.#c - normal[2] * this.#s, normal[1], normal[0] * this.#s + normal[2] * this.#c] };
  }

  #inward([x, y, z]) {
    return [x * this.#c + z * this.#s, y, z * this.#c - x * this.#s];
  }

  // Of the first face that is so far.
  #normal(from, along, far) {
    for (let at = 0; ; at += 4) {
      const normal = this.#faces.subarray(at, at + 3);
      const toward = dot(normal, along);
      if (toward < 0 && (dot(normal, from) - this.#faces[at + 3]) / -toward === far) {
        return normal;
      }
    }
  }
}

/** The first of them that is hit: { far, color, normal }; null if none is. */
export function nearest(solids, from, along) {
  let first = null;
  let far = Infinity;
  for (let at = 0; at < solids.length; at++) {
    const its = solids[at].far(from, along);
    if (its < far) {
      [first, far] = [solids[at], its];
    }
  }
  return first === null ? null : { far, ...first.surface(from, along, far) };
}

/** What stands between places and the sun. */
export class Shade {
  #solids;
  #cells = new Map(); // of each cube of 2 meters the solids that may be between it and the sun

  constructor(solids) {
    this.#solids = solids;
  }

  isAt(at) {
    const [x, y, z] = [Math.floor(at[0] / 2), Math.floor(at[1] / 2), Math.floor(at[2] / 2)];
    const key = (x * 1024 + y) * 1024 + z;
    let solids = this.#cells.get(key);
    if (solids === undefined) {
      const middle = [2 * x + 1, 2 * y + 1, 2 * z + 1];
      solids = this.#solids.filter((solid) => solid.mayMeet(middle, SUN, 1.8));
      this.#cells.set(key, solids);
    }
    return isShaded(solids, at);
  }
}

/** Whether one of them is between a place and the sun. */
export function isShaded(solids, at) {
  for (let solid = 0; solid < solids.length; solid++) {
    if (solids[solid].far(at, SUN) < Infinity) {
      return true;
    }
  }
  return false;
}

export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function minus(a, b) {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

export function onward(from, along, far) {
  return [from[0] + along[0] * far, from[1] + along[1] * far, from[2] + along[2] * far];
}

export function unit(of) {
  const length = Math.sqrt(dot(of, of));
  return [of[0] / length, of[1] / length, of[2] / length];
}

export function mixed(a, b, part) {
  return onward(a, minus(b, a), part);
}
