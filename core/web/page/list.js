// The list of targets: chooses and removes them.

import { htmlNode } from "./dom.js";

/** `page`: { targets, chosen, choose(target), remove(target) }. */
export function drawList(place, { targets, chosen, choose, remove }) {
  const shown = targets.map(({ id, isFollowed }) => `${id}${isFollowed}`).join() + chosen?.id;
  if (place.dataset.shown === shown) {
    return;
  }
  place.dataset.shown = shown;
  const hadFocus = place.contains(document.activeElement);
  place.replaceChildren(...targets.map((target) => line(target, target === chosen, choose, remove)));
  if (hadFocus) {
    place.querySelector("input:checked")?.focus();
  }
}

function line(target, isChosen, choose, remove) {
  const radio = htmlNode("input", { type: "radio", name: "target", value: target.id });
  radio.checked = isChosen;
  radio.addEventListener("change", () => choose(target));
  const words = target.isFollowed ? "" : ": drag a box over it";
  const button = htmlNode("button", { type: "button", "aria-label": `Remove target ${target.name}` }, "Remove");
  button.addEventListener("click", () => remove(target));
  const label = htmlNode("label", {}, radio, `Target ${target.name}${words}`);
  return htmlNode("li", isChosen ? { class: "chosen" } : {}, label, button);
}
