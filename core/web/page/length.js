// The length in the picture: the user draws a line along something, and says how many metres that is.

import { byId } from "./dom.js";
import { draw, drawLength } from "./drawing.js";
import { lengthOf, lineOf, metresOf } from "./movement.js";
import { app, focusStage, say, size, trying } from "./state.js";

/** Begins to draw the line, or ends that. */
export function measure() {
  if (app.measured !== null) {
    endMeasuring();
    return;
  }
  app.drag.drop();
  app.measured = { line: lineOf(app.recording.length), drawn: null };
  byId("metres").value = metresOf(app.recording.length);
  focusStage();
  draw();
}

export function endMeasuring() {
  app.drag.drop();
  app.measured = null;
  draw();
}

export function takeLength() {
  const text = byId("metres").value;
  const length = lengthOf(app.measured.line, text);
  if (length === null) {
    say(`"${text}" is no length: expected metres, such as 2.5.`);
    return;
  }
  byId("curve").value = "movement";
  keep(length);
}

export const dropLength = () => keep(null);

async function keep(length) {
  const before = app.recording.length ?? null;
  if (await useLength(length)) {
    app.edits.measured(before);
  }
}

/** Replaces the length in the picture. Returns false if the source refuses that. */
export async function useLength(length) {
  const isKept = (await trying(app.source.length(length))) !== "";
  if (isKept) {
    app.recording.length = length;
    endMeasuring();
  }
  return isKept;
}

/** What a drag on the picture does while a length is measured, see drag.js. */
export const lineDrag = {
  isLine: true, size,
  view: () => app.viewport.seen,
  grip: () => null,
  click() {},
  start() {
    const { x, y, width, height } = app.viewport.seen;
    return { id: null, box: app.measured.line ?? { x: x + width / 4, y: y + height / 2, width: width / 2, height: 0 } };
  },
  propose(line) {
    app.measured.drawn = line;
    draw();
  },
  lock(line) {
    if (line.width === 0 && line.height === 0) {
      say("The line has no pixels: drag from one end to the other.");
      return;
    }
    app.measured.line = line;
    drawLength();
    byId("metres").focus();
    byId("metres").select();
  },
};
