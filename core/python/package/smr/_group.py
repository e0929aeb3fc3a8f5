"""Several targets in one frame."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Optional

from ._answer import Answer, Box, State
from ._smr import Tracker, follow

if TYPE_CHECKING:
    from ._smr import _Box, _Frame


class Group:
    """Follows several targets in the same frames, like `cv2.legacy.MultiTracker`. Trackers of different kinds may be mixed.

    `threads` is the number of threads that work on a frame, at most; without it, there is one for each core. They end with the frame.
    """

    def __init__(self, threads: Optional[int] = None) -> None:
        if threads is not None and threads < 1:
            raise ValueError(f"threads: expected 1 or more, found {threads}")
        self._threads = threads or os.cpu_count() or 1
        self.trackers: list[Tracker] = []

    def add(self, tracker: Tracker, frame: _Frame, box: _Box) -> None:
        """Starts `tracker` on the target in `box` and makes it a member."""
        if not isinstance(tracker, Tracker):
            raise TypeError(f"tracker: expected a tracker such as smr.Robust(), found {tracker!r}")
        if any(member is tracker for member in self.trackers):
            raise ValueError("this tracker is in the group already")
        tracker.init(frame, box)
        self.trackers.append(tracker)

    def remove(self, tracker: Tracker) -> None:
        """Follows this target no longer. The tracker keeps it."""
        self.trackers.remove(tracker)

    def follow(self, frame: _Frame) -> list[Answer]:
        """The answer for each target in the next frame, in the order of `trackers`.

        If one cannot follow in this frame, or another thread uses it, none does: the call raises what `Tracker.follow` would.
        """
        trackers = list(self.trackers)
        if len({id(tracker) for tracker in trackers}) < len(trackers):
            raise ValueError("trackers: expected each tracker once, found one twice")
        return follow(trackers, frame, self._threads)

    def update(self, frame: _Frame) -> tuple[bool, list[Box]]:
        """`(True, boxes)` as `cv2.legacy.MultiTracker` gives them; False only if a target is lost: see `Tracker.update`."""
        answers = self.follow(frame)
        return all(answer.state != State.LOST for answer in answers), [answer.box for answer in answers]

    def __len__(self) -> int:
        return len(self.trackers)

    def __repr__(self) -> str:
        return f"<smr.Group of {len(self)} trackers, {self._threads} threads>"
