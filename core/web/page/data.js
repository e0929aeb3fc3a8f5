// The data in the built page beside its script: the worker's script and the WebAssembly modules, packed. build.mjs puts
// them there.

import { byId } from "./dom.js";

/** The address of the worker's script. */
export function workerAddress() {
  return URL.createObjectURL(new Blob([byId("worker").textContent], { type: "text/javascript" }));
}

/** The WebAssembly modules: deflated, in Base64. */
export function packedModules() {
  return { simd: byId("smr-simd.wasm").textContent, plain: byId("smr.wasm").textContent, scene: byId("scene.wasm").textContent };
}
