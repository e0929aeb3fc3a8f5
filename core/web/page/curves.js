// The curves of one target, of the trackers that follow it here: states, confidence and ratio.

import { METHODS, SHORT } from "./methods.js";

/** The number of frames that the curves show. */
export const FRAMES = 300;
const STATES = ["tracking", "leaving", "uncertain", "lost"];

/** Charts as graph.js takes them. `target`: its `histories` by method, see answers.js; or null. */
export function chartsOf(place, target, on) {
  const histories = METHODS.filter((method) => on[method] && target?.histories[method]);
  const line = (method, column, read) => ({
    title: SHORT[method], look: method,
    numbers: target.histories[method].last("number", FRAMES), values: target.histories[method].last(column, FRAMES).map(read),
  });
  const part = (value) => value / 65535;
  return [
    { place, title: "States", bands: histories.map((method) => line(method, "state", (state) => STATES[state])) },
    { place, title: "Confidence", most: 1, digits: 3, lines: histories.map((method) => line(method, "confidence", part)) },
    { place, title: "Ratio", most: 1, digits: 3, lines: histories.map((method) => line(method, "ratio", part)) },
  ];
}
