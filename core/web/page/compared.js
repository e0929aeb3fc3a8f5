// Pictures of the data that a tracker compares with a frame: the robust tracker's early template and response map, the
// paper's template and its difference from the box.

import { frameOf, copyWindow } from "../frame.js";

/** The data that the next update compares with; to be read before the update replaces it. */
export function picturesBefore(tracker, frame) {
  const { method, template } = tracker;
  return method === "paper" ? { template } : { template, responseMap: tracker.responseMap(frame) };
}

/** The same data after the update, and for the paper's tracker the difference of each pixel of the box. */
export function picturesAfter(before, frame, answer) {
  const { template } = before;
  if (before.responseMap !== undefined) {
    return before;
  }
  const seen = pixelsOf(frame, { ...answer.box, width: template.width, height: template.height });
  return { template, difference: { ...template, pixels: template.pixels.map((level, at) => Math.abs(level - seen[at])) } };
}

// The gray pixels of a box. Pixels outside the frame are zero, as in the trackers.
function pixelsOf(frame, box) {
  const [left, right] = [Math.max(box.x, 0), Math.min(box.x + box.width, frame.width)];
  const [top, bottom] = [Math.max(box.y, 0), Math.min(box.y + box.height, frame.height)];
  const inside = { x: left, y: top, width: Math.max(right - left, 0), height: Math.max(bottom - top, 0) };
  const shown = new Uint8Array(inside.width * inside.height);
  copyWindow(frameOf(frame), inside, shown);
  const pixels = new Uint8Array(box.width * box.height);
  for (let row = 0; row < inside.height; row++) {
    const from = row * inside.width;
    pixels.set(shown.subarray(from, from + inside.width), (top - box.y + row) * box.width + left - box.x);
  }
  return pixels;
}
