"""A recording for training: its reduced frames, and the true boxes and the tracker's boxes in reduced pixels."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from . import boxes

# Minimum side of a target in pixels of the recording: the size of a smaller target cannot be recognised.
SMALLEST_SIDE = 3
# Overlap (IoU) below which the tracker's box counts as wrong.
MISTAKEN_BELOW = 0.05


@dataclass(frozen=True)
class Source:
    """The files of a clip, for other processes, because a clip itself is large."""

    truth: Path
    frames: Path
    tracked: Path
    reduction: float


class Clip:
    def __init__(self, source):
        self.frames = np.load(source.frames, mmap_mode="r")
        truth = boxes.read(source.truth)
        count = min(len(truth), len(self.frames))
        self.frames = self.frames[:count]
        self.truth = [scaled(box, source.reduction) if large(box) else None for box in truth[:count]]
        self.tracked = [scaled(box, source.reduction) for box in answers(source.tracked, truth[0], count)]

    @cached_property
    def visible(self):
        """Indices of the frames with a true box."""
        return [index for index, box in enumerate(self.truth) if box is not None]

    @cached_property
    def mistaken(self):
        """Frames with a box that does not show the target, as (index, box): the tracker's wrong box, or the place of a target that has left."""
        found, last = [], None
        for index, (truth, answer) in enumerate(zip(self.truth, self.tracked)):
            last = truth if truth is not None else last
            if answer is not None and (truth is None or boxes.intersection_over_union(answer, truth) < MISTAKEN_BELOW):
                found.append((index, answer))
            elif truth is None and last is not None:
                found.append((index, last))
        return found


def large(box):
    return box is not None and box[2:].min() >= SMALLEST_SIDE


def scaled(box, factor):
    return None if box is None else box * factor


def answers(path, start, count):
    """The tracker's boxes, one for each frame."""
    lines = boxes.read(path)[:count]
    lines += [None] * (count - len(lines))
    return boxes.aligned(lines, start) if any(line is not None for line in lines) else lines


def read(sources):
    """Opens the clips that training can use: those with at least two visible frames."""
    return [clip for clip in map(Clip, sources) if len(clip.visible) > 1]
