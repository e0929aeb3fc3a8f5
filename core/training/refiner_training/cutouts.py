"""Synthetic samples: a piece of a frame is cut out by a mask and pasted on another background, with known size, aspect, turn, light and noise.

Recordings have few kinds of targets. Here every textured piece of a frame is a target, whose true box is exact.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from . import boxes, crops, offsets

SIDES = (14, 60)  # of the piece, in pixels of the reduced frame
ASPECT = 0.4  # standard deviation of log(width / height) / 2
MIN_CONTRAST = 9  # standard deviation of the gray levels in the piece
TURN = 0.08  # standard deviation, radians
GAIN, OFFSET = 0.2, 15  # standard deviations of log contrast and of brightness
LARGEST_NOISE = 5
BLURRED_SHARE = 0.25
FIRST_PASTED_SHARE = 0.3
OTHER_RECORDING_SHARE = 0.5
TRIES = 10
UNIT = np.array([0.0, 0.0, 1.0, 1.0])
# Pixels per side of a mask. A mask covers the same region as a crop: the box and its surroundings.
MASK_SIDE = 64


@dataclass(frozen=True)
class Piece:
    frame: np.ndarray
    box: np.ndarray
    mask: np.ndarray


def drawn(rng, clips):
    """Draws a sample: first crop, present crop, correction."""
    clip, piece = textured_piece(rng, clips)
    box = offsets.drawn(rng, UNIT)
    first = crops.crop(piece.frame, piece.box).astype(np.float32)
    if rng.random() < FIRST_PASTED_SHARE:
        first = pasted(piece, UNIT, 0.0, background(rng, clip, piece))
    other = clips[rng.integers(len(clips))] if rng.random() < OTHER_RECORDING_SHARE else clip
    present = pasted(piece, box, rng.normal(0, TURN), background(rng, other, piece))
    present = 128 + (present - 128) * np.exp(rng.normal(0, GAIN)) + rng.normal(0, OFFSET)
    if rng.random() < BLURRED_SHARE:
        present = cv2.GaussianBlur(present, (3, 3), 0)
    return noisy(rng, first), noisy(rng, present), boxes.correction(box, UNIT)


def textured_piece(rng, clips):
    while True:
        clip = clips[rng.integers(len(clips))]
        frame = np.asarray(clip.frames[rng.integers(len(clip.frames))])
        for _ in range(TRIES):
            box = box_inside(rng, frame.shape)
            if box is not None and textured(crops.crop(frame, box)):
                return clip, Piece(frame, box, shape(rng))


def box_inside(rng, frame_shape):
    """Draws a box in the frame; None if it is too large for the frame."""
    side = np.exp(rng.uniform(*np.log(SIDES)))
    aspect = np.exp(rng.normal(0, ASPECT))
    sides = np.array([side * aspect, side / aspect])
    room = np.array(frame_shape[::-1]) - sides
    if room.min() <= 2:
        return None
    return np.concatenate([sides / 2 + rng.random(2) * room, sides])


def textured(crop):
    # Measures the contrast of the box only, without its surroundings.
    margin = round(crops.SIDE * (1 - 1 / crops.CONTEXT) / 2)
    return crop[margin:-margin, margin:-margin].std() > MIN_CONTRAST


def shape(rng):
    """Draws the mask of an ellipse, a rectangle or a polygon that touches all sides of the box."""
    mask = np.zeros((MASK_SIDE, MASK_SIDE), np.uint8)
    middle, reach = MASK_SIDE // 2, MASK_SIDE / crops.CONTEXT / 2
    kind = rng.integers(3)
    if kind == 0:
        cv2.ellipse(mask, (middle, middle), (int(reach), int(reach)), 0, 0, 360, 255, -1)
    elif kind == 1:
        cv2.rectangle(mask, (int(middle - reach), int(middle - reach)), (int(middle + reach), int(middle + reach)), 255, -1)
    else:
        cv2.fillPoly(mask, [(middle + reach * polygon(rng)).astype(np.int32)], 255)
    return mask


def polygon(rng):
    """Draws five to nine corners around the centre, which span -1 to 1 in x and y."""
    count = rng.integers(5, 10)
    angles = np.sort(rng.uniform(0, 2 * np.pi, count))
    corners = rng.uniform(0.6, 1.3, count)[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    low, high = corners.min(0), corners.max(0)
    return (2 * corners - low - high) / np.maximum(high - low, 1e-3)


def background(rng, clip, piece):
    """The crop of a box of the piece's size at a random place."""
    frame = clip.frames[rng.integers(len(clip.frames))]
    place = rng.random(2) * frame.shape[::-1]
    return crops.crop(frame, np.concatenate([place, piece.box[2:]])).astype(np.float32)


def pasted(piece, box, turn, behind):
    """The crop of `box`, relative to the piece's true box UNIT, with the turned piece before the background `behind`."""
    to_unit = turned(crops.to_frame(box), turn)
    content = crops.read(piece.frame, unit_to(to_unit, piece.box[2:], piece.box[:2] - 0.5)).astype(np.float32)
    scale = MASK_SIDE / crops.CONTEXT
    to_mask = unit_to(to_unit, np.array([scale, scale]), np.full(2, MASK_SIDE / 2 - 0.5))
    mask = cv2.warpAffine(piece.mask, to_mask, behind.shape, flags=crops.SAMPLED).astype(np.float32) / 255
    return mask * content + (1 - mask) * behind


def turned(matrix, angle):
    """The map from crop pixels to the turned piece, whose centre is 0 and whose sides are 1."""
    matrix = np.column_stack([matrix[:, :2], matrix[:, 2] + 0.5])
    sine, cosine = np.sin(angle), np.cos(angle)
    return np.array([[cosine, -sine], [sine, cosine]]) @ matrix


def unit_to(matrix, scale, centre):
    """Appends to `matrix` the map from the unit box to a box with sides `scale` around `centre`."""
    matrix = matrix * scale[:, None]
    return np.column_stack([matrix[:, :2], matrix[:, 2] + centre])


def noisy(rng, crop):
    noise = rng.normal(0, rng.uniform(0, LARGEST_NOISE), crop.shape)
    return np.clip(crop + noise, 0, 255).astype(np.uint8)
