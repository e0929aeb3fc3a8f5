// Converts the tracker's settings between form fields of the page and options of host-sim.

import { optionsOf } from "./command.js";
import { byId, htmlNode } from "./dom.js";
import { SETTINGS, TITLES } from "./methods.js";

const NUMBERS = ["reach", "sweep"];
const SWITCHES = ["size", "refiner"];

/** Fills the form with the available `methods`, the chosen one and its options. */
export function showTracker({ methods, method, options: { set = [], config } }) {
  byId("method").replaceChildren(...methods.map((one) => htmlNode("option", { value: one }, TITLES[one])));
  const given = Object.fromEntries(set.map((one) => one.split("=")));
  for (const name of NUMBERS) {
    const value = given[name] ?? SETTINGS.robust[name];
    if (![...byId(name).options].some((option) => option.value === String(value))) {
      byId(name).append(htmlNode("option", {}, value));
    }
    byId(name).value = value;
  }
  SWITCHES.forEach((part) => (byId(part).checked = !["off", "0"].includes(given[part])));
  byId("refiner").checked &&= config !== "robust" || "refiner" in given;
  byId("config").value = method === "paper" ? (config ?? "paper") : SETTINGS.paper.config;
  byId("method").value = method;
  showMethod();
}

/** Shows only the fields of the chosen method. */
export function showMethod() {
  document.querySelectorAll("[data-method]").forEach((node) => (node.hidden = node.dataset.method !== byId("method").value));
}

/** Reads the method and its options from the form. Options without a field are copied from `before`. */
export function chosenTracker(before) {
  const method = byId("method").value;
  const { set = [], config, ...others } = method === before.method ? before.options : {};
  const valueOf = (name) => (NUMBERS.includes(name) ? Number(byId(name).value) : byId(name).checked);
  const robust = Object.fromEntries([...NUMBERS, ...SWITCHES].map((name) => [name, valueOf(name)]));
  const { set: own = [], ...options } = optionsOf(method, { robust, paper: { config: byId("config").value } });
  const all = [...set.filter((one) => !(one.split("=")[0] in robust)), ...own];
  return { method, options: { ...others, ...options, ...(all.length === 0 ? {} : { set: all }) } };
}
