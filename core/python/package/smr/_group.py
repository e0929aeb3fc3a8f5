"""Several targets in one frame."""

import os
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Optional

from ._answer import Answer, Box, State
from ._smr import Tracker


class Group:
    """Follows several targets in the same frames, like `cv2.legacy.MultiTracker`. Trackers of different kinds may be mixed.

    `threads` is the number of threads that work on a frame, at most; without it, there is one for each core. A thread has one workspace for
    all its targets, so a target takes little memory.
    """

    def __init__(self, threads: Optional[int] = None) -> None:
        if threads is not None and threads < 1:
            raise ValueError(f"threads: expected 1 or more, found {threads}")
        self._threads = threads or os.cpu_count() or 1
        self._executor = ThreadPoolExecutor(self._threads)
        self.trackers: list[Tracker] = []

    def add(self, tracker: Tracker, frame, box) -> None:
        """Starts `tracker` on the target in `box` and makes it a member."""
        if any(member is tracker for member in self.trackers):
            raise ValueError("this tracker is in the group already")
        tracker.init(frame, box)
        self.trackers.append(tracker)

    def remove(self, tracker: Tracker) -> None:
        """Follows this target no longer. The tracker keeps it."""
        self.trackers.remove(tracker)

    def follow(self, frame) -> list[Answer]:
        """The answer for each target in the next frame, in the order of `trackers`.

        All are asked first whether they can follow in this frame: if one cannot, none does. Nothing is still running when an exception leaves.
        """
        trackers, threads = tuple(self.trackers), min(self._threads, len(self.trackers))
        if len({id(tracker) for tracker in trackers}) < len(trackers):
            raise ValueError("trackers: expected each tracker once, found one twice")
        for tracker in trackers:
            tracker._check(frame)
        if threads <= 1:
            return [tracker.follow(frame) for tracker in trackers]
        answers, shares = [None] * len(trackers), []
        try:
            for first in range(threads):
                shares.append(self._executor.submit(_follow, trackers[first::threads], frame))
            for first, share in enumerate(shares):
                answers[first::threads] = share.result()
        finally:
            wait(shares)
        return answers

    def update(self, frame) -> tuple[bool, list[Box]]:
        """`(True, boxes)` as `cv2.legacy.MultiTracker` gives them; False if a target is lost."""
        answers = self.follow(frame)
        return all(answer.state != State.LOST for answer in answers), [answer.box for answer in answers]

    def __len__(self) -> int:
        return len(self.trackers)


def _follow(trackers, frame):
    return [tracker.follow(frame) for tracker in trackers]
