// What the user takes away: files that host-sim makes, and command lines that repeat what was done.

import { initsOf, typed } from "./command.js";
import { byId, htmlNode } from "./dom.js";
import { nameOf } from "./edits.js";

const FORMATS = { csv: "CSV", json: "JSON", tld: "TLD", vot: "VOT", otb: "OTB", got10k: "GOT-10k", mot: "MOT", coco: "COCO", cvat: "CVAT XML" };

/** The buttons for files. `take(format)` saves boxes, `make(what, options)` begins a film or a report. */
export function drawFiles(place, { formats, films, live }, take, make) {
  const button = (text, act) => {
    const node = htmlNode("button", { type: "button" }, text);
    node.addEventListener("click", act);
    return node;
  };
  const boxes = formats.map((format) => button(FORMATS[format] ?? format, () => take(format)));
  const videos = films.map((as) => button(`.${as}`, () => make("film", { as })));
  const groups = [["Boxes", boxes], ["Video with boxes", videos], ["", live ? [] : [button("Report", () => make("report", {}))]]];
  place.replaceChildren(...groups.flatMap(([title, nodes]) => (nodes.length === 0 ? [] : [title, ...nodes])));
}

/** Writes the progress of a file, or the way to it, in the line of its number. */
export function drawMade(place, { id, done, file, error }) {
  const line = byId(`made${id}`) ?? newLine(place, `made${id}`);
  if (file) {
    line.replaceChildren("The file is there: ", htmlNode("a", { href: `made/${id}`, download: file }, file));
  } else {
    line.replaceChildren(error || (done === null ? "The file is being made." : `The file is being made: ${Math.floor(100 * done)} %.`));
  }
}

function newLine(place, id) {
  const line = htmlNode("div", { id });
  place.prepend(line);
  place.hidden = false;
  return line;
}

/** Says how far boxes are that were saved while targets are followed: their name tells. */
export function drawTaken(place, name) {
  const [, frames, all] = /-(\d+)(?:-of-(\d+))?-frames\.\w+$/.exec(name) ?? [];
  byId("taken")?.remove();
  if (frames !== undefined) {
    const said = [frames, all].filter(Boolean).map((count) => Number(count).toLocaleString("en")).join(" of ");
    newLine(place, "taken").replaceChildren(`${name} holds ${said} frames: save it again when all are followed.`);
  }
}

/** The lines that repeat what was done. `verbs`: { report: "-o report.html", ... }, what follows after the boxes. */
export function drawCommands(place, verbs, { words, method, options }, targets) {
  const shown = Object.keys(TITLES).filter((verb) => verb in verbs);
  if (place.children.length === 0) {
    place.append(...shown.map(line));
  }
  const named = targets.map((target) => ({ name: nameOf(target), locks: target.locks }));
  const inits = initsOf(named, targets.length > 1 || targets.some(({ name }) => name !== ""));
  const chosen = typed(options);
  for (const verb of shown) {
    const parts = ["host-sim", verb, words, ...inits, `--method ${method}`, ...chosen, verbs[verb]];
    write(verb, targets.length === 0 ? "Drag a box first." : parts.filter(Boolean).join(" "));
    document.querySelector(`[data-of=${verb}]`).disabled = targets.length === 0;
  }
}

// A line is broken between words only, not behind the hyphens of an option.
function write(id, text) {
  if (byId(id).textContent !== text) {
    const words = text.split(" ").flatMap((word) => [" ", htmlNode("span", { class: "word" }, word)]);
    byId(id).replaceChildren(...words.slice(1));
  }
}

const TITLES = { track: "The command that follows it", report: "The command that makes a page of it" };

function line(verb) {
  const text = htmlNode("pre", { id: verb, tabindex: 0, "aria-label": TITLES[verb] });
  const button = htmlNode("button", { type: "button", "data-of": verb, "aria-label": `Copy: ${TITLES[verb]}` }, "Copy");
  button.addEventListener("click", () => copy(button, text));
  return htmlNode("div", { class: "line" }, text, button);
}

async function copy(button, text) {
  try {
    await navigator.clipboard.writeText(text.textContent);
    button.textContent = "Copied";
  } catch {
    // Without the right to the clipboard, the text is there to be copied by hand.
    getSelection().selectAllChildren(text);
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
  setTimeout(() => (button.textContent = "Copy"), 2000);
}
