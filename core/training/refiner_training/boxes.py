"""Boxes as arrays (centre x, centre y, width, height), and their files: lines of `x1,y1,x2,y2`, NaN without a box."""

import math

import numpy as np


def from_corners(x1, y1, x2, y2):
    return np.array([(x1 + x2) / 2, (y1 + y2) / 2, x2 - x1, y2 - y1])


def read(path):
    """Reads a file: a box or None for each line."""
    return [parsed(line) for line in path.read_text().splitlines() if line.strip()]


def parsed(line):
    try:
        corners = [float(word) for word in line.replace(",", " ").split()[:4]]
    except ValueError:
        return None
    if len(corners) < 4 or not all(map(math.isfinite, corners)):
        return None
    return from_corners(*corners)


def side(box):
    """The side of a square with the area of the box."""
    return math.sqrt(box[2] * box[3])


def intersection_over_union(a, b):
    overlap = np.minimum(a[:2] + a[2:] / 2, b[:2] + b[2:] / 2) - np.maximum(a[:2] - a[2:] / 2, b[:2] - b[2:] / 2)
    if overlap.min() <= 0:
        return 0.0
    common = overlap[0] * overlap[1]
    return common / (a[2] * a[3] + b[2] * b[3] - common)


def correction(box, truth):
    """The correction from `box` to `truth`, which the network learns: dx in box widths, dy in box heights, log width ratio, log height ratio."""
    dx, dy = (truth[:2] - box[:2]) / box[2:]
    return np.array([dx, dy, math.log(truth[2] / box[2]), math.log(truth[3] / box[3])], np.float32)


def corrected(box, change):
    """Applies a correction to `box`."""
    return np.concatenate([box[:2] + change[:2] * box[2:], box[2:] * np.exp(change[2:4])])


def aligned(answers, start):
    """Moves and scales a tracker's boxes so that the first one is `start`, which the tracker may have rounded."""
    first = next(answer for answer in answers if answer is not None)
    move, scale = start[:2] - first[:2], start[2:] / first[2:]
    return [None if answer is None else np.concatenate([answer[:2] + move, answer[2:] * scale]) for answer in answers]
