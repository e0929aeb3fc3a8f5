"""Changes of a crop that a target survives: something before it, other light, blur, noise, a turn."""

import cv2
import numpy as np

from . import crops

HIDDEN_SHARE, LIGHT_SHARE, BLURRED_SHARE, MOVED_SHARE = 0.5, 0.5, 0.35, 0.2
COVER_SIDES = (6, 20)  # of the cover, in pixels of the crop
COVER_READ = (15, 50)  # sides of the box that the cover shows, in pixels of the reduced frame
GAIN, SLOPE, OFFSET = 0.5, 15, 25  # standard deviations: log contrast, gray levels from the middle to an edge, brightness
BLUR = (0.5, 1.8)  # standard deviation of a blur, in pixels of the crop
MOTION = (3, 8)  # length of a motion blur, in pixels of the crop
LARGEST_NOISE = 8
MIDDLE = (crops.SIDE - 1) / 2
# Poor light: least factor of the contrast; largest gray level that keeps its value (0 is dusk, others are fog); largest noise.
LEAST_CONTRAST, LARGEST_FOG, LARGEST_DIM_NOISE = 0.12, 130, 1.5


def drawn(rng, crop, clips):
    """Returns the crop with random disturbances."""
    values = crop.astype(np.float32)
    if rng.random() < HIDDEN_SHARE:
        cover(rng, values, clips)
    if rng.random() < LIGHT_SHARE:
        values = lit(rng, values)
    if rng.random() < BLURRED_SHARE:
        values = cv2.GaussianBlur(values, (0, 0), rng.uniform(*BLUR))
    if rng.random() < MOVED_SHARE:
        values = moved(rng, values)
    noise = rng.normal(0, rng.uniform(0, LARGEST_NOISE), values.shape)
    return np.clip(values + noise, 0, 255).astype(np.uint8)


def cover(rng, values, clips):
    """Draws a rectangle of another recording over a part of the crop."""
    width, height = rng.integers(*COVER_SIDES), rng.integers(*COVER_SIDES)
    x, y = rng.integers(0, crops.SIDE - width + 1), rng.integers(0, crops.SIDE - height + 1)
    frames = clips[rng.integers(len(clips))].frames
    frame = frames[rng.integers(len(frames))]
    box = np.concatenate([rng.random(2) * frame.shape[::-1], rng.uniform(*COVER_READ, 2)])
    place = slice(y, y + height), slice(x, x + width)
    values[place] = crops.crop(frame, box)[place]


def lit(rng, values):
    """Changes contrast and brightness, and adds a gradient."""
    down, across = np.mgrid[-1 : 1 : crops.SIDE * 1j, -1 : 1 : crops.SIDE * 1j]
    gradient = rng.normal(0, SLOPE) * across + rng.normal(0, SLOPE) * down
    return (128 + (values - 128) * np.exp(rng.normal(0, GAIN)) + gradient + rng.normal(0, OFFSET)).astype(np.float32)


def dimmed(rng, crop):
    """Returns the crop in poor light: dusk or fog, with the camera's noise."""
    contrast, fog = LEAST_CONTRAST ** rng.random(), rng.uniform(0, LARGEST_FOG)
    noise = rng.normal(0, rng.uniform(0, LARGEST_DIM_NOISE), crop.shape)
    return np.clip(np.rint(fog + (crop - fog) * contrast + noise), 0, 255).astype(np.uint8)


def moved(rng, values):
    """Blurs along a line of random direction."""
    length = int(rng.integers(*MOTION))
    line = np.zeros((length, length), np.float32)
    line[length // 2] = 1
    turn = cv2.getRotationMatrix2D((length / 2 - 0.5, length / 2 - 0.5), rng.uniform(0, 180), 1)
    line = cv2.warpAffine(line, turn, (length, length))
    return cv2.filter2D(values, -1, line / max(line.sum(), 1e-3), borderType=cv2.BORDER_REPLICATE)


def turned(matrix, angle):
    """The map from crop to frame pixels, turned around the middle of the crop."""
    sine, cosine = np.sin(angle), np.cos(angle)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    middle = np.full(2, MIDDLE)
    return np.column_stack([matrix[:, :2] @ turn, matrix[:, :2] @ (middle - turn @ middle) + matrix[:, 2]])
