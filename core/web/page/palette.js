// The colors of the page's style, for canvases. They change when the user switches between light and dark.

const NAMES = ["ink", "faint", "rule", "panel", "tracking", "leaving", "uncertain", "lost"];

let colors = null;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colors = null;
});

/** The colors by name; for each method { onFrame, onPage, dash }. */
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
