// The legend of differences.

import { htmlNode } from "./dom.js";

// Differences above this are drawn as bright as this.
const BRIGHTEST = 127;
const bright = (level) => Math.floor(Math.sqrt((255 * 255 * Math.min(level, BRIGHTEST)) / BRIGHTEST));
const GRAY = (shade) => [shade, shade, shade];
const GREEN = (shade) => [Math.floor(shade / 3), 105 + Math.floor(shade / 3), 65 + Math.floor(shade / 3)];

/** The legend for the shades of a difference. */
export function drawScale(place) {
  const stops = (color) => Array.from({ length: 17 }, (_, at) => `rgb(${color(bright((at * BRIGHTEST) / 16)).join()})`).join(", ");
  const line = (text, color) => {
    const bar = htmlNode("span", { class: "ramp" });
    bar.style.background = `linear-gradient(to right, ${stops(color)})`;
    return htmlNode("div", {}, htmlNode("span", {}, "0"), bar, htmlNode("span", {}, `127+ ${text}`));
  };
  place.replaceChildren(line("gray levels", GRAY), line("that count", GREEN));
}
