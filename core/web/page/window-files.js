// What the user takes away: files that host-sim makes, and command lines that repeat what was done.

import { initsOf } from "./command.js";
import { byId, htmlNode } from "./dom.js";
import { nameOf } from "./edits.js";

const FORMATS = { csv: "CSV", json: "JSON", tld: "TLD", vot: "VOT", otb: "OTB", got10k: "GOT-10k", mot: "MOT", coco: "COCO", cvat: "CVAT XML" };

/** The links and buttons for files. `make(what, options)` begins one. */
export function drawFiles(place, { formats, films, live }, make) {
  const links = formats.map((format) => htmlNode("a", { href: `boxes?format=${format}`, download: "" }, FORMATS[format] ?? format));
  const button = (text, what, options) => {
    const node = htmlNode("button", { type: "button" }, text);
    node.addEventListener("click", () => make(what, options));
    return node;
  };
  const videos = films.map((as) => button(`.${as}`, "film", { as }));
  const groups = [["Boxes", links], ["Video with boxes", videos], ["", live ? [] : [button("Report", "report", {})]]];
  place.replaceChildren(...groups.flatMap(([title, nodes]) => (nodes.length === 0 ? [] : [title, ...nodes])));
}

/** How far a file is, or where it is. */
export function drawMade(place, { id, done, file, error }) {
  place.hidden = false;
  if (error !== undefined) {
    place.replaceChildren(error);
  } else if (file === undefined) {
    place.replaceChildren(`The file is being made: ${Math.floor(100 * done)} %.`);
  } else {
    place.replaceChildren("The file is there: ", htmlNode("a", { href: `made/${id}`, download: file }, file));
  }
}

/** The lines that repeat what was done. `verbs`: { track: "--video out.mp4", ... }, what follows after the boxes. */
export function drawCommands(place, verbs, { words, method, options }, targets) {
  const shown = Object.keys(TITLES).filter((verb) => verb in verbs);
  if (place.children.length === 0) {
    place.append(...shown.map(line));
  }
  const named = targets.map((target) => ({ name: nameOf(target), locks: target.locks }));
  const inits = initsOf(named, targets.length > 1 || targets.some(({ name }) => name !== ""));
  const chosen = Object.entries(options ?? {}).map(([name, value]) => `--${name} ${value}`);
  for (const verb of shown) {
    const parts = ["host-sim", verb, words, ...inits, method && `--method ${method}`, ...chosen, verbs[verb]];
    write(verb, targets.length === 0 ? "Drag a box first." : parts.filter(Boolean).join(" "));
    document.querySelector(`[data-of=${verb}]`).disabled = targets.length === 0;
  }
}

function write(id, text) {
  if (byId(id).textContent !== text) {
    byId(id).textContent = text;
  }
}

const TITLES = { track: "The command that follows it", report: "The command that makes a page of it", view: "The command that opens it again" };

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
