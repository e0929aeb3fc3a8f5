"""Crops, the network's view of a target: a box and its surroundings in 32x32 pixels, normalised in mean and contrast.

The centre of pixel i of a crop lies at  centre - 1.75 * side / 2 + (i + 0.5) * 1.75 * side / 32  in the frame, in x as in y.
Width and height are scaled separately, so every box becomes a square.
"""

import cv2
import numpy as np

SIDE = 32
CONTEXT = 1.75
# The value of mean gray in a normalised crop, whose values are 0 to 127.
ZERO = 64
# Largest step in frame pixels between crop pixels. At a larger step the frame is halved, so that no pixel is skipped.
COARSEST_STEP = 2.2
SAMPLED = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


def to_frame(box):
    """The affine map from crop to frame pixels, for OpenCV, where a pixel's centre has integer coordinates."""
    step = box[2:] * (CONTEXT / SIDE)
    corner = box[:2] - box[2:] * (CONTEXT / 2) + step / 2 - 0.5
    return np.array([[step[0], 0, corner[0]], [0, step[1], corner[1]]])


def read(frame, matrix):
    """Samples the crop that `matrix` maps into the frame. Outside the frame its border is repeated."""
    frame, matrix = halved_as_needed(np.asarray(frame), matrix)
    return cv2.warpAffine(frame, matrix, (SIDE, SIDE), flags=SAMPLED, borderMode=cv2.BORDER_REPLICATE)


def halved_as_needed(frame, matrix):
    step = np.sqrt(abs(np.linalg.det(matrix[:, :2])))
    for _ in range(2):
        if step < COARSEST_STEP or min(frame.shape) < 4:
            break
        frame = cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        # Halving maps x to (x + 0.5) / 2 - 0.5, because the centres of pixels have integer coordinates.
        matrix = np.column_stack([matrix[:, :2] / 2, (matrix[:, 2] + 0.5) / 2 - 0.5])
        step /= 2
    return frame, matrix


def crop(frame, box):
    return read(frame, to_frame(box))


def normalised(crops):
    """Normalises crops (..., 32, 32) of u8 to the network's input of 0 to 127, in integers, like the tracker."""
    pixels = crops.astype(np.int32)
    mean = (pixels.sum((-2, -1), keepdims=True) + 512) >> 10
    difference = pixels - mean
    # The sum is at most 1024 * 255^2 < 2^26, so the rounded-down square root of a double is exact.
    root = np.sqrt((difference * difference).sum((-2, -1), keepdims=True).astype(np.float64)).astype(np.int32)
    factor = (1 << 21) // (root + 128)
    return (np.clip((difference * factor) >> 12, -64, 63) + ZERO).astype(np.uint8)
