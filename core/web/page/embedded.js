// Frames that are in the page itself, which host-sim has made: nothing follows there.

import { byId } from "./dom.js";
import { targetOf } from "./edits.js";

export class Embedded {
  follows = false;
  #numbers;
  #pictures;

  /** What there is to see. */
  async open() {
    const { frames, ...source } = JSON.parse(byId("data").textContent);
    this.#pictures = new Map(frames);
    this.#numbers = frames.map(([number]) => number);
    return { ...source, targets: source.targets.map(targetOf) };
  }

  /** The frame that comes so many frames later, or earlier. Of a frame that is left out, the nearest is meant. */
  step(number, by) {
    const far = (place) => Math.abs(this.#numbers[place] - number);
    const place = this.#numbers.reduce((best, _, other) => (far(other) < far(best) ? other : best), 0);
    return this.#numbers[Math.min(Math.max(place + by, 0), this.#numbers.length - 1)];
  }

  /** The picture of a frame. */
  async picture(number) {
    const image = new Image();
    image.src = `data:image/jpeg;base64,${this.#pictures.get(number)}`;
    await image.decode();
    return image;
  }
}
