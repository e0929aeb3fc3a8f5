// Messages of the Rust library's errors, by the name of the C status. core/c/tests/interface/errors.rs generates them.

export const WORDS = {
  SMR_ERROR_OTHER_METHOD: "the target was saved by another tracker, or by one of another size",
  SMR_ERROR_LIMIT_BELOW_WINDOW: "window_limit is smaller than window",
  SMR_ERROR_FRAME_EMPTY: "the image has no pixels: width and height must be at least 1",
  SMR_ERROR_STRIDE_TOO_SMALL: "the stride is smaller than the width",
  SMR_ERROR_FRAME_TOO_SHORT: "the slice is shorter than (height - 1) * stride + width bytes",
  SMR_ERROR_BOX_EMPTY: "the box has no pixels: width and height must be at least 1",
  SMR_ERROR_BOX_OUTSIDE_FRAME: "the box is not wholly inside the frame",
  SMR_ERROR_BOX_TOO_LARGE: "the box has more pixels than this tracker's template has room for",
  SMR_ERROR_WINDOW_TOO_LARGE: "the window can grow to more offsets on an axis than this tracker has room for",
  SMR_ERROR_NOT_LOCKED: "there is no target yet: lock first",
  SMR_ERROR_FRAME_SIZE_CHANGED: "the frame has another size than the one that was locked on",
  SMR_ERROR_NOT_SAVED: "these are not the bytes of a saved target",
  SMR_ERROR_OTHER_VERSION: "the target was saved by another version",
  SMR_ERROR_TRUNCATED: "the saved target ends too early",
  SMR_ERROR_DAMAGED: "the saved target is damaged: its checksum is wrong",
  SMR_ERROR_OTHER_CONFIG: "the target was saved with another configuration: {} differs",
  SMR_ERROR_SAVED_TOO_LARGE: "the saved target is too large for this tracker",
  SMR_ERROR_UNCERTAIN_BELOW_LOST: "uncertain_below is smaller than lost_below",
};
