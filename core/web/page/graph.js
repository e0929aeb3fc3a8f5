// The curves: states, confidence and ratio of the chosen target in its last frames, drawn as on the page of `host-sim
// report`.

import { fitted, htmlNode, sample } from "./dom.js";
import { METHODS, TITLES } from "./methods.js";
import { palette } from "./palette.js";

/** The number of frames that the curves show. */
export const FRAMES = 300;
const LEFT = 56, RIGHT = 14, HEIGHT = 104, BAND = 14, AXIS = 18, EDGE = 6, NARROW = 500;
const STATES = ["tracking", "leaving", "uncertain", "lost"];

export class Graph {
  #panels;

  constructor(place) {
    this.#panels = [
      panel(place, "States", 2 * BAND + 12, drawStates),
      panel(place, "Confidence", HEIGHT, (...of) => drawLines(...of, "confidence")),
      panel(place, "Ratio (dotted: runner-up)", HEIGHT + AXIS, (...of) => drawLines(...of, "ratio", "runnerUpRatio")),
    ];
  }

  /**
   * `target`: see followed.js, or null. The curves end with the frame `end`, or with the last answer. `now` is a frame to
   * mark; `named` what a frame is called.
   */
  draw(target, on, { end = null, now = null, named = String } = {}) {
    const histories = METHODS.filter((method) => on[method] && target?.histories[method]).map((method) => [method, target.histories[method]]);
    const last = end ?? Math.max(...histories.map(([, history]) => history.row().number), FRAMES);
    this.#panels.forEach((one, at) => {
      const { width, height } = fitted(one.canvas);
      const context = one.canvas.getContext("2d");
      context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
      context.clearRect(0, 0, width, height);
      const isLast = at === this.#panels.length - 1;
      const bottom = height - EDGE - (isLast ? AXIS : 0);
      const x = (number) => LEFT + ((width - LEFT - RIGHT) * (number - (last - FRAMES) - 0.5)) / FRAMES;
      one.draw({ context, x, bottom, right: width - RIGHT, histories, legend: one.legend });
      if (now !== null) {
        line(context, [[x(now), EDGE], [x(now), bottom]], { color: palette().ink, width: 1, dash: [] });
      }
      if (isLast) {
        drawAxis(context, x, bottom, { last, width, named });
      }
    });
  }
}

function panel(place, title, height, draw) {
  const canvas = htmlNode("canvas", { role: "img", "aria-label": `${title} over ${FRAMES} frames` });
  canvas.style.height = `${height}px`;
  const legend = htmlNode("span", {});
  place.append(htmlNode("div", { class: "panel" }, htmlNode("div", { class: "name" }, htmlNode("b", {}, title), legend), canvas));
  return { canvas, legend, draw };
}

function drawStates({ context, x, histories, legend }) {
  histories.forEach(([method, history], row) => {
    label(context, TITLES[method], LEFT - 4, EDGE + BAND * (row + 0.5) + 4);
    const numbers = history.last("number", FRAMES);
    history.last("state", FRAMES).forEach((state, at) => {
      context.fillStyle = palette()[STATES[state]];
      // Whole pixels, so that neighbours leave no gap.
      const [from, to] = [Math.round(x(numbers[at] - 0.5)), Math.round(x(numbers[at] + 0.5))];
      context.fillRect(from, EDGE + row * BAND + 1, to - from, BAND - 2);
    });
  });
  name(legend, histories, (history) => history.row().state);
}

function drawLines({ context, x, bottom, right, histories, legend }, column, second) {
  const y = (value) => bottom - ((bottom - EDGE) * value) / 65535;
  for (const part of [0, 0.5, 1]) {
    line(context, [[LEFT, y(65535 * part)], [right, y(65535 * part)]], { color: palette().rule, width: 1, dash: [] });
    label(context, String(part), LEFT - 4, y(65535 * part) + 4);
  }
  for (const [method, history] of [...histories].reverse()) {
    const { onPage, dash } = palette()[method];
    const numbers = history.last("number", FRAMES);
    const points = (of) => history.last(of, FRAMES).map((value, at) => [x(numbers[at]), y(value)]);
    line(context, points(column), { color: onPage, width: 1.6, dash });
    if (second !== undefined) {
      line(context, points(second), { color: onPage, width: 1.2, dash: [2, 3] });
    }
  }
  const read = (value) => (Number.isNaN(value) ? "–" : (value / 65535).toFixed(3));
  name(legend, histories, (history) => read(history.row()[column]));
}

function drawAxis(context, x, bottom, { last, width, named }) {
  const step = width < NARROW ? 100 : 50;
  for (let number = Math.ceil((last - FRAMES) / step) * step; number <= last; number += step) {
    const half = context.measureText(named(number)).width / 2;
    if (number > Math.max(last - FRAMES, 0) && x(number) + half <= width) {
      label(context, named(number), x(number), bottom + 14, "center");
    }
  }
}

// A missing point ends a line.
function line(context, points, { color, width, dash }) {
  context.strokeStyle = color;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.beginPath();
  let isOpen = false;
  for (const [x, y] of points) {
    const isThere = !Number.isNaN(y);
    if (isThere) {
      isOpen ? context.lineTo(x, y) : context.moveTo(x, y);
    }
    isOpen = isThere;
  }
  context.stroke();
  context.setLineDash([]);
}

function label(context, text, x, y, align = "right") {
  context.font = "11px system-ui, sans-serif";
  context.textAlign = align;
  context.fillStyle = palette().faint;
  context.fillText(text, x, y);
}

// The samples stay; only changes are written.
function name(legend, histories, read) {
  const shown = histories.map(([method]) => method).join();
  if (legend.dataset.shown !== shown) {
    legend.dataset.shown = shown;
    legend.replaceChildren(...histories.flatMap(([method]) => [sample(method), document.createTextNode("")]));
  }
  histories.forEach(([method, history], at) => {
    legend.childNodes[2 * at + 1].data = `${TITLES[method]} ${read(history)} `;
  });
}
