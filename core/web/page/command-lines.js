// Shows the command lines of host-sim that repeat the user's work.

import { initsOf, typed } from "./command.js";
import { byId, htmlNode } from "./dom.js";
import { nameOf } from "./edits.js";

const TITLES = { view: "The command that opens it again", track: "The command that follows it", report: "The command that makes a page of it" };

/** `verbs` maps subcommands to their last arguments, such as { report: "-o report.html" }. */
export function drawCommands(place, verbs, { words, method, options, length }, targets) {
  const shown = Object.keys(TITLES).filter((verb) => verb in verbs);
  if (place.dataset.shown !== shown.join()) {
    place.dataset.shown = shown.join();
    place.replaceChildren(...shown.map(line));
  }
  const named = targets.map((target) => ({ name: nameOf(target), locks: target.locks }));
  const inits = initsOf(named, targets.length > 1 || targets.some(({ name }) => name !== ""));
  const chosen = typed(options);
  for (const verb of shown) {
    const metres = length && verb !== "report" ? `--pixels-per-metre ${length.pixels_per_metre}` : "";
    const parts = ["host-sim", verb, words, ...inits, `--method ${method}`, ...chosen, metres, verbs[verb]];
    write(verb, targets.length === 0 ? "Drag a box first." : parts.filter(Boolean).join(" "));
    document.querySelector(`[data-of=${verb}]`).disabled = targets.length === 0;
  }
}

// Writes a command line that breaks only between words, not after the hyphens of an option.
function write(id, text) {
  if (byId(id).textContent !== text) {
    const words = text.split(" ").flatMap((word) => [" ", htmlNode("span", { class: "word" }, word)]);
    byId(id).replaceChildren(...words.slice(1));
  }
}

function line(verb) {
  const text = htmlNode("pre", { id: verb, tabindex: 0, "aria-label": TITLES[verb] });
  const button = htmlNode("button", { type: "button", "data-of": verb, "aria-label": `Copy: ${TITLES[verb]}` }, "Copy");
  button.addEventListener("click", () => copy(button, text));
  return htmlNode("div", { class: "line" }, text, button);
}

async function copy(button, text) {
  try {
    await navigator.clipboard.writeText(text.textContent);
    button.textContent = "Copied";
  } catch {
    // If the clipboard is refused, selects the text and copies it by an older command, or leaves that to the user.
    getSelection().selectAllChildren(text);
    button.textContent = document.execCommand("copy") ? "Copied" : "Selected";
  }
  setTimeout(() => (button.textContent = "Copy"), 2000);
}
