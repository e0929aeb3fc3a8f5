"""Follows several targets in the same frames."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Optional

from ._answer import Answer, Box, State
from ._smr import Tracker, follow

if TYPE_CHECKING:
    from ._smr import _Box, _Frame


class Group:
    """Follows several targets in the same frames, like `cv2.legacy.MultiTracker`. Trackers of different kinds may be mixed.

    `threads` is the most threads that work on a frame, by default one per core. They end with the frame.
    """

    def __init__(self, threads: Optional[int] = None) -> None:
        if threads is not None and threads < 1:
            raise ValueError(f"threads: expected 1 or more, found {threads}")
        self._threads = threads or os.cpu_count() or 1
        self.trackers: list[Tracker] = []

    def add(self, tracker: Tracker, frame: _Frame, box: _Box) -> None:
        """Starts `tracker` on the target in `box` and adds it to the group."""
        if not isinstance(tracker, Tracker):
            raise TypeError(f"tracker: expected a tracker such as smr.Robust(), found {tracker!r}")
        if any(member is tracker for member in self.trackers):
            raise ValueError("this tracker is in the group already")
        tracker.init(frame, box)
        self.trackers.append(tracker)

    def remove(self, tracker: Tracker) -> None:
        """Removes a tracker from the group. The tracker keeps its target."""
        self.trackers.remove(tracker)

    def follow(self, frame: _Frame) -> list[Answer]:
        """Finds all targets in the next frame. Returns the answers in the order of `trackers`.

        If a tracker cannot follow in this frame, or another thread uses it, no tracker does: raises the error of `Tracker.follow`.
        """
        trackers = list(self.trackers)
        if len({id(tracker) for tracker in trackers}) < len(trackers):
            raise ValueError("trackers: expected each tracker once, found one twice")
        return follow(trackers, frame, self._threads)

    def update(self, frame: _Frame) -> tuple[bool, list[Box]]:
        """Returns `(True, boxes)` like `cv2.legacy.MultiTracker`; False only if a target is lost: see `Tracker.update`."""
        answers = self.follow(frame)
        return all(answer.state != State.LOST for answer in answers), [answer.box for answer in answers]

    def __len__(self) -> int:
        return len(self.trackers)

    def __repr__(self) -> str:
        return f"<smr.Group of {len(self)} trackers, {self._threads} threads>"
