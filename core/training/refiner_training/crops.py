"""Crops, the network's view of a target: a box and its surroundings, 32x32 pixels, with mean and contrast removed.

Pixel i of a crop covers the place  centre - 1.75 * side / 2 + (i + 0.5) * 1.75 * side / 32  of the frame, from edge to edge, in x as in y.
Width and height are scaled separately, so every box becomes a square.
"""

import cv2
import numpy as np

SIDE = 32
CONTEXT = 1.75
# The middle of the values of a normalised crop.
ZERO = 64
# A crop that takes fewer than 1 in this many pixels is read from the frame at half the size, else it would skip pixels.
COARSEST_STEP = 2.2
SAMPLED = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


def to_frame(box):
    """The affine map from the crop's pixels to the frame's, for OpenCV: a pixel's centre has whole coordinates."""
    step = box[2:] * (CONTEXT / SIDE)
    corner = box[:2] - box[2:] * (CONTEXT / 2) + step / 2 - 0.5
    return np.array([[step[0], 0, corner[0]], [0, step[1], corner[1]]])


def read(frame, matrix):
    """The pixels of a crop that `matrix` leads into the frame. Outside, the frame's border goes on."""
    frame, matrix = halved_as_needed(np.asarray(frame), matrix)
    return cv2.warpAffine(frame, matrix, (SIDE, SIDE), flags=SAMPLED, borderMode=cv2.BORDER_REPLICATE)


def halved_as_needed(frame, matrix):
    step = np.sqrt(abs(np.linalg.det(matrix[:, :2])))
    for _ in range(2):
        if step < COARSEST_STEP or min(frame.shape) < 4:
            break
        frame = cv2.resize(frame, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        # With the centres of pixels at whole coordinates, x becomes (x + 0.5) / 2 - 0.5.
        matrix = np.column_stack([matrix[:, :2] / 2, (matrix[:, 2] + 0.5) / 2 - 0.5])
        step /= 2
    return frame, matrix


def crop(frame, box):
    return read(frame, to_frame(box))


def normalised(crops):
    """Crops (..., 32, 32) of u8 as the network takes them: 0 to 127, in integers, as the tracker computes it."""
    pixels = crops.astype(np.int32)
    mean = (pixels.sum((-2, -1), keepdims=True) + 512) >> 10
    difference = pixels - mean
    # At most 1024 * 255^2 < 2^26, so the square root of a double is exact.
    root = np.sqrt((difference * difference).sum((-2, -1), keepdims=True).astype(np.float64)).astype(np.int32)
    factor = (1 << 21) // (root + 128)
    return (np.clip((difference * factor) >> 12, -64, 63) + ZERO).astype(np.uint8)
