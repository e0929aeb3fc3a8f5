// The recording `synthetic`, pixel by pixel that of host-sim: host-sim/recordings/src/synthetic.rs describes its scenes.

import { Random } from "../page/random.js";
import { PIXEL, sample, texture } from "../page/texture.js";

export const SYNTHETIC = { width: 160, height: 120, length: 240 };

const TARGET = [24 * PIXEL, 28 * PIXEL];
const POST = 36 * PIXEL;

// Pairs of frame and value. Between two of them the value goes smoothly from one to the other.
const TARGET_X = [[0, 36], [32, 84], [66, 60], [134, 64], [160, 8], [184, -28], [190, -28], [224, 56], [239, 66]];
const TARGET_Y = [[0, 24], [32, 52], [66, 66], [134, 62], [184, 46], [190, 46], [239, 54]];
const POST_X = [[48, 161], [75, 85], [100, 76], [110, 76], [134, 88], [154, 161]];
const PAN_X = [[0, 0], [120, 70], [239, 10]];
const PAN_Y = [[0, 12], [80, 26], [160, 0], [239, 20]];
const LIGHT = [[0, 256], [80, 200], [150, 290], [210, 290], [239, 250]];

let textures = null;

/** The gray pixels of frame `index`, counted from 0. */
export function syntheticFrame(index) {
  textures ??= { target: texture(1, 8, 4, 10, 225), background: texture(2, 16, 8, 40, 200), post: texture(3, 32, 4, 20, 120) };
  const { width, height } = SYNTHETIC;
  const [left, top] = [between(TARGET_X, index, 1) * PIXEL, between(TARGET_Y, index, 1) * PIXEL];
  const [post, panX, panY] = [POST_X, PAN_X, PAN_Y].map((keys) => between(keys, index, PIXEL));
  const light = between(LIGHT, index, 1);
  // A pixel shows the scene at its middle.
  const seen = (x, y) => {
    const dx = x - left + PIXEL / 2;
    const dy = y - top + PIXEL / 2;
    const behind = x - post + PIXEL / 2;
    if (behind >= 0 && behind < POST) {
      return sample(textures.post, behind, y);
    }
    const isTarget = dx >= 0 && dx < TARGET[0] && dy >= 0 && dy < TARGET[1];
    return isTarget ? sample(textures.target, dx, dy) : sample(textures.background, x + panX, y + panY);
  };
  const random = new Random(0x5eed0000 + index);
  const pixels = new Uint8Array(width * height);
  for (let at = 0; at < pixels.length; at++) {
    const lit = (seen((at % width) * PIXEL, Math.floor(at / width) * PIXEL) * light) >> 16;
    pixels[at] = Math.min(Math.max(lit + random.noise(), 0), 255);
  }
  return pixels;
}

function between(keys, frame, unit) {
  const next = Math.max(keys.filter(([key]) => key <= frame).length, 1);
  const [start, from] = keys[next - 1];
  if (next === keys.length) {
    return from * unit;
  }
  const [end, to] = keys[next];
  const t = Math.trunc((Math.max(frame - start, 0) * 256) / (end - start));
  const smooth = (t * t * (3 * 256 - 2 * t)) >> 8; // of 65536
  return from * unit + (((to - from) * unit * smooth) >> 16);
}
