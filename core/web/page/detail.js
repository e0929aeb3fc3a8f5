// The visible part of the frame at full resolution, for an enlarged view in which the frame's JPEG is too coarse.

const MAX_SIDE = 640; // pixels of a part that host-sim gives
const REST_MS = 120; // the user has stopped moving, and the frame stays

export class Detail {
  #load;
  #came;
  #wanted = null; // the number of a frame and its part
  #timer = null;
  #here = null; // { number, part, image }

  /** `load(number, part)` fetches a frame's part { x, y, width, height } (whole pixels). Then `came()` is called. */
  constructor(load, came) {
    [this.#load, this.#came] = [load, came];
  }

  /** Requests the visible part `seen` of a frame once the view rests, if neither side of it exceeds `MAX_SIDE`. */
  want(number, seen, size) {
    const part = around(seen, size);
    const key = `${number} ${Object.values(part)}`;
    if (key === this.#wanted) {
      return;
    }
    this.#wanted = key;
    clearTimeout(this.#timer);
    if (part.width <= MAX_SIDE && part.height <= MAX_SIDE) {
      this.#timer = setTimeout(() => this.#fetch(key, number, part), REST_MS);
    }
  }

  /** Draws the loaded part of frame `number`, if any; `placed(box)` converts a box to canvas pixels. */
  draw(context, number, placed) {
    if (this.#here?.number === number) {
      context.imageSmoothingEnabled = false;
      context.drawImage(this.#here.image, ...placed(this.#here.part));
    }
  }

  async #fetch(key, number, part) {
    const image = await this.#load(number, part).catch(() => null);
    if (image !== null && key === this.#wanted) {
      this.#here = { number, part, image };
      this.#came();
    }
  }
}

function around({ x, y, width, height }, size) {
  const [left, top] = [Math.floor(x), Math.floor(y)];
  return { x: left, y: top, width: Math.min(Math.ceil(x + width), size.width) - left, height: Math.min(Math.ceil(y + height), size.height) - top };
}
