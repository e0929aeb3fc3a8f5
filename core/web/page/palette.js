// The colors of the page's style, for what is drawn on a canvas. They change when the user goes from light to dark.

const NAMES = ["ink", "faint", "rule", "panel", "tracking", "leaving", "uncertain", "lost"];

let colors = null;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colors = null;
});

/** Colors by name; of each method { onFrame, onPage, dash }. */
export function palette() {
  colors ??= read();
  return colors;
}

function read() {
  const page = getComputedStyle(document.documentElement);
  const named = NAMES.map((name) => [name, page.getPropertyValue(`--${name}`).trim()]);
  return { ...Object.fromEntries(named), robust: look("robust"), smr: look("smr") };
}

function look(method) {
  const probe = document.createElement("i");
  probe.className = `look-${method}`;
  document.body.append(probe);
  const style = getComputedStyle(probe);
  const [onFrame, onPage, dashes] = ["--c", "--line", "--dashes"].map((name) => style.getPropertyValue(name).trim());
  probe.remove();
  return { onFrame, onPage, dash: dashes === "none" ? [] : dashes.split(" ").map(Number) };
}
