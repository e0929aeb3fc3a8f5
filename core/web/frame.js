// Frames in the forms that JavaScript has: gray bytes, or the colors of a canvas. Only the pixels of a window are
// copied.

import { SmrError, named, object, whole } from "./errors.js";

const SIDE = 65535;

/** The layout of a frame, checked: { data, width, height, channels, stride }. */
export function frameOf(frame) {
  const { data, width, height, stride, format } = object(frame, "the frame", "an object with data, width and height");
  const channels = channelsOf(data, format);
  whole(width, 0, SIDE, "the frame's width");
  whole(height, 0, SIDE, "the frame's height");
  const row = width * channels;
  const checked = { data, width, height, channels, stride: stride === undefined ? row : whole(stride, 0, 2 ** 31, "the frame's stride") };
  if (width === 0 || height === 0) {
    throw new SmrError("SMR_ERROR_FRAME_EMPTY");
  }
  if (checked.stride < row) {
    throw new SmrError("SMR_ERROR_STRIDE_TOO_SMALL");
  }
  // A buffer that was transferred has no bytes.
  if (data.length < (height - 1) * checked.stride + row) {
    throw new SmrError("SMR_ERROR_FRAME_TOO_SHORT");
  }
  return checked;
}

// Bytes of a pixel, by the kind of frame.
function channelsOf(data, format) {
  const isClamped = data instanceof Uint8ClampedArray;
  if (!isClamped && !(data instanceof Uint8Array)) {
    throw new TypeError(`the frame's data must be a Uint8Array or a Uint8ClampedArray, not ${named(data)}`);
  }
  switch (format ?? (isClamped ? "rgba" : "gray")) {
    case "gray":
      return 1;
    case "rgba":
      return 4;
    default:
      throw new TypeError(`the frame's format must be "gray" or "rgba", not ${String(format)}`);
  }
}

/** Copies the gray pixels of `window` to `to`, row by row without gaps. */
export function copyWindow(frame, window, to) {
  const { data, channels, stride } = frame;
  for (let row = 0; row < window.height; row++) {
    const from = (window.y + row) * stride + window.x * channels;
    const at = row * window.width;
    if (channels === 1) {
      to.set(data.subarray(from, from + window.width), at);
    } else {
      copyLuma(data, from, to, at, window.width);
    }
  }
}

// The gray of host-sim: the weights add up to 65536. Alpha is ignored.
function copyLuma(rgba, from, to, at, pixels) {
  for (let end = at + pixels; at < end; at++, from += 4) {
    to[at] = (19595 * rgba[from] + 38470 * rgba[from + 1] + 7471 * rgba[from + 2] + 32768) >> 16;
  }
}
