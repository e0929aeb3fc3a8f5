// Bundles ES modules into one script: each becomes a function that returns its exports. Modules may import each other
// by name, but not in a cycle.

import { readFileSync } from "node:fs";

const IMPORT = /^import\s*\{([^}]*)\}\s*from\s*"(\.[^"]*)";\n/gm;
const EXPORT_FROM = /^export\s*\{([^}]*)\}\s*from\s*"(\.[^"]*)";\n/gm;
const EXPORT = /^export (?=(?:const|let|class|function\*?|async function) (\w+))/gm;
// A comment at the end of a line. It contains no quotes, so that text in quotes is not taken for a comment.
const REMARK = / \/\/ [^"'`\n]*$/gm;
const COMMENT = /^\s*(?:\/\/.*|\/\*\*.*\*\/|\/\*\*(?:[^*]|\*(?!\/))*\*\/)\n/gm;

/** Returns the script of the module at the URL `entry`, preceded by all modules that it imports. */
export function bundle(entry) {
  const places = new Map(); // the name of each module, by address
  const parts = [];
  add(entry, places, parts, []);
  return `${parts.join("")}`;
}

function add(address, places, parts, above) {
  if (above.includes(address.href)) {
    throw new Error(`${address.pathname} imports itself: expected modules without circles`);
  }
  if (places.has(address.href)) {
    return places.get(address.href);
  }
  const exported = [];
  const placeOf = (from) => add(new URL(from, address), places, parts, [...above, address.href]);
  const body = readFileSync(address, "utf8")
    .replace(IMPORT, (_, names, from) => `const {${names.replace(/ as /g, ":").replace(/\s+/g, "")}}=${placeOf(from)};\n`)
    .replace(EXPORT_FROM, (_, names, from) => {
      const place = placeOf(from);
      exported.push(...names.split(",").map((name) => `${name.trim()}:${place}.${name.trim()}`));
      return "";
    })
    .replace(EXPORT, (_, name) => {
      exported.push(name);
      return "";
    })
    .replace(COMMENT, "")
    .replace(REMARK, "")
    // Removes indentation and empty lines, which is safe because no string spans lines.
    .replace(/^ +/gm, "")
    .replace(/\n{2,}/g, "\n")
    // `import.meta` exists only in modules, but the worker of a page opened from disk cannot be a module.
    .replaceAll("import.meta.url", "self.location.href");
  const left = body.match(/^(?:import\s*[{"*\w]|export ).*/m);
  if (left !== null && !left[0].startsWith("import(")) {
    throw new Error(`${address.pathname}: cannot put this into one script: ${left[0]}`);
  }
  const place = `$${places.size}`;
  places.set(address.href, place);
  parts.push(`const ${place}=(() => {\n${body}return {${exported.join()}};\n})();\n`);
  return place;
}
