// Access to the packed data that build.mjs puts into the page: the worker's script and the WebAssembly modules.

import { byId } from "./dom.js";
import { unpacked } from "./unpacked.js";

/** Returns a blob URL of the worker's script. */
export async function workerAddress() {
  return URL.createObjectURL(new Blob([await unpacked(byId("worker.js").textContent).text()], { type: "text/javascript" }));
}

/** Returns the WebAssembly modules as packed text, see unpacked.js. */
export function packedModules() {
  return { smr: byId("smr-simd.wasm").textContent, scene: byId("scene.wasm").textContent };
}
