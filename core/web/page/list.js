// The list of targets, in which the user chooses, renames and removes them.

import { htmlNode } from "./dom.js";
import { reveal } from "./events.js";
import { colorOf } from "./palette.js";

/** Fills the element `place` with `targets` { id, name }; the functions are called on the user's actions. */
export function drawList(place, { targets, chosen, choose, remove, rename }) {
  const shown = targets.map(({ id, name }) => `${id}${name}`).join() + chosen?.id;
  if (place.dataset.shown === shown) {
    return;
  }
  place.dataset.shown = shown;
  const hadFocus = place.contains(document.activeElement);
  place.replaceChildren(...targets.map((target) => line(target, target.id === chosen?.id, { choose, remove, rename })));
  const item = place.querySelector(".chosen");
  if (item !== null) {
    reveal(place, item);
  }
  if (hadFocus) {
    item?.querySelector("input").focus();
  }
}

function line(target, isChosen, { choose, remove, rename }) {
  const radio = htmlNode("input", { type: "radio", name: "target", value: target.id });
  radio.checked = isChosen;
  radio.setAttribute("aria-label", `Target ${target.name}`);
  radio.addEventListener("change", () => choose(target));
  const button = htmlNode("button", { type: "button", "aria-label": `Remove target ${target.name}`, title: `Remove ${target.name} with all its boxes` }, "✕");
  button.addEventListener("click", () => remove(target));
  const item = htmlNode("li", isChosen ? { class: "chosen" } : {}, htmlNode("label", { class: "of" }, radio), nameField(target, rename), htmlNode("span", { class: "now" }), button);
  item.style.setProperty("--of", colorOf(target.id));
  return item;
}

function nameField(target, rename) {
  const field = htmlNode("input", { type: "text", maxlength: 40, list: "names", value: target.name, "aria-label": `Name of ${target.name}` });
  field.addEventListener("change", () => {
    // Shows the old name again: if the new name is refused or empty, the list may not be redrawn.
    rename(target, field.value);
    field.value = target.name;
  });
  return field;
}
