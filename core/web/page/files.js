// Files that the user saves or opens: boxes, videos, reports.

import { changed } from "./boxes.js";
import { byId, htmlNode } from "./dom.js";
import { drawMade, drawTaken } from "./exports.js";
import { app, say, trying } from "./state.js";
import { showTracker } from "./tracker-settings.js";

const TYPES = { csv: "text/csv", json: "application/json", jsonl: "application/x-ndjson", smr: "application/octet-stream" };

/** Lets the browser save `content` (text, bytes or a blob) as the file `name`. */
function save(name, content) {
  const type = TYPES[name.split(".").at(-1)];
  const address = URL.createObjectURL(new Blob([content], { type }));
  htmlNode("a", { href: address, download: name }).click();
  // The address is revoked later, because the browser reads the file after this call.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Closes the menu of files. If it has the focus, its button gets it. */
export function closeMenu() {
  const menu = byId("export");
  if (menu.open && menu.contains(document.activeElement)) {
    menu.firstElementChild.focus();
  }
  menu.open = false;
}

export async function take(format) {
  closeMenu();
  await app.truth.send();
  const file = await trying(app.source.boxes(format, app.edits.chosen));
  if (file !== "") {
    save(file.name, file.bytes);
    drawTaken(byId("made"), file.name);
  }
}

export async function make(what, options) {
  closeMenu();
  await app.truth.send();
  const made = await trying(app.source.make(what, options));
  if (made !== "" && !byId(`made${made.id}`)) {
    drawMade(byId("made"), made, cancel);
  }
}

export const cancel = (id) => trying(app.source.cancel(id));

// Replaces the work on the recording by that of a session. The targets can be undone.
async function resume({ using, targets, ids, length }) {
  const { edits, recording } = app;
  if (JSON.stringify(using) !== JSON.stringify({ method: recording.method, options: recording.options })) {
    Object.assign(recording, using);
    edits.forget();
    await trying(app.source.method(using.method, using.options));
    showTracker(recording);
  }
  recording.length = length;
  await trying(app.source.length(length));
  edits.resume(targets, ids);
  await changed();
}

// Reads a file that the user chose or dropped: boxes, or a video if the source accepts one.
export async function read(file) {
  if (file === undefined) {
    return;
  }
  say("");
  closeMenu();
  byId("boxes").value = "";
  app.truth.send();
  const found = await trying(app.source.read(file));
  if (found.using) {
    await resume(found);
  } else if (found !== "") {
    app.edits.add(found);
    await changed();
  }
}
