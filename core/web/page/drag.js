// Lets the user draw, move and resize a box on the image, by mouse, pen or finger, or by keys.

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
// Number of presses of an arrow key that move a box by about the width of the image.
const STEPS = 64;
// Distance in CSS pixels up to which a pointer grips an edge, larger for fingers.
const REACH = { touch: 26, pen: 16 };
const MOUSE_REACH = 10;
// Longest movement of a pressed pointer, in CSS pixels, that is still a click and not a drag.
const MIN_DRAG = 3;

export class Drag {
  #canvas;
  #pageNow;
  #from = null; // where the pointer went down
  #isMoved = false;
  #grip = null; // what it took hold of
  #box = null; // what is drawn

  /**
   * `pageNow()` returns an object with: size(), the frame's size or null; view(), the frame's visible part; start(), the grip whose box the Enter
   * key proposes, with the id null if the box is a new one; grip(point, reach), which returns a grip { box, held }, the box at the point and its gripped part (see
   * `gripOf`), or null; propose(box or null, grip or null), which shows the box; lock(box, grip or null), which returns
   * false to keep the box drawn; click(point); `isLine`, true if a line is drawn instead of a box: from the corner x, y,
   * with a width and height that may be negative or 0.
   */
  constructor(canvas, pageNow) {
    [this.#canvas, this.#pageNow] = [canvas, pageNow];
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#moved(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.drop());
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  get #page() {
    return this.#pageNow();
  }

  get #fit() {
    return this.#page.isLine ? clipped : inside;
  }

  /** True while a mouse, pen or finger draws. */
  get isPointing() {
    return this.#from !== null;
  }

  drop() {
    [this.#from, this.#grip] = [null, null];
    this.#propose(null);
  }

  #down(event) {
    if (!event.isPrimary || event.button !== 0 || this.#page.size() === null) {
      return;
    }
    // Capturing the pointer throws if it is not active any more, such as a finger that was lifted.
    try {
      this.#canvas.setPointerCapture(event.pointerId);
    } catch {}
    this.drop();
    this.#from = this.#place(event);
    this.#isMoved = false;
    this.#grip = this.#gripAt(event);
    this.#propose(this.#dragged(this.#from));
  }

  #moved(event) {
    if (this.#from === null) {
      this.#canvas.style.cursor = cursorOf(this.#gripAt(event)?.held);
    } else if (event.isPrimary) {
      const to = this.#place(event);
      this.#isMoved ||= Math.hypot(to.x - this.#from.x, to.y - this.#from.y) > MIN_DRAG * this.#unit();
      if (this.#isMoved) {
        this.#propose(this.#dragged(to));
      }
    }
  }

  #up(event) {
    if (this.#from === null || !event.isPrimary) {
      return;
    }
    const [from, box] = [this.#from, this.#dragged(this.#place(event))];
    this.#from = null;
    if (this.#isMoved) {
      this.#lock(box);
    } else {
      this.drop();
      this.#page.click(from);
    }
  }

  #key(event) {
    const size = this.#page.size();
    if (size === null || event.ctrlKey || event.metaKey) {
      return;
    }
    if (ARROWS[event.key] !== undefined && this.#box !== null) {
      event.preventDefault();
      this.#propose(this.#fit(changed(this.#box, event, size), size));
    } else if (event.key === "Enter") {
      event.preventDefault();
      this.#box === null ? this.#begin(this.#page.start(), size) : this.#lock(this.#box);
    }
  }

  #begin(grip, size) {
    this.#grip = grip.id === null ? null : grip;
    this.#propose(this.#fit(grip.box, size));
  }

  #lock(box) {
    const grip = this.#grip;
    [this.#from, this.#grip] = [null, null];
    this.#propose(this.#page.lock(box, grip) === false ? box : null);
  }

  #propose(box) {
    this.#box = box;
    this.#page.propose(box, this.#grip);
  }

  #dragged(to) {
    const size = this.#page.size();
    if (this.#grip !== null) {
      return pulled(this.#grip, this.#from, to, size);
    }
    const { x, y } = this.#from;
    return this.#page.isLine ? clipped({ x, y, width: to.x - x, height: to.y - y }, size) : between(this.#from, to, size);
  }

  #gripAt(event) {
    return this.#page.size() === null ? null : this.#page.grip(this.#place(event), (REACH[event.pointerType] ?? MOUSE_REACH) * this.#unit());
  }

  // Returns the number of frame pixels per CSS pixel.
  #unit() {
    return this.#page.view().width / this.#canvas.getBoundingClientRect().width;
  }

  #place({ clientX, clientY }) {
    const { left, top } = this.#canvas.getBoundingClientRect();
    const { x, y } = this.#page.view();
    return { x: x + (clientX - left) * this.#unit(), y: y + (clientY - top) * this.#unit() };
  }
}

/** Returns the part of a box at a point as [across, down], each -1 or 1 at an edge and 0 inside; null if outside. */
export function gripOf(box, { x, y }, reach) {
  const side = (value, from, size) => {
    // At least the middle half of a box's width and height counts as inside, where a drag moves the box.
    const inner = Math.min(reach, size / 4);
    if (value < from - reach || value > from + size + reach) {
      return null;
    }
    return value < from + inner ? -1 : value > from + size - inner ? 1 : 0;
  };
  const found = [side(x, box.x, box.width), side(y, box.y, box.height)];
  return found.includes(null) ? null : found;
}

function cursorOf(held) {
  if (!held) {
    return "";
  }
  const [across, down] = held;
  if (across === 0 && down === 0) {
    return "move";
  }
  return down === 0 ? "ew-resize" : across === 0 ? "ns-resize" : across === down ? "nwse-resize" : "nesw-resize";
}

const edge = (value, most) => clamp(Math.round(value), 0, most);

// Rounds the ends of a line to whole pixels, and clamps them to the frame.
function clipped({ x, y, width, height }, size) {
  const [left, top] = [edge(x, size.width), edge(y, size.height)];
  return { x: left, y: top, width: edge(x + width, size.width) - left, height: edge(y + height, size.height) - top };
}

// Returns the box between two corners, rounded to whole pixels and clamped to the frame.
function between(a, b, size) {
  const [left, right] = [edge(a.x, size.width), edge(b.x, size.width)].sort((one, other) => one - other);
  const [top, bottom] = [edge(a.y, size.height), edge(b.y, size.height)].sort((one, other) => one - other);
  return { x: left, y: top, width: right - left, height: bottom - top };
}

// Returns the box after its gripped part was dragged from `from` to `to`.
function pulled({ box, held: [across, down] }, from, to, size) {
  const [right, below] = [Math.round(to.x - from.x), Math.round(to.y - from.y)];
  if (across === 0 && down === 0) {
    return inside({ ...box, x: box.x + right, y: box.y + below }, size);
  }
  const ends = (start, length, side, by) => [start + (side < 0 ? by : 0), start + length + (side > 0 ? by : 0)];
  const [left, rightmost] = ends(box.x, box.width, across, right);
  const [top, bottom] = ends(box.y, box.height, down, below);
  return between({ x: left, y: top }, { x: rightmost, y: bottom }, size);
}

function changed(box, { key, shiftKey, altKey }, size) {
  const [right, down] = ARROWS[key].map((way) => way * (altKey ? 1 : Math.max(Math.round(size.width / STEPS), 1)));
  return shiftKey ? { ...box, width: box.width + right, height: box.height + down } : { ...box, x: box.x + right, y: box.y + down };
}

/** Shifts a box into a frame of `size`, and shrinks it if it is larger. */
export function inside(box, size) {
  const [width, height] = [clamp(box.width, 1, size.width), clamp(box.height, 1, size.height)];
  return { x: clamp(box.x, 0, size.width - width), y: clamp(box.y, 0, size.height - height), width, height };
}
