// Charts over frames: curves, bands of states, and the values at one frame. A click goes to a frame; a drag, fingers
// and keys zoom.

import { fitted, htmlNode, sample } from "./dom.js";
import { placeOf } from "./events.js";
import { lookOf, palette } from "./palette.js";

const LEFT = 56, RIGHT = 14, BAND = 18, AXIS = 18, EDGE = 6;
const LABEL = 50; // pixels for each label of the axis
const FEWEST = 5; // frames that a zoom leaves
const STEADY = 4; // pixels that a click may move
const UNKNOWN = "–";

const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const isThere = (value) => value !== null && value !== undefined && !Number.isNaN(value);
const short = (number, value = Number(number.toPrecision(9))) => (value >= 1e6 ? `${value / 1e6}M` : value >= 1e4 ? `${value / 1e3}k` : String(value));

export class Graph {
  #goTo;
  #zooms;
  #height;
  #charts = []; // with their elements
  #shown = null;
  #part = null; // of the frames, from a place to another; null: all
  #pointed = null; // the frame under the pointer
  #pressed = null; // where a drag began
  #fingers = new Map(); // places by pointer
  #painting = null;
  #resized = new ResizeObserver(() => this.#paintLater());

  /** A click calls `goTo(frame)`. With `zooms`, the user can zoom to a range of frames. `height` is that of a chart. */
  constructor({ goTo = () => {}, zooms = false, height = 104 } = {}) {
    [this.#goTo, this.#zooms, this.#height] = [goTo, zooms, height];
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#paintLater());
    document.addEventListener("pointermove", (event) => this.#moved(event));
    for (const end of ["pointerup", "pointercancel"]) {
      document.addEventListener(end, (event) => this.#released(event, end === "pointercancel"));
    }
  }

  /**
   * Draws `charts` over the frames from `first` to `last`. A chart is { place, title, most, digits, lines } or { place,
   * title, bands }: `place` is its parent element, `least` (0) and `most` the ends of the axis, `digits` the decimals of values. A
   * line or band is { title, look, isSecond, numbers, values, read }: `values` has one entry for each frame in
   * `numbers`, which ascend; `read(at)`, if given, formats `values[at]`. `now` is the frame to mark, `hidden` the
   * ranges [first, last] to shade, `named(frame)` a frame's label on the axis.
   */
  draw({ now = null, hidden = [], named = String, timeOf, ...shown }) {
    const hasChanged = shown.first !== this.#shown?.first || shown.last !== this.#shown?.last;
    this.#shown = { ...shown, hidden, named, timeOf };
    this.#part = hasChanged ? null : this.#part;
    this.#make(shown.charts);
    this.#paintLater();
    this.mark(now);
  }

  /** Marks a frame, whose values are displayed unless the pointer is over another frame. */
  mark(now) {
    this.#shown.now = now;
    this.#place();
  }

  /** Zooms around the frame `middle`, so that `factor` times as many frames are shown. */
  zoomBy(factor, middle = this.#shown.now) {
    const { from, to } = this.#span();
    const around = clamp(middle, from, to);
    this.#show(around - (around - from) * factor, around + (to - around) * factor);
  }

  /** Zooms in by the key `+`, zooms out by `-`, and shows all frames by `0`. Returns false for any other key. */
  key({ key }) {
    const act = { "+": () => this.zoomBy(0.5), "-": () => this.zoomBy(2), 0: () => this.showAll() }[key];
    act?.();
    return act !== undefined;
  }

  showAll() {
    this.#part = null;
    this.#paintLater();
    this.#place();
  }

  // ---- visible range of frames

  #all() {
    return { from: this.#shown.first - 0.5, to: this.#shown.last + 0.5 };
  }

  #span() {
    return this.#part ?? this.#all();
  }

  // Shows a range of frames, clamped to the existing frames and to a minimum length.
  #show(from, to) {
    if (!this.#zooms) {
      return;
    }
    const all = this.#all();
    const length = clamp(to - from, Math.min(FEWEST, all.to - all.from), all.to - all.from);
    const start = clamp((from + to - length) / 2, all.from, all.to - length);
    this.#part = { from: start, to: start + length };
    this.#paintLater();
    this.#place();
  }

  #moveBy(pixels, canvas) {
    if (this.#part !== null) {
      const { from, to } = this.#part;
      const by = (pixels * (to - from)) / (canvas.clientWidth - LEFT - RIGHT);
      this.#show(from + by, to + by);
    }
  }

  // ---- elements

  #make(charts) {
    const isSame = charts.length === this.#charts.length && charts.every((chart, at) => nameOf(chart) === this.#charts[at].name);
    if (!isSame) {
      this.#resized.disconnect();
      this.#charts.forEach(({ panel }) => panel.remove());
      this.#charts = charts.map((chart, at) => this.#panel(chart, chart.place !== charts[at + 1]?.place));
    }
    this.#charts = this.#charts.map((made, at) => ({ ...made, ...charts[at] }));
  }

  #panel(chart, hasAxis) {
    const canvas = htmlNode("canvas", { role: "img", "aria-label": `${chart.title} over frames` });
    canvas.style.height = `${(chart.bands ? BAND * chart.bands.length + 2 * EDGE : this.#height) + (hasAxis ? AXIS : 0)}px`;
    const [said, cursor, pointer] = [htmlNode("span", { class: "frame" }), htmlNode("div", { class: "cursor" }), htmlNode("div", { class: "pointer" })];
    const values = linesOf(chart).map((line) => document.createTextNode(line.title));
    const legend = linesOf(chart).map((line, at) => htmlNode("span", { class: "value" }, ...(line.title === "" ? [] : [sample(line.look, line.isSecond)]), values[at]));
    const name = htmlNode("div", { class: "name" }, htmlNode("b", {}, chart.title), said, ...legend);
    const panel = htmlNode("div", { class: "panel" }, name, htmlNode("div", { class: "chart" }, canvas, cursor, pointer));
    chart.place.append(panel);
    this.#resized.observe(canvas);
    this.#listen(canvas);
    return { name: nameOf(chart), panel, canvas, said, values, cursor, pointer, hasAxis };
  }

  #listen(canvas) {
    canvas.addEventListener("pointermove", (event) => this.#point(this.#numberAt(event.clientX, canvas)));
    canvas.addEventListener("pointerleave", () => this.#point(null));
    canvas.addEventListener("dblclick", () => this.showAll());
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button === 0) {
        this.#fingers.set(event.pointerId, event.clientX);
        this.#pressed = { canvas, x: event.clientX, isHand: event.pointerType === "touch" || event.shiftKey, isClick: this.#fingers.size === 1 && !event.shiftKey };
      }
    });
    // Turned sideways, the wheel moves the range; turned up or down, it scrolls the page.
    canvas.addEventListener("wheel", (event) => {
      const isSideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
      if (this.#part !== null && isSideways && !event.ctrlKey) {
        event.preventDefault();
        this.#moveBy(event.deltaX || event.deltaY, canvas);
      }
    }, { passive: false });
  }

  // Handles a drag. The mouse selects the range to zoom to; a finger, or the mouse with shift, moves the range; two
  // fingers zoom.
  #moved({ pointerId, clientX }) {
    if (!this.#fingers.has(pointerId)) {
      return;
    }
    const { canvas, x, isHand } = this.#pressed;
    const before = [...this.#fingers.values()];
    this.#fingers.set(pointerId, clientX);
    const now = [...this.#fingers.values()];
    this.#pressed.isClick &&= Math.abs(clientX - x) < STEADY;
    if (now.length > 1) {
      const apart = ([one, other]) => Math.max(Math.abs(one - other), 10);
      this.zoomBy(apart(before) / apart(now), this.#placeAt((now[0] + now[1]) / 2, canvas));
    } else if (isHand) {
      this.#moveBy(before[0] - now[0], canvas);
    }
  }

  #released({ pointerId, clientX }, isCancelled) {
    if (!this.#fingers.delete(pointerId)) {
      return;
    }
    const { canvas, x, isHand, isClick } = this.#pressed;
    if (this.#fingers.size === 0 && !isCancelled) {
      if (isClick) {
        this.#goTo(this.#numberAt(clientX, canvas));
      } else if (!isHand) {
        const [from, to] = [x, clientX].map((one) => this.#placeAt(one, canvas));
        this.#show(Math.min(from, to), Math.max(from, to));
      }
    }
    this.#pressed = this.#fingers.size === 0 ? null : this.#pressed;
    this.#place();
  }

  #placeAt(clientX, canvas) {
    const { from, to } = this.#span();
    const { left, width } = canvas.getBoundingClientRect();
    return from + ((to - from) * (clientX - left - LEFT)) / (width - LEFT - RIGHT);
  }

  #numberAt(clientX, canvas) {
    return clamp(Math.round(this.#placeAt(clientX, canvas)), this.#shown.first, this.#shown.last);
  }

  #point(number) {
    this.#pointed = number;
    this.#place();
  }

  // Moves the marks of the current frame and of the pointer, and updates the displayed values, without painting the
  // curves.
  #place() {
    const { now, last, timeOf } = this.#shown;
    const number = this.#pointed ?? now ?? last;
    const said = `${placeOf(number, timeOf)}${this.#shown.hidden.some(([from, to]) => from <= number && number <= to) ? ", hidden" : ""}`;
    for (const chart of this.#charts) {
      const x = this.#scale(fitted(chart.canvas).width);
      put(chart.cursor, now === null ? null : [x(now), x(now)], x.right);
      const began = this.#pressed?.canvas === chart.canvas && !this.#pressed.isHand && !this.#pressed.isClick ? this.#placeAt(this.#pressed.x, chart.canvas) : number;
      put(chart.pointer, this.#pointed === null || !this.#zooms ? null : [x(Math.min(number, began)), x(Math.max(number, began))], x.right);
      write(chart.said, said);
      linesOf(chart).forEach((line, at) => write(chart.values[at], `${line.title} ${valueOf(line, number, chart.digits)}`));
    }
  }

  // ---- painting

  #paintLater() {
    this.#painting ??= requestAnimationFrame(() => {
      this.#painting = null;
      this.#charts.forEach((chart) => this.#paint(chart));
      this.#place();
    });
  }

  #scale(width) {
    const { from, to } = this.#span();
    const right = width - RIGHT;
    return Object.assign((number) => LEFT + ((right - LEFT) * (number - from)) / (to - from), { right });
  }

  #paint(chart) {
    const { width, height } = fitted(chart.canvas);
    if (this.#shown === null || width <= LEFT + RIGHT) {
      return;
    }
    const context = chart.canvas.getContext("2d");
    const x = this.#scale(width);
    const bottom = height - EDGE - (chart.hasAxis ? AXIS : 0);
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    context.clearRect(0, 0, width, height);
    const y = chart.bands ? null : drawGrid(context, chart, bottom, x.right);
    context.save();
    context.beginPath();
    context.rect(LEFT, 0, x.right - LEFT, bottom + 2);
    context.clip();
    context.fillStyle = palette().gone;
    this.#shown.hidden.forEach(([from, to]) => context.fillRect(x(from - 0.5), EDGE, x(to + 0.5) - x(from - 0.5), bottom - EDGE));
    chart.bands?.forEach((band, row) => drawBand(context, band, EDGE + row * BAND, x));
    [...(chart.lines ?? [])].reverse().forEach((line) => drawLine(context, line, x, y, this.#span()));
    context.restore();
    if (chart.hasAxis) {
      this.#drawAxis(context, x, bottom + 14, width);
    }
  }

  #drawAxis(context, x, y, width) {
    const { from, to } = this.#span();
    let end = 0; // of the last label
    const step = Math.max(stepOf(LABEL / (x(1) - x(0))), 1);
    for (let number = Math.ceil(Math.max(from, 1) / step) * step; number <= to; number += step) {
      const text = this.#shown.named(number);
      const half = context.measureText(text).width / 2;
      if (x(number) - half > end && x(number) + half <= width) {
        label(context, text, x(number), y, "center");
        end = x(number) + half + 4;
      }
    }
  }
}

const linesOf = ({ lines, bands }) => lines ?? bands;
const nameOf = (chart) => [chart.place.id, chart.title, ...linesOf(chart).map(({ title, look, isSecond }) => `${title}/${look}/${isSecond}`)].join("\n");

function put(mark, span, right) {
  mark.hidden = span === null || span[1] < LEFT || span[0] > right;
  if (!mark.hidden) {
    Object.assign(mark.style, { left: `${Math.max(span[0], LEFT)}px`, width: `${Math.min(span[1], right) - Math.max(span[0], LEFT)}px` });
  }
}

function write(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

// Returns the first index in the sorted `numbers` whose value is at least `number`.
function placeIn(numbers, number) {
  let [from, to] = [0, numbers.length];
  while (from < to) {
    const middle = (from + to) >> 1;
    numbers[middle] < number ? (from = middle + 1) : (to = middle);
  }
  return from;
}

function valueOf({ numbers, values, read }, number, digits = 0) {
  const at = placeIn(numbers, number);
  if (numbers[at] !== number || !isThere(values[at])) {
    return UNKNOWN;
  }
  return read?.(at) ?? (typeof values[at] === "string" ? values[at] : values[at].toFixed(digits));
}

// Two caches, whose keys are lists of values: the runs of equal values in a list, and its largest value.
const spans = new WeakMap();
const largest = new WeakMap();

function once(known, values, find) {
  if (!known.has(values)) {
    known.set(values, find(values));
  }
  return known.get(values);
}

/** Returns the runs { value, from, to } of equal values, as indices in the list; missing values are in no run. */
export function spansOf(values, numbers = null) {
  const follows = (at) => at > 0 && (numbers === null || numbers[at] === numbers[at - 1] + 1);
  return once(spans, values, () => {
    const found = [];
    values.forEach((value, at) => {
      if (follows(at) && value === values[at - 1] && isThere(value)) {
        found.at(-1).to = at;
      } else if (isThere(value)) {
        found.push({ value, from: at, to: at });
      }
    });
    return found;
  });
}

const largestOf = (values) => once(largest, values, () => values.reduce((most, value) => (value > most ? value : most), 0));

// Returns 1, 2 or 5 times a power of 10, at least `least`.
function stepOf(least) {
  const unit = 10 ** Math.floor(Math.log10(least));
  return unit * [1, 2, 5, 10].find((times) => times * unit >= least);
}

function drawGrid(context, { lines, least = 0, most }, bottom, right) {
  const top = most ?? Math.max(1, 1.05 * lines.reduce((high, { values }) => Math.max(high, largestOf(values)), 0));
  const y = (value) => bottom - ((bottom - EDGE) * (value - least)) / (top - least);
  const step = stepOf((top - least) / 3.5);
  for (let value = Math.ceil(least / step) * step; value <= top; value += step) {
    context.fillStyle = palette().rule;
    context.fillRect(LEFT, y(value) - 0.5, right - LEFT, 1);
    label(context, short(value), LEFT - 4, y(value) + 4);
  }
  return y;
}

function drawBand(context, { title, numbers, values }, top, x) {
  for (const { value, from, to } of spansOf(values, numbers)) {
    context.fillStyle = palette()[value];
    // Rounds to whole pixels, so that there is no gap between neighbouring runs.
    const [left, right] = [Math.round(x(numbers[from] - 0.5)), Math.round(x(numbers[to] + 0.5))];
    context.fillRect(left, top + 1, Math.max(right - left, 1), BAND - 2);
  }
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = palette().panel;
  label(context, title, LEFT + 4, top + BAND / 2 + 4, "left", palette().ink);
}

function drawLine(context, line, x, y, span) {
  const { onPage, dash } = lookOf(line.look);
  const points = thinned(line, span, Math.ceil(x.right - LEFT));
  context.strokeStyle = context.fillStyle = onPage;
  context.lineWidth = line.isSecond ? 1.2 : 1.6;
  context.setLineDash(line.isSecond ? [2, 3] : dash);
  context.beginPath();
  points.forEach((at, place) => {
    if (at === null) {
      return;
    }
    const [across, down] = [x(line.numbers[at]), y(line.values[at])];
    const [isFirst, isLast] = [(points[place - 1] ?? null) === null, (points[place + 1] ?? null) === null];
    isFirst ? context.moveTo(across, down) : context.lineTo(across, down);
    // A value without neighbours is drawn as a point.
    if (isFirst && isLast) {
      context.fillRect(across - 1.5, down - 1.5, 3, 3);
    }
  });
  context.stroke();
  context.setLineDash([]);
}

/**
 * Divides a line's values into at most 2 * `columns` parts, so that the count of points to draw does not grow with the
 * recording. Returns the indices of each part's least and largest value in ascending order: one index if both indices
 * are equal, one null if the part has no values.
 */
export function thinned({ numbers, values }, { from, to }, columns) {
  const [first, end] = [Math.max(placeIn(numbers, from) - 1, 0), Math.min(placeIn(numbers, to) + 1, numbers.length)];
  const each = Math.max(1, Math.floor((end - first) / columns));
  const points = [];
  for (let start = first; start < end; start += each) {
    let [low, high] = [null, null];
    for (let at = start; at < Math.min(start + each, end); at++) {
      if (isThere(values[at])) {
        low = low === null || values[at] < values[low] ? at : low;
        high = high === null || values[at] > values[high] ? at : high;
      }
    }
    points.push(...(low === high ? [low] : [Math.min(low, high), Math.max(low, high)]));
  }
  return points;
}

function label(context, text, x, y, align = "right", color = palette().faint) {
  context.font = "11px system-ui, sans-serif";
  context.textAlign = align;
  if (color !== palette().faint) {
    context.strokeText(text, x, y);
  }
  context.fillStyle = color;
  context.fillText(text, x, y);
}
