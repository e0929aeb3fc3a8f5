// SplitMix64. `next` returns the low 32 bits of its numbers. JavaScript multiplies 32 bits at most, so 64 bits are kept
// in two halves.
export class Random {
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

  /** Nearly normal with a standard deviation of 2.3: the sum of four uniform bytes, less its mean, over 64. */
  noise() {
    const bits = this.next();
    return ((bits & 255) + ((bits >> 8) & 255) + ((bits >> 16) & 255) + (bits >>> 24) - 510 + 32) >> 6;
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
