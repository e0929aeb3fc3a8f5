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
  ["alpha", (now) => whole(now.alpha)],
  ["size", (now) => part(now.scale, 65536)],
  ["box", (now) => (now.state === "lost" ? "–" : placed(now.box))],
  ["work", (now) => millions(now.work)],
  ["Cortex-M4", (now, method) => about(instructions(method, now).m4)],
  ["Cortex-M55", (now, method) => about(instructions(method, now).m55)],
];

export class Figures {
  #table;
  #cells = new Map(); // by method and title of the row
  #shown = "";

  constructor(table) {
    this.#table = table;
  }

  draw(target, on) {
    const methods = METHODS.filter((method) => on[method]);
    if (this.#shown !== methods.join()) {
      this.#shown = methods.join();
      this.#make(methods);
    }
    for (const method of methods) {
      const now = target?.now[method] ?? {};
      for (const [title, read] of ROWS) {
        this.#write(method, title, now.state === undefined ? "–" : read(now, method));
      }
    }
  }

  #make(methods) {
    const heads = methods.map((method) => htmlNode("th", { scope: "col" }, sample(method), SHORT[method]));
    const lines = ROWS.map(([title]) => {
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
