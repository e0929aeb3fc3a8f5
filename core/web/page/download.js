// Files for the user. The page makes them, and the browser saves them.

import { htmlNode } from "./dom.js";

const TYPES = { csv: "text/csv", jsonl: "application/x-ndjson", smr: "application/octet-stream" };

/** Saves `content`, text, bytes or a blob, under `name`. */
export function save(name, content) {
  const type = TYPES[name.split(".").at(-1)];
  const address = URL.createObjectURL(new Blob([content], { type }));
  htmlNode("a", { href: address, download: name }).click();
  // Later, because the browser reads the file after this call.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
