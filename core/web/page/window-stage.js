// Draws the frame of the window with the boxes of its targets.

import { fitted } from "./dom.js";
import { LAST_DASH, outline, write } from "./view.js";

const LETTERS = 14;
const HANDLE = 9;
const WIDE_HANDLE = 16; // for fingers
// A picture is drawn smoothly, unless its pixels are so large that they are to be seen.
const SMOOTH = 4;

/**
 * `view` is the part of a frame of `size` that is seen. `under(context, placed)` draws under the boxes, where `placed(box)` is the place of a
 * box on the canvas. `boxes`: { box, color, words, isChosen, isLast, hasHandles } each;
 * `isLast`: the box is not of this frame. `proposed`: the box that the user draws, or null.
 */
export function drawWindow(canvas, { picture, size, view, under, boxes, proposed, color }) {
  const { width, height } = fitted(canvas);
  const context = canvas.getContext("2d");
  const scale = width / view.width;
  const placed = ({ x, y, width: wide, height: high }) => [(x - view.x) * scale, (y - view.y) * scale, wide * scale, high * scale];
  context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.imageSmoothingEnabled = (scale * size.width) / picture.width < SMOOTH;
  context.drawImage(picture, ...placed({ x: 0, y: 0, ...size }));
  under(context, placed);
  for (const one of boxes) {
    drawBox(context, placed(one.box), one);
  }
  // A click draws nothing.
  if (proposed !== null && proposed.width + proposed.height > 0) {
    drawEdge(context, placed(proposed), { color, line: 2, dash: [] });
    handles(context, placed(proposed), color);
  }
}

function drawBox(context, place, { color, words, isChosen, isLast, hasHandles }) {
  drawEdge(context, place, { color, line: isChosen ? 3 : 2, dash: isLast ? LAST_DASH : [] });
  if (hasHandles) {
    handles(context, place, color);
  }
  const [x, y, , height] = place;
  const above = y > LETTERS * 1.6;
  write(context, [{ text: words, color }], Math.max(x, 2), above ? y - 6 : y + height + LETTERS * 1.3, LETTERS);
}

function drawEdge(context, place, { color, line, dash }) {
  outline(context, place, { color: "rgb(0 0 0 / .55)", line: line + 2, dash });
  outline(context, place, { color, line, dash });
}

function handles(context, [x, y, width, height], color) {
  const widest = matchMedia("(pointer: coarse)").matches ? WIDE_HANDLE : HANDLE;
  // What is in a small box is to be seen.
  const side = Math.max(Math.min(widest, width / 4, height / 4), 4);
  for (const across of [0, 0.5, 1]) {
    for (const down of [0, 0.5, 1]) {
      if (across !== 0.5 || down !== 0.5) {
        const place = [x + across * width - side / 2, y + down * height - side / 2, side, side];
        context.fillStyle = color;
        context.fillRect(...place);
        outline(context, place, { color: "#000", line: 1, dash: [] });
      }
    }
  }
}
