// Shows the chosen target's answers: a table of the shown frame's answer and its cost, and curves over the frames.

import { about, instructions } from "./cost.js";
import { htmlNode, sample } from "./dom.js";
import { SHORT } from "./methods.js";

const part = (value, unit) => (value === undefined || value === null ? "–" : (value / unit).toFixed(3));
const whole = (value) => (value === undefined || value === null ? "–" : String(value));
const millions = (value) => (value === undefined ? "–" : `${(value / 1e6).toFixed(2)} M`);
const placed = (box) => (box ? [box.x, box.y, box.width, box.height].map((side) => Math.round(side)).join(", ") : "–");

const ROWS = [
  ["state", (now) => now.state],
  ["confidence", (now) => part(now.confidence, 65535)],
  ["ratio", (now) => part(now.ratio, 65535)],
  ["alpha", (now) => whole(now.alpha)],
  ["identity", (now) => part(now.identity, 65535)],
  ["size", (now) => part(now.scale, 65536)],
  ["box", (now) => (now.state === "lost" ? "–" : placed(now.box))],
  ["work", (now) => millions(now.work)],
  ["Cortex-M4", (now, method) => about(instructions(method, now).m4)],
  ["Cortex-M55", (now, method) => about(instructions(method, now).m55)],
];

/** Fills the table with `now`, the answer of `method` for the shown frame, or with dashes if `now` is undefined. */
export function drawFigures(table, method, now) {
  if (table.dataset.of !== method) {
    table.dataset.of = method;
    const head = [htmlNode("th", { scope: "col" }, "this frame"), htmlNode("th", { scope: "col" }, sample(method), SHORT[method])];
    const lines = ROWS.map(([title]) => htmlNode("tr", {}, htmlNode("th", { scope: "row" }, title), htmlNode("td", {})));
    table.replaceChildren(htmlNode("thead", {}, htmlNode("tr", {}, ...head)), htmlNode("tbody", {}, ...lines));
  }
  ROWS.forEach(([title, read], at) => {
    const cell = table.tBodies[0].rows[at].cells[1];
    const text = now === undefined ? "–" : read(now, method);
    if (cell.textContent !== text) {
      const isState = title === "state" && now !== undefined;
      cell.replaceChildren(...(isState ? [htmlNode("span", { class: `key ${text}` })] : []), text);
    }
  });
}

export const FRAMES = 300;
const STATES = ["tracking", "leaving", "uncertain", "lost"];

/** Returns charts for graph.js, of the answers of `method` in `around` (see answers.js); empty charts if it is undefined. */
export function chartsOf(place, look, method, around) {
  const lines = (column, read) => (around === undefined ? [] : [{ title: "", look, numbers: around.last("number"), values: around.last(column).map(read) }]);
  const part = (value) => value / 65535;
  const curve = (title, column) => ({ place, title, most: 1, digits: 3, lines: lines(column, part) });
  return [
    { place, title: "States", bands: lines("state", (state) => STATES[state]) },
    curve("Confidence", "confidence"),
    ...(method === "paper" ? [] : [curve("Identity", "identity")]),
    curve("Ratio", "ratio"),
  ];
}
