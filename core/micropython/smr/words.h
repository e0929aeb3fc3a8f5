// The texts of Rust's errors; NULL for a status that no call of the module can cause. core/c/tests/interface/errors.rs writes them.
static mp_rom_error_text_t words(smr_status status) {
    switch (status) {
        case SMR_ERROR_OTHER_METHOD: return MP_ERROR_TEXT("the target was saved by another tracker, or by one of another size");
        case SMR_ERROR_LIMIT_BELOW_WINDOW: return MP_ERROR_TEXT("window_limit is smaller than window");
        case SMR_ERROR_FRAME_EMPTY: return MP_ERROR_TEXT("the image has no pixels: width and height must be at least 1");
        case SMR_ERROR_STRIDE_TOO_SMALL: return MP_ERROR_TEXT("the stride is smaller than the width");
        case SMR_ERROR_FRAME_TOO_SHORT: return MP_ERROR_TEXT("the slice is shorter than (height - 1) * stride + width bytes");
        case SMR_ERROR_OUTSIDE_FRAME: return MP_ERROR_TEXT("a window has no pixels, or is not wholly inside the frame");
        case SMR_ERROR_BOX_EMPTY: return MP_ERROR_TEXT("the box has no pixels: width and height must be at least 1");
        case SMR_ERROR_BOX_OUTSIDE_FRAME: return MP_ERROR_TEXT("the box is not wholly inside the frame");
        case SMR_ERROR_BOX_TOO_LARGE: return MP_ERROR_TEXT("the box has more pixels than this tracker's template has room for");
        case SMR_ERROR_WINDOW_TOO_LARGE: return MP_ERROR_TEXT("the window can grow to more offsets on an axis than this tracker has room for");
        case SMR_ERROR_NOT_LOCKED: return MP_ERROR_TEXT("there is no target yet: lock first");
        case SMR_ERROR_FRAME_SIZE_CHANGED: return MP_ERROR_TEXT("the frame has another size than the one that was locked on");
        case SMR_ERROR_NOT_SAVED: return MP_ERROR_TEXT("these are not the bytes of a saved target");
        case SMR_ERROR_OTHER_VERSION: return MP_ERROR_TEXT("the target was saved by another version");
        case SMR_ERROR_TRUNCATED: return MP_ERROR_TEXT("the saved target ends too early");
        case SMR_ERROR_DAMAGED: return MP_ERROR_TEXT("the saved target is damaged: its checksum is wrong");
        case SMR_ERROR_OTHER_CONFIG: return MP_ERROR_TEXT("the target was saved with another configuration: %s differs");
        case SMR_ERROR_SAVED_TOO_LARGE: return MP_ERROR_TEXT("the saved target is too large for this tracker");
        case SMR_ERROR_FORMAT_UNKNOWN: return MP_ERROR_TEXT("the format is none of smr's: GRAY8, YUYV, UYVY, RGB565_BE, RGB565_LE, BAYER8, GRAY10");
        case SMR_ERROR_LINE_TOO_SHORT: return MP_ERROR_TEXT("line %d has fewer bytes than its format needs");
        case SMR_ERROR_REFINER_NOT_BUILT_IN: return MP_ERROR_TEXT("the refiner is on, and this build is without it (feature refiner)");
        case SMR_ERROR_UNCERTAIN_BELOW_LOST: return MP_ERROR_TEXT("uncertain_below is smaller than lost_below");
        default: return NULL;
    }
}
