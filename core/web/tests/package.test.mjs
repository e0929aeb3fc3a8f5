// The installed package: it loads its WebAssembly from all kinds of sources, and its type declarations are complete.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, test } from "node:test";
import { pathToFileURL } from "node:url";
import * as source from "../smr.js";
import { PACKAGE, frames } from "./library.mjs";

const { load, hasSimd, Tracker, SmrError } = await import(pathToFileURL(join(PACKAGE, "smr.js")));
const file = join(PACKAGE, "smr.wasm");
const bytes = readFileSync(file);

const server = createServer((request, response) => {
  const found = { "/smr.wasm": [200, bytes], "/page": [200, "<!doctype html>", { "content-type": "text/html" }] };
  const [status, body, head] = found[request.url] ?? [404];
  response.writeHead(status, head).end(body);
});
await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
after(() => server.close());
const address = `http://127.0.0.1:${server.address().port}`;

test("by default the module is the one for this engine", async () => {
  assert.equal((await load()).simd, hasSimd());
});

test("a module comes from bytes, a WebAssembly.Module, a Response, a file or an address", async () => {
  const [first, second] = frames();
  const sources = [
    bytes, new Uint8Array(bytes).buffer, await WebAssembly.compile(bytes), new Response(bytes), file, pathToFileURL(file), pathToFileURL(file).href, `${address}/smr.wasm`,
    fetch(`${address}/smr.wasm`),
  ];
  for (const source of sources) {
    const smr = await load(await source);
    assert.equal(smr.simd, false);
    assert.match(smr.version, /^\d+\.\d+\.\d+$/);
    const tracker = smr.paper();
    assert.ok(tracker instanceof Tracker);
    tracker.lock(first, first.box);
    assert.deepEqual(tracker.update(second).box, second.box);
  }
});

test("what is no module is refused", async () => {
  const empty = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0]);
  await assert.rejects(load(empty), /^TypeError: the WebAssembly module is not smr's$/);
  await assert.rejects(load(5), /^TypeError: load takes a WebAssembly.Module, bytes, a Response or an address, not a number$/);
  await assert.rejects(load(`${address}/missing`), /^Error: cannot load http:.*\/missing: 404 Not Found$/);
  await assert.rejects(load(`${address}/page`), /^Error: cannot load http:.*\/page: expected WebAssembly, found text\/html: see "Loading" in the README/);
  await assert.rejects(load(new Uint8Array(5)), WebAssembly.CompileError);
  await assert.rejects(load(join(PACKAGE, "missing.wasm")), { code: "ENOENT" });
});

/** Returns the address of a module whose imports are part of it, as in a bundle that a page runs from a blob. */
function withoutPlace(name) {
  const text = readFileSync(join(PACKAGE, name), "utf8").replace(/from "\.\/([^"]+)"/g, (_, name) => `from "${withoutPlace(name)}"`);
  return `data:text/javascript;base64,${Buffer.from(text).toString("base64")}`;
}

test("code without a place says what load() needs, and takes it", async () => {
  const { load } = await import(withoutPlace("smr.js"));
  await assert.rejects(load(), /^TypeError: this code does not know an address beside which smr.wasm lies: give load\(\) the bytes or the address of smr.wasm$/);
  for (const source of [bytes, `${address}/smr.wasm`, new URL(`${address}/smr.wasm`), pathToFileURL(file)]) {
    assert.equal((await load(source)).simd, false);
  }
});

test("the package has the files that package.json names, and the version of the library", async () => {
  const { exports, version, license, files } = JSON.parse(readFileSync(join(PACKAGE, "package.json")));
  const there = readdirSync(PACKAGE);
  const named = Object.values(exports).flatMap((place) => (typeof place === "string" ? [place] : Object.values(place)));
  for (const name of named) {
    assert.ok(there.includes(name.slice(2)), name);
  }
  assert.equal(version, (await load()).version);
  for (const [, link] of readFileSync(join(PACKAGE, "README.md"), "utf8").matchAll(/\]\((?!https?:)([^)]+)\)/g)) {
    assert.ok(there.includes(link), link);
  }
  assert.equal(license, "MIT OR Apache-2.0");
  assert.ok(files.includes("smr*.wasm") && there.filter((name) => name.startsWith("LICENSE-")).length === 2);
});

function declared(types, name) {
  const [, body] = new RegExp(`export declare class ${name}\\b[^{]*{\\n(.*?)\\n}`, "s").exec(types);
  return [...body.matchAll(/^ {2}(?:readonly )?(\w+)\??(?:\(|:)/gm)].map(([, member]) => member).filter((member) => member !== "constructor");
}

test("the types name what there is", async () => {
  const types = readFileSync(join(PACKAGE, "smr.d.ts"), "utf8");
  const values = [...types.matchAll(/^export declare (?:class|const|function) (\w+)/gm)].map(([, name]) => name);
  assert.deepEqual(values.sort(), Object.keys(source).sort());
  const smr = await load();
  const tracker = smr.robust();
  for (const [name, object] of [["Tracker", tracker], ["Smr", smr]]) {
    const members = new Set([...Object.keys(object), ...Object.getOwnPropertyNames(Object.getPrototypeOf(object))]);
    members.delete("constructor");
    assert.deepEqual(declared(types, name).sort(), [...members].sort(), name);
  }
  const [first, second] = frames();
  tracker.lock(first, first.box);
  const [, answer] = /export interface Answer {\n(.*?)\n}/s.exec(types);
  assert.deepEqual([...answer.matchAll(/^ {2}(\w+):/gm)].map(([, name]) => name), Object.keys(tracker.update(second)));
  for (const [method, name] of [["paper", "PaperOptions"], ["robust", "RobustOptions"]]) {
    const [, options] = new RegExp(`export interface ${name} {\\n(.*?)\\n}`, "s").exec(types);
    const names = [...options.matchAll(/^ {2}(\w+)\?:/gm)].map(([, option]) => option);
    assert.deepEqual(names.filter((option) => option !== "preset").sort(), Object.keys(smr[method]().options).sort());
  }
  assert.equal(new SmrError("SMR_ERROR_BOX_EMPTY").status, "SMR_ERROR_BOX_EMPTY");
});
