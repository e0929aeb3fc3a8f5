// The table of the chosen target: the answer of each tracker for this frame, and its cost.

import { about, instructions } from "./cost.js";
import { htmlNode, sample } from "./dom.js";
import { METHODS, SHORT } from "./methods.js";

const part = (value, unit) => (value === undefined || value === null ? "–" : (value / unit).toFixed(3));
const whole = (value) => (value === undefined || value === null ? "–" : String(value));
const millions = (value) => (value === undefined ? "–" : `${(value / 1e6).toFixed(2)} M`);
const placed = (box) => (box ? [box.x, box.y, box.width, box.height].map((side) => Math.round(side)).join(", ") : "–");

const STATES = ["tracking", "leaving", "uncertain", "lost"];
const ROWS = [
  ["state", (now) => now.state],
  ["confidence", (now) => part(now.confidence, 65535)],
  ["ratio", (now) => part(now.ratio, 65535)],
  ["runner-up", (now) => part(now.runnerUpRatio, 65535)],
  ["alpha", (now) => whole(now.alpha)],
  ["size", (now) => part(now.scale, 65536)],
  ["box", (now) => (now.state === "lost" ? "–" : placed(now.box))],
  ["work", (now) => millions(now.work)],
  ["time here", (_, time) => (Number.isNaN(time) ? "–" : `${time.toFixed(1)} ms`)],
  ["Cortex-M4", (now, _, method) => about(instructions(method, now).m4)],
  ["Cortex-M55", (now, _, method) => about(instructions(method, now).m55)],
];

export class Figures {
  #table;
  #rows;
  #cells = new Map(); // by method and title of the row
  #shown = "";

  /** `without`: titles of rows that are left out. */
  constructor(table, without = []) {
    this.#table = table;
    this.#rows = ROWS.filter(([title]) => !without.includes(title));
  }

  draw(target, on) {
    const methods = METHODS.filter((method) => on[method]);
    if (this.#shown !== methods.join()) {
      this.#shown = methods.join();
      this.#make(methods);
    }
    for (const method of methods) {
      const now = target?.now[method] ?? {};
      const time = target?.time(method);
      for (const [title, read] of this.#rows) {
        this.#write(method, title, now.state === undefined ? none(now, title) : read(now, time, method));
      }
    }
  }

  #make(methods) {
    const heads = methods.map((method) => htmlNode("th", { scope: "col" }, sample(method), SHORT[method]));
    const lines = this.#rows.map(([title]) => {
      const cells = methods.map((method) => {
        const cell = htmlNode("td", {});
        this.#cells.set(`${method} ${title}`, cell);
        return cell;
      });
      return htmlNode("tr", {}, htmlNode("th", { scope: "row" }, title), ...cells);
    });
    const head = htmlNode("thead", {}, htmlNode("tr", {}, htmlNode("th", { scope: "col" }, "this frame"), ...heads));
    this.#table.replaceChildren(head, htmlNode("tbody", {}, ...lines));
  }

  #write(method, title, text) {
    const cell = this.#cells.get(`${method} ${title}`);
    if (cell.textContent !== text) {
      const isState = title === "state" && STATES.includes(text);
      cell.replaceChildren(...(isState ? [htmlNode("span", { class: `key ${text}` })] : []), text);
    }
  }
}

function none({ error }, title) {
  return title === "state" && error !== undefined ? "refused" : "–";
}
