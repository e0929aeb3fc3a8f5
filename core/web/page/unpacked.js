// Unpacks the files that build.mjs packs into the page: deflate, then Base64.

/** Returns the unpacked bytes as a Response. */
export function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")));
}
