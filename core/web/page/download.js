// Files for the user. They are made here, and saved by the browser.

import { htmlNode } from "./dom.js";

const TYPES = { csv: "text/csv", jsonl: "application/x-ndjson", smr: "application/octet-stream" };

/** Saves `content`, text or bytes, under `name`. */
export function save(name, content) {
  const type = TYPES[name.split(".").at(-1)];
  const address = URL.createObjectURL(new Blob([content], { type }));
  htmlNode("a", { href: address, download: name }).click();
  // The browser reads it later.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
