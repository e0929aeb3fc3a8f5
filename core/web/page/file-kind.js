// Tells recordings, whose bytes are images, from text with boxes.

const HEAD = 4096; // bytes
// Excel saves some text as UTF-16: host-sim says what it expects instead.
const isUtf16 = ([first, second]) => (first === 0xff && second === 0xfe) || (first === 0xfe && second === 0xff);
const isText = (byte) => byte >= 32 || (byte >= 9 && byte <= 13) || byte === 27;

/** True for a video, an image or a folder: by its type, or by bytes at its start that are no text. */
export async function isRecording(file) {
  if (/^(video|image)\//.test(file.type)) {
    return true;
  }
  try {
    const head = new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
    return new TextDecoder().decode(head.subarray(0, 9)) === "YUV4MPEG2" || (!isUtf16(head) && !head.every(isText));
  } catch {
    return true; // A folder cannot be read.
  }
}
