// A frame with the boxes of targets that trackers follow here, for stage.js.

import { METHODS, SHORT } from "./methods.js";
import { lookOf } from "./palette.js";
import { stateWords } from "./stage.js";

const WINDOW_DASH = [5, 5];

/**
 * `picture` of `size` is the frame. `targets`: see followed.js; `chosen` is one of them. `box`: the box that the user
 * draws, or null.
 */
export function sceneOf({ picture, size, targets, chosen, on, box, number }) {
  const shown = METHODS.filter((method) => on[method]);
  const windows = chosen === null ? [] : shown.flatMap((method) => windowsOf(chosen.now[method]));
  const boxes = targets.flatMap((target) => boxesOf(target, shown, targets.length > 1 ? target.name : ""));
  const states = shown.map((method) => [SHORT[method], chosen?.now[method]?.state ?? "not locked"]);
  return { picture, size, boxes: [...windows, ...boxes], proposed: box, words: chosen === null ? [] : stateWords(number, states) };
}

const windowsOf = (now) => [now?.window, now?.sweepWindow].filter(Boolean).map((box) => ({ box, color: "#fff", dash: WINDOW_DASH }));

function boxesOf({ now }, shown, name) {
  const answered = shown.filter((method) => now[method]?.box);
  return answered.map((method, at) => {
    const { onFrame, dash } = lookOf(method);
    return { box: now[method].box, color: onFrame, dash, words: at === 0 ? name : "", isLast: now[method].state === "lost" };
  });
}
