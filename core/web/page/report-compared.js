// Shows what the trackers compared in a frame: templates, difference maps, and histograms of the differences.

import { byId, htmlNode, sample, svgNode } from "./dom.js";
import { placeOf } from "./events.js";

const HEIGHT = 170, LEFT = 56, RIGHT = 22, TOP = 10, BOTTOM = HEIGHT - 34;
const LABELS = 8;

/**
 * Shows what the `entrants` (methods) compared in frame `index` or, if it has no image, in the last frame before it
 * that has one. `data` describes the histograms: { bar: width of a bar in gray levels, bars: count of bars }.
 */
export function drawComparisons({ first, images: { every, comparisons } }, entrants, index, { timeOf, data }) {
  const at = Math.floor(index / every);
  const kept = at * every;
  const all = comparisons[at];
  const compared = entrants.filter(({ method }) => method !== null && all[method]).map((entrant) => ({ entrant, ...all[entrant.method], alpha: entrant.alpha?.[kept] ?? null }));
  const place = placeOf(first + kept, timeOf).replace(/^f/, "F");
  byId("compared").textContent = `${place}${kept === index ? "" : ", the nearest before with its picture"}${saidOf(compared, kept)}`;
  byId("comparisons").replaceChildren(...compared.map((one) => card(one, one.entrant.boxes[kept] !== null)));
  byId("scale").hidden = compared.length === 0;
  byId("histogram").toggleAttribute("hidden", compared.length === 0);
  if (compared.length > 0) {
    drawHistogram(byId("histogram"), compared, data);
  }
}

function saidOf(compared, kept) {
  if (compared.length > 0) {
    return ". Left: the template. Right: how much each pixel of the box differs from it; green pixels differ by less than alpha and count. Below: how many pixels differ by how many gray levels.";
  }
  return kept === 0 ? ": nothing is compared here, the trackers are locked on the target. Go to a later frame." : ": no method is switched on.";
}

function card({ entrant: { title, look }, template, map, counting }, isBelieved) {
  const image = (bytes, alt) => htmlNode("img", { src: `data:image/png;base64,${bytes}`, alt });
  const counts = counting === null ? "all pixels count" : `${Math.round(counting * 100)}% of the pixels count`;
  return htmlNode("figure", { class: "card" },
    htmlNode("div", { class: "pair" }, image(template, `template of ${title}`), image(map, `differences of ${title}`)),
    htmlNode("figcaption", {}, sample(look), `${title}: ${counts}${isBelieved ? "" : ", not believed"}`));
}

function drawHistogram(svg, compared, { bar, bars }) {
  const width = Math.max(280, svg.parentNode.clientWidth);
  const most = Math.max(10, ...compared.flatMap(({ histogram }) => histogram));
  const x = (at) => LEFT + ((width - LEFT - RIGHT) * at) / bars;
  const y = (part) => BOTTOM - ((BOTTOM - TOP) * part) / most;
  const rules = [0, most / 2, most].flatMap((part) => [
    svgNode("path", { class: "grid", d: `M${LEFT} ${y(part)}H${x(bars)}` }),
    svgNode("text", { x: LEFT - 6, y: y(part) + 4, "text-anchor": "end" }, `${(part / 10).toFixed(0)}%`),
  ]);
  const labels = Array.from({ length: LABELS + 1 }, (_, at) => (at * bars) / LABELS).map((at) =>
    svgNode("text", { x: x(at), y: BOTTOM + 14, "text-anchor": "middle" }, `${at * bar}${at === bars ? "+" : ""}`));
  const steps = compared.map(({ entrant: { look }, histogram }, place) => {
    const line = histogram.map((part, at) => `V${y(part).toFixed(1)}H${x(at + 1).toFixed(1)}`).join("");
    return svgNode("path", { class: `${place === 0 ? "bars" : "curve"} look-${look}`, d: `M${LEFT} ${BOTTOM}${line}V${BOTTOM}` });
  });
  const thresholds = compared.filter(({ alpha }) => alpha !== null).flatMap(({ entrant: { look, short }, alpha }, place) => {
    const at = x(Math.min(alpha / bar, bars));
    return [
      svgNode("path", { class: `threshold look-${look}`, d: `M${at} ${TOP}V${BOTTOM}` }), svgNode("text", { x: at + 4, y: TOP + 10 + 13 * place }, `alpha ${alpha} (${short})`),
    ];
  });
  const axis = svgNode("text", { x: x(bars), y: BOTTOM + 30, "text-anchor": "end" }, "difference in gray levels");
  svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
  svg.replaceChildren(...rules, ...steps, ...thresholds, ...labels, axis);
}
