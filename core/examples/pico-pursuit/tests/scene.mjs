// What stands in front of the camera: a wall with a target on it, and the head, whose servos turn by the pulses that they get.

import { HEIGHT, WIDTH } from "./camera.mjs";

/** Focal length of the lens in pixels, as the firmware assumes it. */
const FOCAL_LENGTH = 160;
/** Half the side of the target in pixels. */
const HALF = 12;
/** Distance of the target's shades in pixels. */
const CELL = 6;

/** A hobby servo, which turns at 60 degrees in 0.2 seconds to where its pulse says. */
export class Servo {
  constructor() {
    this.radians = this.goal = 0;
    this.pulses = [];
    this.seconds = 0;
  }

  /** `start` and `end` of a pulse in seconds. 900 to 2100 microseconds are -1.05 to 1.05 radians. */
  pulse(start, end) {
    this.turn(end);
    const microseconds = (end - start) * 1e6;
    this.pulses.push({ start, microseconds });
    this.goal = ((microseconds - 900) / 1200) * 2.1 - 1.05;
  }

  turn(seconds) {
    const most = (Math.PI / 3 / 0.2) * (seconds - this.seconds);
    this.radians += Math.max(-most, Math.min(most, this.goal - this.radians));
    this.seconds = seconds;
    return this.radians;
  }
}

/** Where a target is that swings by 60 pixels to the sides and by 25 up and down, larger and larger at first. */
export function swing(seconds) {
  const grown = Math.min(1, seconds / 2);
  return { x: 60 * Math.sin(0.9 * seconds) * grown, y: 25 * Math.sin(0.6 * seconds) * grown };
}

export class Scene {
  /** `target(seconds)` is where the target's centre is on the wall, {x, y} in pixels, or null if it is hidden. */
  constructor(target, now) {
    this.target = target;
    this.now = now;
    this.pan = new Servo();
    this.tilt = new Servo();
  }

  /** Where the optical axis meets the wall. */
  axis(seconds) {
    return { x: this.pan.turn(seconds) * FOCAL_LENGTH, y: -this.tilt.turn(seconds) * FOCAL_LENGTH };
  }

  /** The target's distance from the centre of the picture, {x, y} in pixels, or null if it is hidden. */
  error(seconds = this.now()) {
    const [target, axis] = [this.target(seconds), this.axis(seconds)];
    return target && { x: target.x - axis.x, y: target.y - axis.y };
  }

  row(y) {
    const seconds = this.now();
    const [target, axis] = [this.target(seconds), this.axis(seconds)];
    const wallY = y + 0.5 - HEIGHT / 2 + axis.y;
    return Uint8Array.from({ length: WIDTH }, (_, x) => {
      const wallX = x + 0.5 - WIDTH / 2 + axis.x;
      if (target === null) return wall(wallX, wallY);
      const [across, down] = [wallX - target.x, wallY - target.y];
      return Math.abs(across) < HALF && Math.abs(down) < HALF ? pattern(across, down) : wall(wallX, wallY);
    });
  }
}

/** Scattered shades, CELL pixels apart, with smooth passages between them, because a lens blurs. */
function pattern(x, y) {
  const [column, line] = [Math.floor(x / CELL), Math.floor(y / CELL)];
  const [right, down] = [x / CELL - column, y / CELL - line];
  const above = shade(column, line) * (1 - right) + shade(column + 1, line) * right;
  const below = shade(column, line + 1) * (1 - right) + shade(column + 1, line + 1) * right;
  return Math.round(above * (1 - down) + below * down);
}

function shade(column, line) {
  return 30 + ((Math.imul(column * 31 + line * 57 + 1, 0x9e3779b1) >>> 16) % 200);
}

function wall(x, y) {
  return Math.round(100 + 30 * Math.sin(x / 17) * Math.cos(y / 13));
}
