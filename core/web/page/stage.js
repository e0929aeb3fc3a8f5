// Draws a frame with boxes on a canvas.

import { fitted } from "./dom.js";
import { palette } from "./palette.js";

/** Dashes and gaps, in pixels, of a box from an earlier frame. */
const LAST_DASH = [4, 4];
const SHARED_DASH = 10;
const NEAR = 2.5; // pixels: boxes that differ by less look the same
const SHADOW = "rgb(0 0 0 / .55)";
const LETTERS = 14, MIN_LETTERS = 11;
const HANDLE = 9;
const WIDE_HANDLE = 16; // for fingers
// Least width of an image's pixel, in canvas pixels, at which the image is drawn unsmoothed to show its pixels.
const SMOOTH = 4;

/** Draws `drawFrame`'s scene on a whole canvas of the page, at the screen's resolution. */
export function drawStage(canvas, scene) {
  const context = canvas.getContext("2d");
  const place = fitted(canvas);
  context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  drawFrame(context, place, scene);
}

/**
 * Draws a frame and boxes on a canvas area of `width` by `height`. `size` is the size of the frame. `view` is the
 * rectangle in the frame's coordinates that fills the area; it may extend beyond the frame. `under(context, placed)`
 * draws what lies below the boxes; `placed(box)` converts a box to canvas pixels. `boxes` are { box, color, dash,
 * words, isChosen, isLast, hasHandles }: `words` is the box's label, `isLast` marks a box from an earlier frame. The
 * scene's own `words` are the parts { text, color } of the text in the corner. `proposed` is the box that the user
 * draws, or null.
 */
export function drawFrame(context, { width, height }, { image, size, view = { x: 0, y: 0, ...size }, under = () => {}, boxes, words = [], proposed = null, color = "#fff" }) {
  const scale = width / view.width;
  const placed = ({ x, y, width: wide, height: high }) => [(x - view.x) * scale, (y - view.y) * scale, wide * scale, high * scale];
  context.clearRect(0, 0, width, height);
  context.imageSmoothingEnabled = (scale * size.width) / image.width < SMOOTH;
  context.drawImage(image, ...placed({ x: 0, y: 0, ...size }));
  under(context, placed);
  for (const one of sharing(boxes.map((one) => ({ ...one, place: placed(one.box) })))) {
    drawBox(context, one);
  }
  // A click proposes an empty box, which is not drawn.
  if (proposed !== null && proposed.width + proposed.height > 0) {
    drawEdge(context, placed(proposed), { color, line: 2 });
    handles(context, placed(proposed), color);
  }
  drawWords(context, words, width);
}

/** Gives coinciding boxes alternating dashes, so that all their colors are visible. */
export function sharing(boxes) {
  const groups = [];
  for (const one of boxes.filter(({ isLast }) => !isLast)) {
    const group = groups.find(([first]) => isNear(first.place, one.place));
    group === undefined ? groups.push([one]) : group.push(one);
  }
  return boxes.map((one) => {
    const group = groups.find((group) => group.includes(one)) ?? [];
    return group.length < 2 ? one : { ...one, dash: [SHARED_DASH, SHARED_DASH * (group.length - 1)], offset: -SHARED_DASH * group.indexOf(one) };
  });
}

function isNear(one, other) {
  const edges = ([x, y, width, height]) => [x, y, x + width, y + height];
  return edges(one).every((edge, at) => Math.abs(edge - edges(other)[at]) < NEAR);
}

function drawBox(context, { place, color, dash, offset, words, isChosen, isLast, hasHandles }) {
  drawEdge(context, place, { color, line: isChosen ? 3 : isLast ? 1.5 : 2.5, dash: isLast ? LAST_DASH : dash, offset });
  if (hasHandles) {
    handles(context, place, color);
  }
  if (words) {
    const [x, y, , height] = place;
    const above = y > LETTERS * 1.6;
    write(context, [{ text: words, color }], Math.max(x, 2), above ? y - 6 : y + height + LETTERS * 1.3, LETTERS);
  }
}

function drawEdge(context, place, { color, line, ...dashes }) {
  outline(context, place, { color: SHADOW, line: line + 2, ...dashes });
  outline(context, place, { color, line, ...dashes });
}

function outline(context, place, { color, line, dash = [], offset = 0 }) {
  context.strokeStyle = color;
  context.lineWidth = line;
  context.setLineDash(dash);
  context.lineDashOffset = offset;
  context.strokeRect(...place);
  context.setLineDash([]);
}

function handles(context, [x, y, width, height], color) {
  const widest = matchMedia("(pointer: coarse)").matches ? WIDE_HANDLE : HANDLE;
  // A small box has small handles, so that its content stays visible.
  const side = Math.max(Math.min(widest, width / 4, height / 4), 4);
  for (const across of [0, 0.5, 1]) {
    for (const down of [0, 0.5, 1]) {
      if (across !== 0.5 || down !== 0.5) {
        const place = [x + across * width - side / 2, y + down * height - side / 2, side, side];
        context.fillStyle = color;
        context.fillRect(...place);
        outline(context, place, { color: "#000", line: 1 });
      }
    }
  }
}

/** Returns the text for the corner: the frame number and each tracker's state. `states` are pairs [title, state]. */
export function stateWords(number, states) {
  const colors = { ...palette("dark"), tracking: "#fff" };
  const of = ([title, state]) => [{ text: `  ${title}: `, color: "#fff" }, { text: state, color: colors[state] ?? "#fff" }];
  return [{ text: String(number), color: "#fff" }, ...states.flatMap(of)];
}

// Draws the text in the corner, in smaller letters if the frame is narrow.
function drawWords(context, words, width) {
  const wanted = Math.max(width / 40, MIN_LETTERS);
  context.font = font(wanted);
  const { width: long } = context.measureText(words.map(({ text }) => text).join(""));
  const size = Math.min(1, (width - wanted) / long) * wanted;
  write(context, words, size / 2, size * 1.3, size);
}

const font = (size) => `600 ${size}px system-ui, sans-serif`;

function write(context, words, x, y, size) {
  context.font = font(size);
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
