// Converts a picture to gray pixels. For a video they are its luma in the full range, as in host-sim and ffmpeg; for
// any other picture they are computed from its colors.

const WITH_LUMA = ["I420", "I420A", "I422", "I444", "NV12"];

// Maps luma in the range of video (black is 16, white is 235) to the full range.
const FULL = Uint8Array.from({ length: 256 }, (_, luma) => Math.min(Math.max(Math.round(((luma - 16) * 255) / 219), 0), 255));

let canvas = null;
let planes = new Uint8Array(0);

/** Converts a VideoFrame or an ImageBitmap to a frame for a tracker: { data, width, height }. */
export async function grayOf(picture) {
  if (picture instanceof ImageBitmap) {
    return ofCanvas(picture, picture.width, picture.height);
  }
  const { displayWidth: width, displayHeight: height, visibleRect: shown, format } = picture;
  // Luma is used only if the picture is shown as it is stored: square pixels, not rotated, not flipped.
  const isPlain = WITH_LUMA.includes(format) && shown.width === width && shown.height === height && !(picture.rotation > 0) && !picture.flip;
  return isPlain ? ofLuma(picture, width, height) : ofCanvas(picture, width, height);
}

async function ofLuma(picture, width, height) {
  const size = picture.allocationSize();
  if (planes.length !== size) {
    planes = new Uint8Array(size);
  }
  const [{ offset, stride }] = await picture.copyTo(planes);
  const data = planes.subarray(offset, offset + height * stride);
  if (picture.colorSpace.fullRange !== true) {
    for (let at = 0; at < data.length; at++) {
      data[at] = FULL[data[at]];
    }
  }
  return { data, width, height, stride };
}

function ofCanvas(picture, width, height) {
  if (canvas === null || canvas.width !== width || canvas.height !== height) {
    canvas = new OffscreenCanvas(width, height);
  }
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(picture, 0, 0, width, height);
  return { data: context.getImageData(0, 0, width, height).data, width, height };
}
