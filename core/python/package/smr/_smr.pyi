# The text of each class and method is that of the extension: SMR_RECORD=1 python -m pytest core/python/tests/test_interface.py

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

from ._answer import Answer, Box

# OpenCV types its frames as arrays of any numbers. A call checks that they are uint8.
_Frame = npt.NDArray[Any]
_Box = Union[Sequence[float], npt.NDArray[Any]]
_Path = Union[str, os.PathLike[str]]
_Pair = tuple[int, int]
_Four = tuple[float, float, float, float]

__version__: str

class Tracker:
    """Follows one target. `Paper` and `Robust` are its kinds.

    Frames are numpy arrays of uint8, gray (height, width) or BGR (height, width, 3), all of the same size. Any strides
    will do. OpenCV is not needed. The lock of Python is free while a call works; do not write to the frame then.
    """
    @property
    def quality(self) -> Optional[float]:
        """How distinct the target was from its surroundings at `init`: 0 (it may slip unnoticed) to 1. None without a
        target.
        """
    @property
    def options(self) -> dict[str, Any]:
        """All options by their names, with the preset: `type(tracker)(**tracker.options)` makes one that is alike."""
    def init(self, frame: _Frame, box: _Box) -> None:
        """Starts to follow what is in `box`, (x, y, width, height) in pixels, which must lie inside the frame.

        Forgets any target before. May be called at any time. Fractions are rounded to whole pixels. Raises ValueError if
        the box does not lie inside, or its size does not suit the tracker.
        """
    def update(self, frame: _Frame) -> tuple[bool, Box]:
        """Looks for the target in the next frame: `(ok, box)`, as OpenCV's trackers answer. `ok` is False only if the target
        is lost: a box that is uncertain has True. `follow` says which.
        """
    def follow(self, frame: _Frame) -> Answer:
        """Looks for the target in the next frame: the whole `Answer`."""
    def window(self) -> Optional[Box]:
        """The part of the frame that the next update reads, in whole pixels, or None without a target."""
    def sweep_window(self) -> Optional[Box]:
        """A second part that the next update reads to search for a lost target, in whole pixels, or None."""
    def moved(self, right: float, down: float) -> None:
        """Says that the camera turned: what was at (x, y) is expected at (x + right, y + down) in the next frame. In
        pixels, rounded to 1/256.
        """
    def save(self) -> bytes:
        """The target as bytes, which `restore` reads in Python, Rust, C and MicroPython on any machine, by a tracker with
        the same preset and options.
        """
    def restore(self, saved: bytes) -> None:
        """Continues with a saved target. The tracker must have the options of the one that saved it; the error names the
        first one that differs.
        """

class Paper(Tracker):
    """The tracker of the paper: fast, for a target that keeps its size.

    `preset` is "camera" (bounded time and memory) or "paper" (the authors' program). Each option changes one value of
    it. Numbers are whole; `options` shows those in use.

    - `window`: (x, y), the radius of the search around the last place, in pixels, 0 to 65535.
    - `window_limit`: (x, y), the largest radius while the target is lost, in pixels. At least `window`.
    - `growth`: how much the radius grows in each frame while the target is lost, in pixels, 0 to 65535.
    - `padding`: how far a box may leave the frame, in pixels, 0 to 65535.
    - `neighbourhood`: the runner-up lies more than this many pixels from the peak, in x or in y, 0 to 65535.
    - `update_zone`: (left, top, right, bottom), how far a box must keep from the edges of the frame for the tracker to
      learn from it, in pixels, 0 to 65535.
    - `k`: (numerator, denominator), the next threshold as a part of the largest difference of two pixels. More than 0.
    - `first_threshold`: of the first update, in gray levels, 1 to 255. Pixels that differ by less are similar.
    - `least_threshold`: of all later updates, in gray levels, 0 to 255. 0 and 1 set no bound.
    - `gate_tracking`: (numerator, denominator), the score of the peak over that of the runner-up that is needed inside
      the frame. Below 1 every peak is accepted. Each part is 0 to 65535, the denominator at least 1.
    - `gate_leaving`: the same for a box that is partly outside the frame.
    - `gate_returning`: the same after a box was partly outside the frame.
    - `gate_lost`: the same to find a lost target again.
    - `gate_lead`: the lead over the runner-up that is enough without any of these, in similar pixels, 0 to 65535.
    - `least_ratio`: the least similarity of an accepted peak, in units of 1/65535, 0 to 65535. 0 also turns off the
      detection of a covered lens.
    - `runner_up_always`: True searches the runner-up in every frame, which takes more time, False where it decides.
    """
    def __new__(
        cls,
        preset: Literal["camera", "paper"] = "camera",
        *,
        k: _Pair = ...,
        gate_tracking: _Pair = ...,
        gate_leaving: _Pair = ...,
        gate_returning: _Pair = ...,
        gate_lost: _Pair = ...,
        gate_lead: int = ...,
        least_ratio: int = ...,
        first_threshold: int = ...,
        least_threshold: int = ...,
        padding: int = ...,
        window: _Pair = ...,
        growth: int = ...,
        window_limit: _Pair = ...,
        neighbourhood: int = ...,
        runner_up_always: bool = ...,
        update_zone: tuple[int, int, int, int] = ...,
    ) -> Paper: ...

class Robust(Tracker):
    """The robust tracker: follows changes of size, light and view, and searches the whole frame for a lost target.

    `preset` is "refined" or "robust", which is without the refiner. Each option changes one value of it. Numbers are
    whole; `options` shows those in use.

    - `reach`: the radius of the search in cells, 4 to 8. A cell is a tenth of the root of the target's area.
    - `size`: True if the box follows the target's size.
    - `sweep`: True to search a lost target in the whole frame, False to search around its last place.
    - `refiner`: True if a small learned network corrects the box. It can also make the state uncertain or lost.
    - `patience`: the part of its value that the confidence keeps in each frame, in units of 1/256, 0 to 255. A higher
      one holds on for longer, also to errors.
    - `lost_below`: the confidence below which the target is lost, in units of 1/65535, 0 to 65535.
    - `uncertain_below`: the confidence below which it is uncertain, in the same units. At least `lost_below`.
    - `learning_rate`: how fast the filter learns, in units of 1/256, 0 (never) to 256.
    - `early_rate`: how fast the template of the first frame learns, in units of 1/1024, 0 (never) to 1024.
    """
    def __new__(
        cls,
        preset: Literal["refined", "robust"] = "refined",
        *,
        size: bool = ...,
        sweep: bool = ...,
        reach: int = ...,
        patience: int = ...,
        lost_below: int = ...,
        uncertain_below: int = ...,
        learning_rate: int = ...,
        early_rate: int = ...,
        refiner: bool = ...,
    ) -> Robust: ...

class Recording:
    """A recording as host-sim reads it: a folder of pictures, a video, Y4M, a built-in one such as "street", a camera of
    Linux ("/dev/video0"), or an address ("rtsp://camera.local/stream").

    Iterating over it decodes its frames one at a time: arrays of uint8, gray (height, width), or BGR (height, width, 3)
    with `color=True`. A camera or an address always gives its newest frame: those that came while the last one was in
    use are dropped. After a fork, begin to iterate anew.

    Videos, cameras and addresses need ffmpeg (not OpenCV) on the PATH. Raises ValueError if the recording cannot be
    opened; iterating raises OSError at a damaged frame, or if a camera fails.
    """
    def __new__(cls, path: _Path, *, color: bool = False) -> Recording: ...
    @property
    def name(self) -> str:
        """The name of the folder or file."""
    @property
    def is_live(self) -> bool:
        """True for a camera or an address: its frames have no end, and come at their own time."""
    @property
    def start(self) -> Optional[_Four]:
        """The box to start from, which lies beside the recording: (x, y, width, height) in pixels, or None."""
    @property
    def truth(self) -> Optional[list[Optional[_Four]]]:
        """The box of each frame, (x, y, width, height) in pixels, None where the target is hidden. None without ground
        truth.
        """
    def __iter__(self) -> Iterator[npt.NDArray[np.uint8]]: ...
    def score(self, boxes: Sequence[Optional[_Box]]) -> dict[str, Any]:
        """The figures of `host-sim eval` for any tracker's boxes, as a dict by their names.

        `boxes` has (x, y, width, height) in pixels for each frame, or None where the tracker has no answer. Raises
        ValueError without ground truth, or if the number of boxes differs from it.
        """

def start_beside(path: _Path) -> Optional[_Four]:
    """The box to start from that lies beside a file, (x, y, width, height) in pixels, or None. Its frames are not read.

    Raises ValueError if a file with boxes cannot be read.
    """
def recordings(paths: Sequence[_Path]) -> list[os.PathLike[str]]:
    """The recordings in folders, as host-sim finds them: a path each. Raises ValueError if a folder has none."""
def measure(path: _Path, trackers: Mapping[str, Tracker], starts: Union[str, int]) -> dict[str, list[Any]]:
    """Measures trackers on one recording: the table `measured` of `host-sim eval --robustness`, as columns. `smr.evaluate`
    takes many recordings, and says what `starts` may be.
    """
def follow(trackers: Sequence[Tracker], frame: _Frame, threads: int) -> list[Answer]:
    """For `Group`: the answers of all trackers in the next frame, by at most `threads` threads. If one of them cannot follow, or
    is in use, none does.
    """
