// Colors of colors.css, for canvases. They are read again after a switch between light and dark.

import { htmlNode } from "./dom.js";

const TARGETS = 8;
const NAMES = "ink faint rule panel focus tracking leaving uncertain lost gone".split(" ");

const known = new Map();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => known.clear());

/** Returns the colors of the page by name or, with the scheme "dark", those on frames. */
export const palette = (scheme = "") => kept(scheme, () => Object.fromEntries(NAMES.map((name) => [name, read(name, scheme).color])));

/** Returns the color of the target `id`. */
export const colorOf = (id) => kept(id, () => read(`target${((id - 1) % TARGETS) + 1}`).color);

/**
 * Returns the colors of a line on a frame and on the page, and its dashes (pixels): those of a target for `target` and its
 * id, or else those of the CSS class `look-NAME`.
 */
export const lookOf = (name) => kept(`look-${name}`, (look) => {
  const [, id] = /^target(\d+)$/.exec(name) ?? [];
  if (id !== undefined) {
    return { onFrame: colorOf(id), onPage: colorOf(id), dash: [] };
  }
  const { color: onPage, dashes } = read("line", "", look);
  return { onFrame: read("line", "dark", look).color, onPage, dash: dashes === "none" ? [] : dashes.split(" ").map(Number) };
});

function kept(key, read) {
  if (!known.has(key)) {
    known.set(key, read(key));
  }
  return known.get(key);
}

function read(name, scheme = "", look = "") {
  const probe = htmlNode("i", { class: look });
  Object.assign(probe.style, { color: `var(--${name})`, colorScheme: scheme });
  document.body.append(probe);
  const style = getComputedStyle(probe);
  const read = { color: style.color, dashes: style.getPropertyValue("--dashes").trim() };
  probe.remove();
  return read;
}
