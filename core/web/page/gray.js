// Converts an image to gray pixels. For a video they are its luma in the full range, as in host-sim and ffmpeg; for
// any other image they are computed from its colors.

const WITH_LUMA = ["I420", "I420A", "I422", "I444", "NV12"];

// Maps luma in the range of video (black is 16, white is 235) to the full range.
const FULL = Uint8Array.from({ length: 256 }, (_, luma) => Math.min(Math.max(Math.round(((luma - 16) * 255) / 219), 0), 255));

let canvas = null;
let planes = new Uint8Array(0);

/** Converts a VideoFrame or an ImageBitmap to a frame for a tracker: { data, width, height }. */
export async function grayOf(image) {
  if (image instanceof ImageBitmap) {
    return ofCanvas(image, image.width, image.height);
  }
  const { displayWidth: width, displayHeight: height, visibleRect: shown, format } = image;
  // Luma is used only if the image is shown as it is stored: square pixels, not rotated, not flipped.
  const isPlain = WITH_LUMA.includes(format) && shown.width === width && shown.height === height && !(image.rotation > 0) && !image.flip;
  return isPlain ? ofLuma(image, width, height) : ofCanvas(image, width, height);
}

async function ofLuma(image, width, height) {
  const size = image.allocationSize();
  if (planes.length !== size) {
    planes = new Uint8Array(size);
  }
  const [{ offset, stride }] = await image.copyTo(planes);
  const data = planes.subarray(offset, offset + height * stride);
  if (image.colorSpace.fullRange !== true) {
    for (let at = 0; at < data.length; at++) {
      data[at] = FULL[data[at]];
    }
  }
  return { data, width, height, stride };
}

function ofCanvas(image, width, height) {
  if (canvas === null || canvas.width !== width || canvas.height !== height) {
    canvas = new OffscreenCanvas(width, height);
  }
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0, width, height);
  return { data: context.getImageData(0, 0, width, height).data, width, height };
}
