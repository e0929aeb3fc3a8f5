// The menu of files that the user can save, and the list of files that are being written.

import { quoted } from "./command.js";
import { byId, htmlNode } from "./dom.js";
import { nameOf } from "./edits.js";

const FORMATS = { csv: "CSV", json: "JSON", tld: "TLD", vot: "VOT", otb: "OTB", got10k: "GOT-10k", mot: "MOT", coco: "COCO", cvat: "CVAT XML", record: "Flight record", session: "Session" };
const ONE_TARGET = "holds one target only";
const SHOWN = { "box,name": "boxes and names", "box,name,trail": "boxes, names, trails", box: "boxes", trail: "trails", nothing: "nothing drawn" };
const MIN_DONE = 0.05; // less says little about the time that is left
const NO_BOX = "draw a box first";

/**
 * Fills the menu. `formats` are the formats of boxes { name, several }, with `several` true if a file can store several
 * targets; `films` are the file extensions of videos. `take(name)` saves boxes in a format. `make(what, options)`
 * starts to write a video, report or recording; `make` is undefined if none can be written.
 */
export function drawMenu(place, { formats, films }, { take, make }) {
  const boxes = ({ name, several }) => button(FORMATS[name] ?? name, { "data-several": several }, () => take(name));
  const only = (format) => formats.filter(({ name }) => name === format).map(boxes);
  const others = formats.filter(({ name }) => !["csv", "session"].includes(name)).map(boxes);
  const draw = htmlNode("select", { id: "draw" }, ...Object.entries(SHOWN).map(([value, text]) => htmlNode("option", { value }, text)));
  const crop = htmlNode("input", { type: "checkbox", id: "crop" });
  const film = (as) => button(`Video (.${as})`, {}, () => make("film", { as, draw: draw.value, crop: crop.checked ? Number(crop.value) : null }));
  const made = make === undefined || films.length === 0 ? [] : [...films.map(film), htmlNode("label", {}, "with ", draw), htmlNode("label", {}, crop, " cropped to ", htmlNode("span", { id: "cropped" }, "the target"))];
  const lines = [
    ["To watch and to show", made],
    ["For a spreadsheet, R or Python: a line for each frame", only("csv")],
    ["With curves and events, to send", make === undefined ? [] : [button("Report (.html)", {}, () => make("report", {}))]],
    ["What you have checked, as truth: a folder for host-sim eval", make === undefined ? [] : [button("Recording with truth", { id: "recording" }, () => make("recording", {}))]],
    ["Your work, to open here again; beside the video, host-sim view opens it", only("session")],
    ["The boxes, for other programs", others],
  ];
  place.replaceChildren(...lines.filter(([, nodes]) => nodes.length > 0).map(([title, nodes]) => htmlNode("div", { class: "controls", role: "group", "aria-label": title }, ...nodes, htmlNode("small", {}, title))));
}

/** Disables the formats that cannot store `count` targets, and shows the reason and the target that a video is cropped to. */
export function drawLimits(place, count, chosen) {
  const isWriting = byId("made").querySelector("progress[aria-label$=truth]") !== null;
  for (const node of place.querySelectorAll("button")) {
    const why = count === 0 ? NO_BOX : isWriting && node.id === "recording" ? "It is being written." : count > 1 && node.dataset.several === "false" ? ONE_TARGET : "";
    node.disabled = why !== "";
    node.title = why;
  }
  const isLimited = count > 1 && place.querySelector("[data-several=false]") !== null;
  const crop = byId("crop");
  if (crop !== null && chosen !== null) {
    crop.value = chosen.id;
    byId("cropped").textContent = nameOf(chosen);
  }
  byId("limits").textContent = count === 0 ? "Draw a box first." : isLimited ? "Gray formats hold one target." : "";
}

/** Shows the progress of a file, or the link to it, in a line of the list. `cancel(id)` stops writing it. */
export function drawMade(place, { id, name, done, file, folder, error, cancelled }, cancel) {
  const line = byId(`made${id}`) ?? newLine(place, `made${id}`);
  if (folder) {
    line.replaceChildren(`${folder[1]}. To measure trackers: `, htmlNode("code", {}, `host-sim eval ${quoted(folder[0])}`));
  } else if (file) {
    line.replaceChildren("Ready: ", htmlNode("a", { href: `made/${id}`, download: file }, file));
  } else if (error || cancelled) {
    line.replaceChildren(cancelled ? `${name} was cancelled.` : `${name}: ${error}`);
  } else {
    drawProgress(line, { id, name, done }, cancel);
  }
}

function drawProgress(line, { id, name, done }, cancel) {
  if (line.querySelector("progress") === null) {
    line.dataset.since = performance.now();
    line.replaceChildren(`${name} `, htmlNode("progress", { max: 1, "aria-label": name }), htmlNode("span", {}), " ", button("Cancel", { "aria-label": `Cancel ${name}` }, () => cancel(id)));
  }
  if (typeof done === "number") {
    line.querySelector("progress").value = done;
    const left = Math.ceil((((performance.now() - line.dataset.since) / 1000) * (1 - done)) / done);
    line.querySelector("span").textContent = `${Math.floor(100 * done)} %${done < MIN_DONE ? "" : `, ${left} s left`}`;
  }
}

/** Shows the number of frames in the saved file `name`, which the name states if tracking was not complete. */
export function drawTaken(place, name) {
  const [, frames, all] = /-(\d+)(?:-of-(\d+))?-frames\.\w+$/.exec(name) ?? [];
  byId("taken")?.remove();
  if (frames !== undefined) {
    const said = [frames, all].filter(Boolean).map((count) => Number(count).toLocaleString("en")).join(" of ");
    newLine(place, "taken").replaceChildren(`${name} holds ${said} frames: save it again when all are followed.`);
  }
}

function button(text, attributes, act) {
  const node = htmlNode("button", { type: "button", ...attributes }, text);
  node.addEventListener("click", act);
  return node;
}

function newLine(place, id) {
  const line = htmlNode("div", { id });
  place.prepend(line);
  place.hidden = false;
  return line;
}
