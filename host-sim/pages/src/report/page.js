// The state of the page, and what all parts of its script use. Everything that is shown follows from three things: the recording,
// the frame (its index; the numbers that are shown begin with `recording.first`), and who is switched on. See page.html.

const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const TRUTH = "ground truth";
const off = new Set();
let recording = data.recordings[0];
let frame = 0;
let timer = null;
let panels = [];

const svgNode = (name, attributes, text) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  return node;
};
const htmlNode = (name, attributes, ...children) => {
  const node = document.createElement(name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  node.append(...children);
  return node;
};
const clamp = (value, least, most) => Math.min(Math.max(value, least), most);
const shown = () => recording.entrants.filter((entrant) => !off.has(entrant.name));
const isVisible = (index) => recording.truth === null || recording.truth[index] !== null;
/** The number of a frame as it is shown. */
const numberOf = (index) => index + recording.first;
const lastNumber = () => numberOf(recording.frames - 1);
/** A short line with the color and the dashes of a look; runners-up are dotted. */
function sample(look, isSecond) {
  const line = svgNode("svg", { class: `sample look-${look}${isSecond ? " second" : ""}`, viewBox: "0 0 52 6", "aria-hidden": "true" });
  line.append(svgNode("path", { d: "M0 3H52" }));
  return line;
}
