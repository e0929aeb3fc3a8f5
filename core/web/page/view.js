// Draws the frame with its boxes, as the page of `host-sim report` does.

import { fitted } from "./dom.js";
import { METHODS, TITLES } from "./methods.js";
import { palette } from "./palette.js";

const WINDOW_DASH = [5, 5];
/** The dashes of a last place. */
export const LAST_DASH = [4, 4];

/**
 * `picture` of `size` is the frame. `targets`: see followed.js; `chosen` is one of them. `box`: the box that the user
 * draws, or null.
 */
export function drawStage(canvas, scene) {
  const context = canvas.getContext("2d");
  const place = fitted(canvas);
  context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  drawScene(context, place, scene);
}

/** The same, on any canvas: on a part of it of `width` times `height`. */
export function drawScene(context, { width, height }, { picture, size, targets, chosen, on, box, number }) {
  const scale = width / size.width;
  context.imageSmoothingEnabled = scale < 1;
  context.drawImage(picture, 0, 0, width, height);
  const shown = METHODS.filter((method) => on[method]);
  if (chosen !== null) {
    shown.forEach((method) => drawWindows(context, scale, chosen.now[method]));
  }
  for (const target of targets) {
    drawTarget(context, scale, target, shown, targets.length > 1 ? target.name : "");
  }
  if (box !== null) {
    drawProposed(context, scaled(box, scale));
  }
  if (chosen !== null) {
    drawStates(context, chosen, shown, number, Math.max(width / 40, 11));
  }
}

function drawWindows(context, scale, now) {
  for (const window of [now?.window, now?.sweepWindow]) {
    if (window) {
      const { x, y, width, height } = scaled(window, scale);
      outline(context, [x, y, width, height], { color: "rgb(0 0 0 / .7)", line: 1.5, dash: [] });
      outline(context, [x, y, width, height], { color: "#fff", line: 1.5, dash: WINDOW_DASH });
    }
  }
}

function drawTarget(context, scale, { now }, shown, name) {
  const answered = shown.filter((method) => now[method]?.box);
  const believed = answered.filter((method) => now[method].state !== "lost");
  const at = (method) => scaled(now[method].box, scale);
  const coincide = believed.length > 1 && near(at(believed[0]), at(believed[1]));
  for (const method of answered) {
    const { x, y, width, height } = at(method);
    const { onFrame, dash } = palette()[method];
    const shared = { dash: [10, 10], offset: -10 * believed.indexOf(method) };
    const style = believed.includes(method) ? { line: 2.5, ...(coincide ? shared : { dash }) } : { line: 1.5, dash: LAST_DASH };
    outline(context, [x, y, width, height], { color: onFrame, ...style });
  }
  if (answered.length > 0 && name !== "") {
    const { x, y } = at(answered[0]);
    write(context, [{ text: name, color: "#fff" }], Math.max(x, 2), Math.max(y - 5, 15), 14);
  }
}

function drawProposed(context, { x, y, width, height }) {
  outline(context, [x, y, width, height], { color: "rgb(0 0 0 / .7)", line: 4, dash: [] });
  outline(context, [x, y, width, height], { color: "#fff", line: 2, dash: [] });
}

function drawStates(context, { now }, shown, number, size) {
  const colors = { ...palette(), tracking: "#fff" };
  const words = shown.flatMap((method) => {
    const state = now[method]?.state ?? "not locked";
    return [{ text: `  ${TITLES[method]}: `, color: "#fff" }, { text: state, color: colors[state] ?? "#fff" }];
  });
  write(context, [{ text: String(number), color: "#fff" }, ...words], size / 2, size * 1.3, size);
}

export function write(context, words, x, y, size) {
  context.font = `600 ${size}px system-ui, sans-serif`;
  context.lineJoin = "round";
  context.lineWidth = size * 0.22;
  context.strokeStyle = "#000";
  for (const { text, color } of words) {
    context.strokeText(text, x, y);
    context.fillStyle = color;
    context.fillText(text, x, y);
    x += context.measureText(text).width;
  }
}

export function outline(context, box, { color, line, dash, offset = 0 }) {
  context.strokeStyle = color;
  context.lineWidth = line;
  context.setLineDash(dash);
  context.lineDashOffset = offset;
  context.strokeRect(...box);
  context.setLineDash([]);
}

function scaled({ x, y, width, height }, scale) {
  return { x: x * scale, y: y * scale, width: width * scale, height: height * scale };
}

// True if two boxes look the same: no edge differs by 2.5 or more.
function near(a, b) {
  const edges = ({ x, y, width, height }) => [x, y, x + width, y + height];
  return edges(a).every((edge, at) => Math.abs(edge - edges(b)[at]) < 2.5);
}
