"""Follows one target, or several, through 8-bit frames by the Similarity Matching Ratio.

    tracker = smr.Robust()
    tracker.init(frame, (x, y, width, height))
    ok, box = tracker.update(next_frame)

Frames are numpy arrays of uint8: gray (height, width), or BGR (height, width, 3) as OpenCV gives them. OpenCV itself is not needed. The answers are those of the Rust crate
smr-core, bit for bit.
"""

from ._answer import Answer, Box, FineBox, State
from ._evaluate import evaluate
from ._group import Group
from ._smr import Paper, Recording, Robust, Tracker, __version__, recordings

__all__ = [
    "Answer", "Box", "FineBox", "Group", "Paper", "Recording", "Robust", "State", "Tracker", "__version__", "evaluate", "recordings",
    "restore",
]  # fmt: skip


def restore(saved: bytes) -> Tracker:
    """Restores a target that `Tracker.save` wrote, if its tracker has a preset's options; returns a tracker with the same preset.

    For other options call `restore` of a tracker that has them. The error names the first option that differs.
    """
    error = None
    robust = [Robust(preset) for preset in ("refined", "robust", "small", "small_refined")]
    for tracker in (*robust, Paper(), Paper("paper")):
        try:
            tracker.restore(saved)
            return tracker
        except ValueError as refusal:
            # Prefers the error of a tracker of the saved kind and size: the others only report that these are wrong.
            if error is None or "by another tracker" in str(error):
                error = refusal
    raise error
