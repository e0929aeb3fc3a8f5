// The built-in recording: host-sim's own drawing of it (host-sim/scene) as WebAssembly. It is drawn as it plays, because its noise makes it large
// however it is packed.

const [width, height] = [320, 240];

/** Loads the WebAssembly module `bytes`. Returns a function: frame `index`, from 0, as canvas pixels: { data, width, height }. */
export async function scene(bytes) {
  const { memory, street_frame } = (await WebAssembly.instantiate(bytes, { Math })).instance.exports;
  return (index) => ({ data: new Uint8ClampedArray(memory.buffer, street_frame(index), 4 * width * height).slice(), width, height });
}
