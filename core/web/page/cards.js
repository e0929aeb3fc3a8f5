// Template, difference and response map of the chosen target, in the shades of the page of `host-sim report`.

import { htmlNode, sample } from "./dom.js";
import { METHODS, SHORT } from "./methods.js";

// Differences above this are drawn as bright as this.
const BRIGHTEST = 127;
const bright = (level) => Math.floor(Math.sqrt((255 * 255 * Math.min(level, BRIGHTEST)) / BRIGHTEST));
const GRAY = (shade) => [shade, shade, shade];
const GREEN = (shade) => [Math.floor(shade / 3), 105 + Math.floor(shade / 3), 65 + Math.floor(shade / 3)];

export class Cards {
  #cards;

  constructor(place) {
    this.#cards = Object.fromEntries(METHODS.map((method) => [method, card(place, method)]));
  }

  draw(target, on) {
    for (const method of METHODS) {
      const now = on[method] ? target?.now[method] : undefined;
      this.#cards[method].whole.hidden = !now?.pictures;
      if (now?.pictures) {
        drawCard(this.#cards[method], method, now);
      }
    }
  }
}

function card(place, method) {
  const [first, second] = [htmlNode("canvas", { role: "img" }), htmlNode("canvas", { role: "img" })];
  first.setAttribute("aria-label", `template of ${SHORT[method]}`);
  second.setAttribute("aria-label", method === "robust" ? "response map of Robust" : "differences of Paper");
  const words = htmlNode("span", {});
  const whole = htmlNode("figure", { class: "card" }, htmlNode("div", { class: "pair" }, first, second), htmlNode("figcaption", {}, sample(method), words));
  whole.hidden = true;
  place.append(whole);
  return { whole, first, second, words };
}

function drawCard({ first, second, words }, method, { pictures, alpha, state, confidence }) {
  const { template, difference, responseMap } = pictures;
  paint(first, template, GRAY);
  if (responseMap !== undefined) {
    const { span, responses } = responseMap;
    const [least, most] = responses.reduce(([low, high], one) => [Math.min(low, one), Math.max(high, one)], [0, 1]);
    paint(second, { width: span, height: span, pixels: Uint8Array.from(responses, (one) => (255 * (one - least)) / (most - least)) }, GRAY);
    words.textContent = `${SHORT[method]}: highest response ${(most / 16384).toFixed(2)}, confidence ${(confidence / 65535).toFixed(2)}`;
  } else {
    paint(second, difference, (level) => (level < alpha ? GREEN(bright(level)) : GRAY(bright(level))));
    const counting = difference.pixels.filter((level) => level < alpha).length / difference.pixels.length;
    const believed = state === "lost" ? ", at its last place" : "";
    words.textContent = `${SHORT[method]}: ${Math.round(100 * counting)}% of the pixels count, alpha ${alpha}${believed}`;
  }
}

function paint(canvas, { width, height, pixels }, colorOf) {
  if (canvas.width !== width || canvas.height !== height) {
    [canvas.width, canvas.height] = [width, height];
    canvas.style.aspectRatio = `${width} / ${height}`;
  }
  const image = new ImageData(width, height);
  pixels.forEach((level, at) => image.data.set([...colorOf(level), 255], 4 * at));
  canvas.getContext("2d").putImageData(image, 0, 0);
}

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
