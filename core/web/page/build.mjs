// Builds the stand-alone page: one self-contained HTML file. Requires Node, and the output of `.ci/web build`.
//
//   node core/web/page/build.mjs [OUT]          default: target/web/smr.html

import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { deflateSync } from "node:zlib";
import { bundle } from "./bundle.mjs";

const MAX_BYTES = 325_000;
const BUILT = new URL(`${process.env.SMR_WEB ?? "../../../target/web"}/`, import.meta.url);
const BASE = new URL("../../../host-sim/pages/src/report/base.css", import.meta.url);

const text = (name) => readFileSync(new URL(name, import.meta.url), "utf8");
const hash = (content) => `'sha256-${createHash("sha256").update(content).digest("base64")}'`;

// Returns the page's content security policy: no script can load or send anything.
function policy(style, script) {
  return [
    "default-src 'none'", `script-src ${hash(script)} 'wasm-unsafe-eval'`, "worker-src blob:", `style-src ${hash(style)}`, "img-src data:",
    "media-src blob: mediastream:", "base-uri 'none'", "form-action 'none'",
  ].join("; ");
}

function carried(worker) {
  const modules = ["smr-simd.wasm", "scene.wasm"].map((name) => [name, readFileSync(new URL(name, BUILT))]);
  const packed = ([name, bytes]) => `<script type="text/plain" id="${name}">${deflateSync(bytes, { level: 9 }).toString("base64")}</script>`;
  return [["worker.js", worker], ...modules].map(packed).join("\n");
}

// Returns the script, or throws if it contains text that would end its HTML element.
function inScript(script) {
  if (/<\/script|<!--/i.test(script)) {
    throw new Error("a script has what ends its element: </script or <!--");
  }
  return script;
}

// Returns the body of host-sim's viewer.html, with the stand-alone page's own heading and text.
function application() {
  const [, body] = /<body>\n([^]*)\{\{scripts\}\}/.exec(text("viewer.html"));
  const own = { '<h1 id="name"></h1>': text("lead.html"), "{{words}}": text("words.html") };
  return Object.entries(own).reduce((page, [from, to]) => {
    if (!page.includes(from)) {
      throw new Error(`viewer.html has no ${from}`);
    }
    return page.replace(from, () => to);
  }, body);
}

// The page compares no methods and no result files.
const colors = text("colors.css").replace(/ *--(sad|ssd|ncc|lk|truth|file\d+):.*\n/g, "");
const style = [colors, readFileSync(BASE, "utf8"), ...["page.css", "viewer.css", "local.css"].map(text)].join("").replace(/\/\*[^]*?\*\/\n?/g, "").replace(/\s*([{};])\s*/g, "$1").replace(/([:,]) /g, "$1");
const script = inScript(bundle(new URL("page.js", import.meta.url)));
const parts = { style, script, application: application(), policy: policy(style, script), data: carried(bundle(new URL("worker.js", import.meta.url))) };
const page = text("index.html").replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
const size = Buffer.byteLength(page);
if (size > MAX_BYTES) {
  throw new Error(`the page has ${size} bytes: expected at most ${MAX_BYTES}`);
}
const out = process.argv[2] ?? fileURLToPath(new URL("smr.html", BUILT));
writeFileSync(out, page);
console.log(`${out}: ${size} bytes`);
