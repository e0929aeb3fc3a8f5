// Draws a box on the picture: with mouse, pen or finger, or with keys alone.

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
// The number of steps of a key across the picture.
const STEPS = 64;

export class Drag {
  #canvas;
  #page;
  #corner = null; // where the pointer went down
  #box = null; // what is drawn

  /** `page`: { size() of the frame or null, start() the box a key begins with, propose(box or null), lock(box) }. */
  constructor(canvas, page) {
    this.#canvas = canvas;
    this.#page = page;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#moved(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.drop());
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  drop() {
    this.#corner = null;
    this.#propose(null);
  }

  #down(event) {
    if (!event.isPrimary || event.button !== 0 || this.#page.size() === null) {
      return;
    }
    this.#canvas.setPointerCapture(event.pointerId);
    this.#corner = this.#place(event);
    this.#propose(between(this.#corner, this.#corner));
  }

  #moved(event) {
    if (this.#corner !== null && event.isPrimary) {
      this.#propose(between(this.#corner, this.#place(event)));
    }
  }

  #up(event) {
    if (this.#corner === null || !event.isPrimary) {
      return;
    }
    const box = between(this.#corner, this.#place(event));
    this.#corner = null;
    this.#lock(box);
  }

  #key(event) {
    const size = this.#page.size();
    if (size === null || event.ctrlKey || event.metaKey) {
      return;
    }
    if (ARROWS[event.key] !== undefined) {
      event.preventDefault();
      this.#propose(this.#box === null ? inside(this.#page.start(), size) : changed(this.#box, event, size));
    } else if (event.key === "Enter") {
      event.preventDefault();
      this.#box === null ? this.#propose(inside(this.#page.start(), size)) : this.#lock(this.#box);
    } else if (event.key === "Escape") {
      this.drop();
    }
  }

  #lock(box) {
    this.#page.lock(box);
    this.#propose(null);
  }

  #propose(box) {
    this.#box = box;
    this.#page.propose(box);
  }

  // The edge between pixels that is nearest to the pointer.
  #place({ clientX, clientY }) {
    const { left, top, width, height } = this.#canvas.getBoundingClientRect();
    const size = this.#page.size();
    return {
      x: clamp(Math.round(((clientX - left) / width) * size.width), 0, size.width),
      y: clamp(Math.round(((clientY - top) / height) * size.height), 0, size.height),
    };
  }
}

function between(a, b) {
  return { x: Math.min(a.x, b.x), y: Math.min(a.y, b.y), width: Math.abs(a.x - b.x), height: Math.abs(a.y - b.y) };
}

function changed(box, { key, shiftKey, altKey }, size) {
  const [right, down] = ARROWS[key].map((way) => way * (altKey ? 1 : Math.max(Math.round(size.width / STEPS), 1)));
  if (shiftKey) {
    return inside({ ...box, width: box.width + right, height: box.height + down }, size);
  }
  return inside({ ...box, x: box.x + right, y: box.y + down }, size);
}

function inside(box, size) {
  const [width, height] = [clamp(box.width, 1, size.width), clamp(box.height, 1, size.height)];
  return { x: clamp(box.x, 0, size.width - width), y: clamp(box.y, 0, size.height - height), width, height };
}
