// Colors of the page's CSS, for canvases. They are read again after a switch between light and dark.

const NAMES = ["ink", "faint", "rule", "panel", "tracking", "leaving", "uncertain", "lost", "gone"];

let colors = null;
const looks = new Map();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colors = null;
  looks.clear();
});

export function palette() {
  colors ??= read();
  return colors;
}

function read() {
  const page = getComputedStyle(document.documentElement);
  return Object.fromEntries(NAMES.map((name) => [name, page.getPropertyValue(`--${name}`).trim()]));
}

/** Reads the CSS class `look-NAME`: returns its colors on a frame and on the page, and its dashes (pixels). */
export function lookOf(name) {
  if (!looks.has(name)) {
    looks.set(name, readLook(name));
  }
  return looks.get(name);
}

function readLook(name) {
  const probe = document.createElement("i");
  probe.className = `look-${name}`;
  document.body.append(probe);
  const style = getComputedStyle(probe);
  const [onFrame, onPage, dashes] = ["--c", "--line", "--dashes"].map((name) => style.getPropertyValue(name).trim());
  probe.remove();
  return { onFrame, onPage, dash: dashes === "none" ? [] : dashes.split(" ").map(Number) };
}
