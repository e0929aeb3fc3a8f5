"""A target for benchmark toolkits: it starts on the visible part of a box, and has a box in every frame."""

import math

from ._answer import Box, State


def inside(box, frame):
    """Clips a box to the frame, in whole pixels, because toolkits give boxes that reach beyond it.

    Raises ValueError if the box has no pixel in the frame.
    """
    height, width = frame.shape[:2]
    left, top, right, bottom = (
        # max(0, NaN) is 0.
        math.floor(min(max(0, edge), side) + 0.5)
        for edge, side in zip((box[0], box[1], box[0] + box[2], box[1] + box[3]), (width, height, width, height))
    )
    if left >= right or top >= bottom:
        place = ",".join(f"{number:g}" for number in box)
        raise ValueError(f"the box {place} (x,y,width,height) has no pixel in the frame of {width}x{height} pixels")
    return Box(left, top, right - left, bottom - top)


class Target:
    """A target that a tracker follows. `box` is its last visible box; `confidence` is 0 while it is lost."""

    def __init__(self, tracker, frame, box):
        self.box, self.confidence = inside(box, frame), 1.0
        self._tracker = tracker
        tracker.init(frame, self.box)

    def follow(self, frame):
        answer = self._tracker.follow(frame)
        if answer.state == State.LOST:
            self.confidence = 0.0
        else:
            self.box, self.confidence = answer.fine_box, answer.confidence
        return self.box
