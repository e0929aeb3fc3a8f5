// Tests the package in an app built by each bundler: in Chromium, it loads the library and tracks a target.
// SMR_BUNDLERS names a folder where `.ci/web` has installed the bundlers.

import assert from "node:assert/strict";
import { copyFileSync, cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer as createHttp } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { promisify } from "node:util";
import { load } from "../smr.js";
import { Browser, hasBrowser } from "./browser.mjs";
import { PACKAGE, frames } from "./library.mjs";

const [first, second] = frames({ width: 80, height: 60 });
const APP = `
import { load } from "smr-tracker";
import { Recorder } from "smr-tracker/record";
const frames = ${JSON.stringify([first, second].map(({ data, ...frame }) => ({ ...frame, data: [...data] })))};
const [first, second] = frames.map((frame) => ({ ...frame, data: Uint8Array.from(frame.data) }));
async function follow() {
  const tracker = (await load()).robust();
  new Recorder(tracker);
  tracker.lock(first, first.box);
  return JSON.stringify(tracker.update(second));
}
follow().catch(String).then((answer) => { document.title = answer; });
`;
const PAGE = '<!doctype html><title></title><script type="module" src="./app.js"></script>';
const KINDS = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };

const why = !process.env.SMR_BUNDLERS ? "SMR_BUNDLERS does not name a folder with bundlers" : !hasBrowser() ? "no chromium" : null;
const app = mkdtempSync(join(tmpdir(), "smr-app-"));
let browser, expected;

before(async () => {
  const tracker = (await load(readFileSync(join(PACKAGE, "smr-simd.wasm")))).robust();
  tracker.lock(first, first.box);
  expected = JSON.stringify(tracker.update(second));
  cpSync(PACKAGE, join(app, "node_modules/smr-tracker"), { recursive: true, filter: (name) => !name.endsWith(".html") });
  writeFileSync(join(app, "package.json"), '{ "type": "module" }');
  writeFileSync(join(app, "app.js"), APP);
  writeFileSync(join(app, "index.html"), PAGE);
  browser = why === null ? new Browser() : undefined;
});

after(async () => {
  await browser?.close();
  rmSync(app, { recursive: true });
});

const bundler = (name) => import(pathToFileURL(createRequire(join(process.env.SMR_BUNDLERS, "package.json")).resolve(name)));

/** Opens the app at an address and checks its answer. */
async function answers(address, answer = expected) {
  const page = await browser.page(address);
  assert.equal(await page.until("document.title"), answer);
  await page.close();
}

/** Serves the app in a folder over HTTP and checks its answer. */
async function built(folder, answer) {
  const server = createHttp((request, response) => {
    try {
      const path = join(folder, new URL(request.url, "http://localhost").pathname.replace(/\/$/, "/index.html"));
      response.setHeader("content-type", KINDS[extname(path)]).end(readFileSync(path));
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  await answers(`http://127.0.0.1:${server.address().port}/`, answer).finally(() => server.close());
}

/** Checks an app whose bundler leaves out the .wasm files: copies them beside the script, as the README describes. */
async function besideModules(folder, page = PAGE, answer = expected) {
  writeFileSync(join(folder, "index.html"), page);
  ["smr.wasm", "smr-simd.wasm"].forEach((name) => copyFileSync(join(PACKAGE, name), join(folder, name)));
  await built(folder, answer);
}

const BUNDLERS = {
  async vite(folder) {
    const { build } = await bundler("vite");
    await build({ root: app, logLevel: "error", build: { outDir: folder } });
    await built(folder);
  },
  async "vite in development"() {
    const { createServer } = await bundler("vite");
    const server = await createServer({ root: app, logLevel: "error", server: { host: "127.0.0.1", port: 0 } });
    await server.listen();
    await answers(server.resolvedUrls.local[0]).finally(() => server.close());
  },
  async webpack(folder) {
    const { default: webpack } = await bundler("webpack");
    const stats = await promisify(webpack)({ context: app, mode: "production", entry: "./app.js", output: { path: folder, filename: "app.js" } });
    assert.deepEqual(stats.toJson({ all: false, errors: true, warnings: true }), { errors: [], warnings: [] });
    copyFileSync(join(app, "index.html"), join(folder, "index.html"));
    await built(folder);
  },
  async esbuild(folder) {
    const { build } = await bundler("esbuild");
    const options = { absWorkingDir: app, entryPoints: ["app.js"], bundle: true, minify: true, format: "esm", outdir: folder, logLevel: "silent" };
    assert.deepEqual((await build(options)).warnings, []);
    await besideModules(folder);
  },
  async "esbuild, no module"(folder) {
    const { build } = await bundler("esbuild");
    await build({ absWorkingDir: app, entryPoints: ["app.js"], bundle: true, outdir: folder, logLevel: "silent" });
    await besideModules(folder, '<!doctype html><title></title><script src="./app.js"></script>');
  },
  async rollup(folder) {
    const [{ rollup }, { default: resolve }] = [await bundler("rollup"), await bundler("@rollup/plugin-node-resolve")];
    const bundle = await rollup({ input: join(app, "app.js"), plugins: [resolve()], onwarn: ({ message }) => assert.fail(message) });
    await bundle.write({ dir: folder, format: "es" });
    await besideModules(folder);
  },
};

for (const [name, follow] of Object.entries(BUNDLERS)) {
  test(`${name}: the app follows a target`, { skip: why ?? false }, async () => {
    const folder = join(app, name);
    mkdirSync(folder);
    await follow(folder);
  });
}

const WORKER = `
import { load } from "smr-tracker";
const said = (error) => error.name + ": " + error.message;
onmessage = ({ data }) => load(...data).then((smr) => smr.version, said).then(postMessage);
`;
const WORKERS_PAGE = `<!doctype html><title></title><script type="module">
const results = [];
for (const [file, type] of [["module.js", "module"], ["classic.js", "classic"]]) {
  const blob = new Blob([await (await fetch(file)).text()], { type: "text/javascript" });
  for (const given of [[], ["smr.wasm"], [new URL("smr.wasm", location).href], [await (await fetch("smr.wasm")).arrayBuffer()]]) {
    const worker = new Worker(URL.createObjectURL(blob), { type });
    worker.postMessage(given);
    results.push(await new Promise((heard) => { worker.onmessage = (event) => heard(event.data); worker.onerror = (event) => heard("error " + event.message); }));
    worker.terminate();
  }
}
document.title = JSON.stringify(results);
</script>`;

test("a worker made of a blob says what load() needs, and takes it", { skip: why ?? false }, async () => {
  const folder = join(app, "workers");
  const { build } = await bundler("esbuild");
  writeFileSync(join(app, "worker.js"), WORKER);
  for (const [name, format] of [["module", "esm"], ["classic", "iife"]]) {
    await build({ absWorkingDir: app, entryPoints: ["worker.js"], bundle: true, minify: true, format, outfile: join(folder, `${name}.js`), logLevel: "silent" });
  }
  const { version } = await load(readFileSync(join(PACKAGE, "smr.wasm")));
  const unknown = "TypeError: this code does not know an address beside which smr.wasm lies: give load() the bytes or the address of smr.wasm";
  const relative = "TypeError: smr.wasm is a relative address, which leads nowhere from here: expected one like https://example.org/smr.wasm";
  const each = [unknown, relative, version, version];
  await besideModules(folder, WORKERS_PAGE, JSON.stringify([...each, ...each]));
});

test("Vue keeps a tracker as it is", { skip: process.env.SMR_BUNDLERS ? false : why }, async () => {
  const { default: { reactive, ref } } = await bundler("@vue/reactivity");
  const smr = ref(await load(readFileSync(join(PACKAGE, "smr.wasm"))));
  const [tracker, state] = [ref(smr.value.robust()), reactive({ tracker: smr.value.paper() })];
  for (const one of [tracker.value, state.tracker]) {
    one.lock(first, reactive({ ...first.box }));
    assert.deepEqual(one.update(reactive({ ...second })).box, second.box);
  }
});
