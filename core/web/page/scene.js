// The built-in recording, rendered by host-sim's code (host-sim/scene) as WebAssembly. It is rendered while it plays,
// because its noise compresses badly.

const [width, height] = [320, 240];

/** Compiles the module `bytes`. Returns a function that renders frame `index` (from 0) as canvas pixels, RGBA. */
export async function scene(bytes) {
  const { memory, street_frame } = (await WebAssembly.instantiate(bytes, { Math })).instance.exports;
  return (index) => ({ data: new Uint8ClampedArray(memory.buffer, street_frame(index), 4 * width * height).slice(), width, height });
}
