// Frames as JavaScript has them: gray bytes, or the RGBA of a canvas. Only the pixels that a tracker reads are copied.

import { SmrError, bytesOf, object, whole } from "./errors.js";

const SIDE = 65535;

/** Validates a frame and returns its layout: { data, width, height, channels, stride }. */
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
  if (stride === undefined || format === undefined) {
    checkPixels(data.length / (width * height), channels);
  }
  if (checked.stride < row) {
    throw new SmrError("SMR_ERROR_STRIDE_TOO_SMALL");
  }
  // This check also detects a buffer that has no bytes because it was transferred to another thread.
  if (data.length < (height - 1) * checked.stride + row) {
    throw new SmrError("SMR_ERROR_FRAME_TOO_SHORT");
  }
  return checked;
}

// Throws if the data's `bytes` per pixel fit a format other than `channels`: gray and colors would be confused.
function checkPixels(bytes, channels) {
  if (Number.isInteger(bytes) && bytes >= 1 && bytes <= 4 * channels && bytes !== channels) {
    const expected = channels === 1 ? '1 byte for each pixel (gray), or 4 with format: "rgba"' : '4 bytes for each pixel (RGBA), or 1 with format: "gray"';
    throw new TypeError(`the frame's data must have ${expected}, not ${bytes}`);
  }
}

// Returns the number of bytes per pixel: from `format` if it is given, else from the type of the array.
function channelsOf(data, format) {
  const kind = bytesOf(data, "the frame's data", ["Uint8Array", "Uint8ClampedArray"]);
  const channels = new Map([["gray", 1], ["rgba", 4], [undefined, kind === "Uint8ClampedArray" ? 4 : 1]]).get(format ?? undefined);
  if (channels === undefined) {
    throw new TypeError(`the frame's format must be "gray" or "rgba", not ${String(format)}`);
  }
  return channels;
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

// Converts RGBA to gray with the weights of host-sim, which add up to 65536. Alpha is ignored.
function copyLuma(rgba, from, to, at, pixels) {
  for (let end = at + pixels; at < end; at++, from += 4) {
    to[at] = (19595 * rgba[from] + 38470 * rgba[from + 1] + 7471 * rgba[from + 2] + 32768) >> 16;
  }
}
