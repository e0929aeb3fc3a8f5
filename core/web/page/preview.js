// The preview above the timeline: a small image of the frame under the mouse.

import { htmlNode } from "./dom.js";
import { placeOf } from "./events.js";

const WIDTH = 176; // pixels of the page

export class Preview {
  #box = htmlNode("div", { class: "preview", "aria-hidden": "true" });
  #canvas = htmlNode("canvas", {});
  #words = htmlNode("span", {});
  #place;

  constructor(place) {
    this.#place = place;
    this.#box.append(this.#canvas, this.#words);
    this.#box.hidden = true;
    place.append(this.#box);
  }

  /** Draws the preview of frame `number` near `x` (pixels); null hides it. Without `image`, the former one stays. */
  draw({ number, x, image, size, timeOf }) {
    this.#box.hidden = number === null;
    if (number === null) {
      return;
    }
    const most = Math.max(this.#place.clientWidth - WIDTH, 0);
    this.#box.style.left = `${Math.min(Math.max(x - WIDTH / 2, 0), most)}px`;
    this.#words.textContent = placeOf(number, timeOf);
    if (image !== undefined) {
      Object.assign(this.#canvas, { width: WIDTH, height: Math.round((WIDTH * size.height) / size.width) });
      this.#canvas.getContext("2d").drawImage(image, 0, 0, this.#canvas.width, this.#canvas.height);
    }
  }
}
