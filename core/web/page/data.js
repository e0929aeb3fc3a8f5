// The data in the built page beside its script, packed: the worker's script and the WebAssembly modules. build.mjs puts them there.

import { byId } from "./dom.js";
import { unpacked } from "./unpacked.js";

/** The address of the worker's script. */
export async function workerAddress() {
  return URL.createObjectURL(new Blob([await unpacked(byId("worker.js").textContent).text()], { type: "text/javascript" }));
}

/** The WebAssembly modules, packed. */
export function packedModules() {
  return { smr: byId("smr-simd.wasm").textContent, scene: byId("scene.wasm").textContent };
}
