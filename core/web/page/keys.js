// The keys of the application.

import { choose, undo, unlock } from "./boxes.js";
import { byId } from "./dom.js";
import { closeMenu } from "./files.js";
import { endMeasuring } from "./length.js";
import { app, say } from "./state.js";

export function pressed(event) {
  const { key, target, ctrlKey, metaKey, altKey, shiftKey } = event;
  const isTyping = target.matches("input[type=text], select, textarea");
  // Radio buttons handle the arrow keys themselves; buttons and links handle the space bar.
  const isOwn = key === " " ? target.matches("button, a, summary, input:not([type=range])") : target.matches("input[type=radio]");
  if (event.defaultPrevented || altKey) {
    return;
  }
  if (key === "Escape") {
    if (closed() || (!isTyping && escaped())) {
      event.preventDefault();
    }
  } else if (isTyping) {
    return;
  } else if (ctrlKey || metaKey) {
    const isRedo = key.toLowerCase() === "y" || shiftKey;
    if (["z", "y"].includes(key.toLowerCase())) {
      event.preventDefault();
      undo(isRedo);
    }
  } else if (!isOwn && acted(event)) {
    event.preventDefault();
  }
}

function acted(event) {
  const own = { Delete: unlock, Backspace: unlock, "?": () => byId("help").togglePopover() }[event.key];
  own?.();
  const isActed = own !== undefined || app.playback.key(event) || app.viewport.key(event) || app.truth.key(event);
  if (isActed) {
    say("");
  }
  return isActed;
}

// Closes the help, ends measuring a length or closes the menu of files. Returns false if there is nothing to end.
function closed() {
  const [help, menu] = [byId("help"), byId("export")];
  if (help.matches(":popover-open")) {
    help.hidePopover();
    return true;
  }
  if (app.measured !== null) {
    endMeasuring();
    return true;
  }
  const isOpen = menu.open;
  closeMenu();
  return isOpen;
}

// Drops a box that is not taken yet or, if there is none, stops adding a target.
function escaped() {
  if (app.proposed !== null) {
    app.drag.drop();
  } else if (app.edits.chosen === null) {
    choose(app.edits.targets.at(-1) ?? null);
  }
  return true;
}
