// The built-in recording, pixel by pixel that of host-sim: host-sim/recordings/src/synthetic.rs describes its scenes.
// It is generated, because its noise makes it 2 MB however it is packed.

export const BUILT_IN = { name: "synthetic", width: 160, height: 120, length: 240, rate: 25, box: { x: 36, y: 24, width: 24, height: 28 } };

// The number of units in a pixel: positions are counted in sixteenths.
const PIXEL = 16;
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
  const { width, height } = BUILT_IN;
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
    pixels[at] = Math.min(Math.max(lit + noise(random.next()), 0), 255);
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

// 256x256 gray levels: random ones `coarse` pixels apart, with as many again `fine` pixels apart, and what lies between
// them blended.
function texture(seed, coarse, fine, darkest, brightest) {
  const random = new Random(seed);
  const grid = () => Uint8Array.from({ length: 65536 }, () => random.next());
  const [first, second] = [grid(), grid()];
  const at = (levels, place, cell) => sample(levels, ((place & 255) * PIXEL) / cell, ((place >> 8) * PIXEL) / cell);
  return Uint8Array.from({ length: 65536 }, (_, place) => {
    const average = (at(first, place, coarse) + at(second, place, fine)) >> 1;
    return darkest + (((brightest - darkest) * average) >> 16);
  });
}

// Blends the four pixels around the position, in 256ths of a gray level. It is called for every pixel, so it makes no
// arrays.
function sample(levels, x, y) {
  const column = (x >> 4) & 255;
  const next = (column + 1) & 255;
  const row = ((y >> 4) & 255) << 8;
  const below = (row + 256) & 65535;
  const right = x & 15;
  const low = y & 15;
  const upper = levels[row | column] * (PIXEL - right) + levels[row | next] * right;
  const lower = levels[below | column] * (PIXEL - right) + levels[below | next] * right;
  return upper * (PIXEL - low) + lower * low;
}

// Noise, nearly normal with a standard deviation of 2.3: the sum of four uniform bytes, less its mean, over 64.
function noise(bits) {
  return ((bits & 255) + ((bits >> 8) & 255) + ((bits >> 16) & 255) + (bits >>> 24) - 510 + 32) >> 6;
}

// SplitMix64. `next` returns the low 32 bits of its numbers. JavaScript multiplies 32 bits at most, so 64 bits are kept
// in two halves.
class Random {
  #stateHigh = 0;
  #stateLow;
  #high = 0;
  #low = 0;

  constructor(seed) {
    this.#stateLow = seed >>> 0;
  }

  next() {
    const sum = this.#stateLow + 0x7f4a7c15;
    this.#stateLow = sum >>> 0;
    this.#stateHigh = (this.#stateHigh + 0x9e3779b9 + (sum > this.#stateLow ? 1 : 0)) >>> 0;
    this.#high = this.#stateHigh;
    this.#low = this.#stateLow;
    this.#mix(30, 0xbf58476d, 0x1ce4e5b9);
    this.#mix(27, 0x94d049bb, 0x133111eb);
    return (this.#low ^ ((this.#low >>> 31) | (this.#high << 1))) >>> 0;
  }

  // x = (x ^ x >> by) * factor
  #mix(by, factorHigh, factorLow) {
    const high = (this.#high ^ (this.#high >>> by)) >>> 0;
    const low = (this.#low ^ ((this.#low >>> by) | (this.#high << (32 - by)))) >>> 0;
    this.#high = (upperHalf(low, factorLow) + Math.imul(high, factorLow) + Math.imul(low, factorHigh)) >>> 0;
    this.#low = Math.imul(low, factorLow) >>> 0;
  }
}

// The high 32 bits of the product of two numbers of 32 bits.
function upperHalf(a, b) {
  const first = (a >>> 16) * (b & 65535) + (((a & 65535) * (b & 65535)) >>> 16);
  const second = (a & 65535) * (b >>> 16) + (first % 65536);
  return (a >>> 16) * (b >>> 16) + Math.floor(first / 65536) + Math.floor(second / 65536);
}
