// The slider over all frames, with the targets' states, marks of events, and the progress of tracking.

import { fitted, htmlNode } from "./dom.js";
import { placeOf } from "./events.js";
import { palette } from "./palette.js";

const WORST_LAST = [undefined, "tracking", "leaving", "uncertain", "lost"];
// Largest number of frames whose states are read in one drawing. A long video takes several drawings.
const BUDGET = 10_000;
const EDGE = 8, MARKS = 11, STRIP = 7, CHOSEN = 13, GAP = 2, BELOW = 6, MIN_HEIGHT = 32;
// Milliseconds after which the playhead leaves the frame to which the user moved it, if that frame cannot be shown.
const PATIENCE_MS = 1000;

/** Divides the frames `first` to `last` into `count` columns of pixels, and finds the worst state in each. */
export class Columns {
  states = [];
  #next = 0;

  constructor(count, first, last) {
    [this.count, this.first, this.last] = [count, first, last];
  }

  frames(column) {
    const all = this.last - this.first + 1;
    const from = Math.floor((column * all) / this.count);
    return [this.first + from, this.first + Math.max(Math.ceil(((column + 1) * all) / this.count) - 1, from)];
  }

  /** Fills each column with the state of its first frame, as a quick preview. */
  sample(states) {
    this.states = Array.from({ length: this.count }, (_, column) => states(this.frames(column)[0]));
    return this;
  }

  /** Recomputes the column that contains a frame. */
  see(frame, states) {
    if (frame >= this.first && frame <= this.last) {
      this.#look(Math.floor(((frame - this.first) * this.count) / (this.last - this.first + 1)), states);
    }
  }

  /** Recomputes the next columns until they contain `budget` frames. Returns the count of recomputed columns. */
  refresh(states, budget) {
    let seen = 0;
    for (; seen < this.count && budget > 0; seen++) {
      budget -= this.#look(this.#next, states);
      this.#next = (this.#next + 1) % this.count;
    }
    return seen;
  }

  #look(column, states) {
    const [from, to] = this.frames(column);
    let worst = 0;
    for (let frame = from; frame <= to; frame++) {
      worst = Math.max(worst, WORST_LAST.indexOf(states(frame)));
    }
    this.states[column] = WORST_LAST[worst];
    return to - from + 1;
  }
}

export class Timeline {
  #page;
  #box = htmlNode("div", {});
  #canvas = htmlNode("canvas", { "aria-hidden": "true" });
  #input = htmlNode("input", { type: "range", step: 1, "aria-label": "Frame" });
  #shown = null; // what the last drawing was of
  #columns = []; // of each strip
  #left = 0; // columns that were not looked at since the last drawing
  #wanted = null; // the frame that the user asked for, until it is shown
  #hasCome = false; // it was shown
  #isDragged = false;
  #hasKeys = true; // the user moves the head by keys
  #drawing = null;

  /** Calls `page.goTo(frame)` when the user moves the head, and `page.hover(frame or null, x in pixels)` if given. */
  constructor(place, page) {
    this.#page = page;
    // The visible canvas lies below a transparent input, which provides keys and accessibility.
    Object.assign(this.#box.style, { position: "relative", touchAction: "pan-y", cursor: "pointer" });
    Object.assign(this.#canvas.style, { display: "block", width: "100%" });
    Object.assign(this.#input.style, { position: "absolute", inset: 0, width: "100%", height: "100%", margin: 0, opacity: 0, pointerEvents: "none" });
    this.#box.append(this.#canvas, this.#input);
    place.append(this.#box);
    this.#listen();
  }

  /**
   * Draws the slider from the `first` to the `last` frame with the head at `frame`. `followed` is the last tracked
   * frame or null. Each target has a strip { color, isChosen, states(frame) }. `marks` are events, see events.js, and
   * `truth` the ranges { known, hidden, lines } of the chosen target, if it is given. `timeOf(frame)` is in seconds.
   */
  draw(shown) {
    this.#shown = shown;
    const { first, last, frame, timeOf, strips } = shown;
    this.#hasCome ||= frame === this.#wanted;
    if (this.#hasCome && !this.#isDragged) {
      this.#wanted = null;
    }
    const head = this.#wanted ?? frame;
    const ofStrips = strips.reduce((sum, { isChosen }) => sum + stripHeight(isChosen) + GAP, 0);
    const height = `${Math.max(MARKS + ofStrips + BELOW, MIN_HEIGHT)}px`;
    if (this.#canvas.style.height !== height) {
      this.#canvas.style.height = height;
    }
    Object.assign(this.#input, { min: first, max: last });
    this.#input.value = head;
    this.#input.setAttribute("aria-valuetext", placeOf(head, timeOf));
    this.#left = Infinity;
    this.#later();
  }

  #listen() {
    this.#input.addEventListener("input", () => this.#want(Number(this.#input.value)));
    for (const change of ["focus", "blur", "keydown"]) {
      this.#input.addEventListener(change, () => {
        this.#hasKeys = true;
        this.#later();
      });
    }
    this.#box.addEventListener("pointerdown", (event) => {
      if (event.isPrimary && event.button === 0 && this.#shown !== null) {
        this.#box.setPointerCapture(event.pointerId);
        this.#isDragged = true;
        this.#want(this.#frameAt(event));
        // Keeps the browser from removing the focus.
        event.preventDefault();
        this.#input.focus({ preventScroll: true });
        this.#hasKeys = false;
      }
    });
    this.#box.addEventListener("pointermove", (event) => {
      if (this.#isDragged && event.isPrimary) {
        this.#want(this.#frameAt(event));
      } else if (event.pointerType === "mouse" && this.#shown !== null) {
        this.#page.hover?.(this.#frameAt(event), event.clientX - this.#box.getBoundingClientRect().left);
      }
    });
    this.#box.addEventListener("pointerleave", () => this.#page.hover?.(null));
    for (const end of ["pointerup", "pointercancel"]) {
      this.#box.addEventListener(end, () => {
        this.#isDragged = false;
        if (this.#shown !== null) {
          this.draw(this.#shown);
        }
        this.#giveUpLater();
      });
    }
    new ResizeObserver(() => this.#later()).observe(this.#canvas);
  }

  #want(frame) {
    if (frame === this.#wanted) {
      return;
    }
    [this.#wanted, this.#hasCome] = [frame, false];
    this.#giveUpLater();
    this.draw(this.#shown);
    this.#page.goTo(frame);
  }

  #giveUpLater() {
    const wanted = this.#wanted;
    setTimeout(() => {
      if (this.#wanted === wanted && !this.#isDragged && this.#shown !== null) {
        this.#wanted = null;
        this.draw(this.#shown);
      }
    }, PATIENCE_MS);
  }

  #frameAt({ clientX }) {
    const { first, last } = this.#shown;
    const { left, width } = this.#box.getBoundingClientRect();
    const frame = first + Math.floor(((clientX - left - EDGE) / (width - 2 * EDGE)) * (last - first + 1));
    return Math.min(Math.max(frame, first), last);
  }

  #later() {
    this.#drawing ??= requestAnimationFrame(() => {
      this.#drawing = null;
      this.#paint();
    });
  }

  #paint() {
    const { width, height } = fitted(this.#canvas);
    if (this.#shown === null || width <= 2 * EDGE) {
      return;
    }
    const context = this.#canvas.getContext("2d");
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    context.clearRect(0, 0, width, height);
    this.#look(Math.round(width - 2 * EDGE));
    const { first, last, followed, marks, frame, truth } = this.#shown;
    const x = (place) => EDGE + ((width - 2 * EDGE) * (place - first)) / (last - first + 1);
    let top = MARKS;
    this.#shown.strips.forEach(({ color, isChosen }, at) => {
      drawStrip(context, this.#columns[at].states, { top, wide: stripHeight(isChosen), width, color });
      if (isChosen && truth) {
        drawTruth(context, truth, x, top);
      }
      top += stripHeight(isChosen) + GAP;
    });
    drawFollowed(context, top + 1, width, followed === null ? EDGE : x(followed + 1));
    marks.forEach((mark) => drawMark(context, x(mark.frame + 0.5), mark.kind));
    drawHead(context, x((this.#wanted ?? frame) + 0.5), height);
    if (this.#hasKeys && this.#input.matches(":focus")) {
      drawFocus(context, width, height);
    }
    if (this.#left > 0) {
      this.#later();
    }
  }

  // In each drawing, recomputes the pixel columns of the shown and of the last tracked frame, and some others in turn.
  #look(count) {
    const { first, last, frame, followed, strips } = this.#shown;
    const isOther = (one) => one?.count !== count || one.first !== first || one.last !== last;
    this.#columns = strips.map(({ states }, at) => (isOther(this.#columns[at]) ? new Columns(count, first, last).sample(states) : this.#columns[at]));
    this.#left = Math.min(this.#left, count);
    let seen = count;
    strips.forEach(({ states }, at) => {
      seen = Math.min(seen, this.#columns[at].refresh(states, BUDGET / strips.length));
      [frame, followed].forEach((one) => this.#columns[at].see(one ?? NaN, states));
    });
    this.#left -= seen;
  }
}

const stripHeight = (isChosen) => (isChosen ? CHOSEN : STRIP);

function drawStrip(context, states, { top, wide, width, color }) {
  const colors = palette();
  context.fillStyle = color;
  context.fillRect(0, top, EDGE - 3, wide);
  context.fillStyle = colors.panel;
  context.fillRect(EDGE, top, width - 2 * EDGE, wide);
  for (let from = 0, to = 1; to <= states.length; to++) {
    if (states[to] !== states[from] || to === states.length) {
      if (states[from] !== undefined) {
        context.fillStyle = colors[states[from]];
        context.fillRect(EDGE + from, top, to - from, wide);
      }
      from = to;
    }
  }
}

// Draws a line through the dots of boxes with a line between them, frames in which the target is hidden, and, along the
// lower edge of the strip, the frames that are checked.
function drawTruth(context, { known, hidden, lines }, x, top) {
  const { ink, panel } = palette();
  const draw = (ranges, color, from, high) => {
    context.fillStyle = color;
    ranges.forEach(([begin, end]) => context.fillRect(x(begin), from, x(end + 1) - x(begin), high));
  };
  draw(lines, ink, MARKS / 2 - 1, 2);
  draw(hidden, panel, top + 2, CHOSEN - 7);
  draw(known, ink, top + CHOSEN - 3, 3);
}

function drawFollowed(context, top, width, end) {
  context.fillStyle = palette().rule;
  context.fillRect(EDGE, top, width - 2 * EDGE, 3);
  context.fillStyle = palette().faint;
  context.fillRect(EDGE, top, end - EDGE, 3);
}

// Draws a dot for a lock, and a triangle that points down for any other event.
function drawMark(context, x, kind) {
  const colors = palette();
  context.fillStyle = colors[kind] ?? (kind === "found" ? colors.tracking : colors.ink);
  context.beginPath();
  if (kind === "locked" || kind === "corrected") {
    context.arc(x, MARKS / 2, 3.5, 0, 2 * Math.PI);
  } else {
    context.moveTo(x - 4.5, 1);
    context.lineTo(x + 4.5, 1);
    context.lineTo(x, MARKS - 2);
  }
  context.fill();
}

function drawHead(context, x, height) {
  context.fillStyle = palette().ink;
  context.fillRect(x - 1, 0, 2, height);
  context.beginPath();
  context.arc(x, height - 6, 5, 0, 2 * Math.PI);
  context.fill();
}

function drawFocus(context, width, height) {
  context.strokeStyle = palette().focus;
  context.lineWidth = 2;
  context.strokeRect(1, 1, width - 2, height - 2);
}
