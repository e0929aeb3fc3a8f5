// The visible part of the frame: zoomed and moved by wheel, fingers, keys and the middle mouse button.

const STEP = Math.SQRT2; // of a key or a button
const WHEEL_STEP = 300; // pixels of a wheel that enlarge e times
const PINCH_STEP = 100; // the same for a touchpad, which reports a pinch as a wheel with ctrl
const LARGEST_PIXEL = 64; // pixels of the page for one of the frame

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);

export class Viewport {
  #zoom = 1;
  #x = 0;
  #y = 0;
  #canvas;
  #page;
  #pointers = new Map(); // places of fingers, and of a mouse with its middle button, by their number

  /** `page` has size(), the frame's size or null; changed(), for a new view; pinched(), for a second finger's touch. */
  constructor(canvas, page) {
    [this.#canvas, this.#page] = [canvas, page];
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#moved(event));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, ({ pointerId }) => this.#pointers.delete(pointerId));
    }
  }

  get zoom() {
    return this.#zoom;
  }

  /** The visible part { x, y, width, height } in pixels of the frame. */
  get seen() {
    const { width, height } = this.#page.size();
    return { x: this.#x, y: this.#y, width: width / this.#zoom, height: height / this.#zoom };
  }

  larger() {
    this.#enlarge(STEP);
  }

  smaller() {
    this.#enlarge(1 / STEP);
  }

  whole() {
    [this.#zoom, this.#x, this.#y] = [1, 0, 0];
    this.#page.changed();
  }

  /** Moves the view so that the centre of a box is visible. */
  show({ x, y, width, height }) {
    const [across, down, { x: left, y: top, width: wide, height: high }] = [x + width / 2, y + height / 2, this.seen];
    if (across < left || across > left + wide || down < top || down > top + high) {
      this.#move(across - wide / 2, down - high / 2);
    }
  }

  /** Zooms by the keys `+`, `-` and `0` (whole frame). Returns false for any other key. */
  key({ key }) {
    const act = { "+": () => this.larger(), "-": () => this.smaller(), 0: () => this.whole() }[key];
    act?.();
    return act !== undefined;
  }

  // Zooms by a factor, around the point `at` of the frame, which stays in place on the page.
  #enlarge(by, at = this.#middle()) {
    if (this.#page.size() === null) {
      return;
    }
    const before = this.seen;
    const most = Math.max((LARGEST_PIXEL * this.#page.size().width) / this.#canvas.clientWidth, 1);
    this.#zoom = clamp(this.#zoom * by, 1, most);
    const { width, height } = this.seen;
    this.#move(at.x - ((at.x - before.x) * width) / before.width, at.y - ((at.y - before.y) * height) / before.height);
  }

  #middle() {
    const { x, y, width, height } = this.seen;
    return { x: x + width / 2, y: y + height / 2 };
  }

  #move(x, y) {
    const [{ width, height }, size] = [this.seen, this.#page.size()];
    [this.#x, this.#y] = [clamp(x, 0, size.width - width), clamp(y, 0, size.height - height)];
    this.#page.changed();
  }

  // Zooms by the wheel; with shift, moves the view sideways. If the whole frame is visible, a turn down without ctrl
  // scrolls the page instead.
  #wheel(event) {
    const { deltaX, deltaY, ctrlKey, shiftKey } = event;
    if (this.#page.size() === null || (this.#zoom === 1 && deltaY >= 0 && !ctrlKey)) {
      return;
    }
    event.preventDefault();
    if (shiftKey) {
      this.#shift(deltaX + deltaY, 0);
    } else {
      this.#enlarge(Math.exp(-deltaY / (ctrlKey ? PINCH_STEP : WHEEL_STEP)), this.#place(event));
    }
  }

  #shift(right, down) {
    this.#move(this.#x + right * this.#unit(), this.#y + down * this.#unit());
  }

  #down(event) {
    const { pointerId, pointerType, button, clientX, clientY } = event;
    if (this.#page.size() === null || (pointerType !== "touch" && button !== 1)) {
      return;
    }
    event.preventDefault();
    this.#pointers.set(pointerId, { clientX, clientY });
    if (button === 1) {
      this.#canvas.setPointerCapture(pointerId);
    }
    if (this.#pointers.size === 2) {
      this.#page.pinched();
    }
  }

  #moved({ pointerId, pointerType, clientX, clientY }) {
    const before = [...this.#pointers.values()];
    if (!this.#pointers.has(pointerId) || (pointerType === "touch" && before.length !== 2)) {
      return;
    }
    this.#pointers.set(pointerId, { clientX, clientY });
    const [from, to] = [between(before), between([...this.#pointers.values()])];
    this.#shift(from.clientX - to.clientX, from.clientY - to.clientY);
    if (from.wide > 0 && to.wide > 0) {
      this.#enlarge(to.wide / from.wide, this.#place(to));
    }
  }

  // Returns the number of frame pixels per CSS pixel.
  #unit() {
    return this.seen.width / this.#canvas.getBoundingClientRect().width;
  }

  #place({ clientX, clientY }) {
    const { left, top } = this.#canvas.getBoundingClientRect();
    return { x: this.#x + (clientX - left) * this.#unit(), y: this.#y + (clientY - top) * this.#unit() };
  }
}

// Returns the centre of one or two pointers, and their distance.
function between(pointers) {
  const [one, other] = [pointers[0], pointers.at(-1)];
  return {
    clientX: (one.clientX + other.clientX) / 2,
    clientY: (one.clientY + other.clientY) / 2,
    wide: Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY),
  };
}
