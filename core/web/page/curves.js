// The curves of one target: states, confidence and ratio.

import { SHORT } from "./methods.js";

/** The number of frames that the curves show. */
export const FRAMES = 300;
const STATES = ["tracking", "leaving", "uncertain", "lost"];

/** Charts as graph.js takes them, of the answers `around` a frame (answers.js), or without lines if that is undefined. */
export function chartsOf(place, method, around) {
  const lines = (column, read) => (around === undefined ? [] : [{ title: SHORT[method], look: method, numbers: around.last("number"), values: around.last(column).map(read) }]);
  const part = (value) => value / 65535;
  return [
    { place, title: "States", bands: lines("state", (state) => STATES[state]) },
    { place, title: "Confidence", most: 1, digits: 3, lines: lines("confidence", part) },
    { place, title: "Ratio", most: 1, digits: 3, lines: lines("ratio", part) },
  ];
}
