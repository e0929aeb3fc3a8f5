// The state of the page, and what all parts of its script use. Everything that is shown follows from three things: the recording,
// the frame (its index; the numbers that are shown begin with `recording.first`), and who is switched on. See page.html.

import { byId, htmlNode, sample } from "smr/dom.js";
import { clock, drawEvents, eventsOf, placeOf } from "smr/events.js";
import { palette } from "smr/palette.js";
import { Timeline } from "smr/timeline.js";

const data = JSON.parse(byId("data").textContent);
const TRUTH = "ground truth";
const off = new Set();
let recording = data.recordings[0];
let frame = 0;
let timer = null;
let panels = [];
let events = [];
const timeline = new Timeline(byId("timeline"), { goTo: (number) => goToNumber(number) });

const svgNode = (name, attributes, text) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  return node;
};
const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const shown = () => recording.entrants.filter((entrant) => !off.has(entrant.name));
const isVisible = (index) => recording.truth === null || recording.truth[index] !== null;
/** The number of a frame as it is shown. */
const numberOf = (index) => index + recording.first;
const lastNumber = () => numberOf(recording.frames - 1);
/** The time of the frame with this number in seconds; null if it is unknown. */
const timeOf = (number) => recording.times?.[number - recording.first] ?? null;
/** The first method of each target: its states are shown. */
const firsts = () => recording.targets.map((_, target) => recording.entrants.find((entrant) => entrant.target === target));
