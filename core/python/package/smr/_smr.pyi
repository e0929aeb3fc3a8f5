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
    """Follows one target. Its subclasses are `Paper` and `Robust`.

    Frames are numpy arrays of uint8, gray (height, width) or BGR (height, width, 3), of one size, with any strides.
    OpenCV is not needed. Calls release the lock of Python (GIL); do not write to the frame meanwhile.
    """
    @property
    def answer(self) -> Optional[Answer]:
        """The `Answer` of the last `update` or `follow`; None directly after `init` or `restore`."""
    @property
    def quality(self) -> Optional[float]:
        """Distinctness of the target from shifted copies at `init`, from 0 (the box may slip along the target unnoticed)
        to 1. None without a target.
        """
    @property
    def options(self) -> dict[str, Any]:
        """All options by name, and the preset: `type(tracker)(**tracker.options)` creates an equal tracker."""
    def init(self, frame: _Frame, box: _Box) -> None:
        """Starts to follow the target in `box`, (x, y, width, height) in pixels, which must lie inside the frame.

        Forgets any previous target. May be called at any time. Fractions are rounded to whole pixels. Raises ValueError
        if the box is not inside, or its size does not suit the tracker.
        """
    def update(self, frame: _Frame) -> tuple[bool, Box]:
        """Finds the target in the next frame: `(ok, box)`, as OpenCV's trackers answer. `ok` is False only if the target
        is lost; the attribute `answer` tells whether the box is uncertain.
        """
    def follow(self, frame: _Frame) -> Answer:
        """Finds the target in the next frame and returns the whole `Answer`."""
    def window(self) -> Optional[Box]:
        """The part of the frame that the next update reads, in whole pixels; None without a target."""
    def sweep_window(self) -> Optional[Box]:
        """The second part of the frame that the next update reads, to search for a lost target, in whole pixels; None if
        there is no such part.
        """
    def moved(self, right: float, down: float) -> None:
        """Reports a turn of the camera: (x, y) is expected at (x + right, y + down), in pixels rounded to 1/256."""
    def save(self) -> bytes:
        """Saves the target as bytes, for `restore` with equal preset and options, in Python, Rust, C or MicroPython."""
    def restore(self, saved: bytes) -> None:
        """Continues with a saved target. It must have been saved with equal options; if not, the error names the first
        option that differs.
        """

class Paper(Tracker):
    """The tracker of the paper: fast, for a target that keeps its size.

    `preset` is "camera" (bounded time and memory) or "paper" (the authors' program). Options change its values.

    - `k`, a tuple of two whole numbers of 1 to 65535: The factor of alpha: the next alpha is `k` times the largest change of a pixel in an update of the template.
    - `gate_tracking`, a tuple of two whole numbers of 0 to 65535: The ratio of peak and runner-up that is needed while the target stays inside the frame. Below 1 every peak above 0 is accepted.
    - `gate_leaving`, a tuple of two whole numbers of 0 to 65535: The ratio of peak and runner-up that is needed if the box at the peak is partly outside the frame.
    - `gate_returning`, a tuple of two whole numbers of 0 to 65535: The ratio of peak and runner-up that is needed after a box was partly outside the frame, until a lost target is found again.
    - `gate_lost`, a tuple of two whole numbers of 0 to 65535: The ratio of peak and runner-up that is needed to find a lost target again.
    - `gate_lead`, a whole number of 0 to 65535: The lead of the peak over the runner-up that is enough whatever their ratio is, in fully similar pixels.
    - `least_ratio`, a whole number of 0 to 65535: The least similarity matching ratio of an accepted peak, in units of 1/65535. 0, the paper's value, also turns off the check for a covered lens: a patch inside the frame needs a quarter of the template's contrast (mean absolute deviation), and its pixels at 0 or 255 may exceed those of the template by at most half of all pixels.
    - `first_threshold`, a whole number of 1 to 255: alpha of the first update, in gray levels. Pixels that differ by less are similar.
    - `least_threshold`, a whole number of 0 to 255: The least alpha of later updates, in gray levels. 0 (the paper's value) and 1 set no bound, so that after a still scene a change of light leaves no pixel that matches.
    - `padding`, a whole number of 0 to 65535: The width of the black border around the frame, in pixels: how far a box may leave the frame.
    - `window`, a tuple of two whole numbers of 0 to 65535: The radius of the search window around the last position, in pixels.
    - `growth`, a whole number of 0 to 65535: The growth of the window in each frame while the target is lost, in pixels on each side.
    - `window_limit`, a tuple of two whole numbers of 0 to 65535: The largest radius while the target is lost, in pixels; at least `window`. The padded frame always bounds it.
    - `neighbourhood`, a whole number of 0 to 65535: The runner-up is the best score more than this many pixels from the peak, in x or in y.
    - `runner_up_always`, True or False: The runner-up is searched in every frame, which takes several times as long, not only if the gate needs it.
    - `update_zone`, a tuple of four whole numbers of 0 to 65535: The distances that a box must keep from the edges of the frame for the tracker to learn from it, in pixels.
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

    `preset` is "refined" or "robust" (without the refiner). "small_refined" and "small" take less memory and time, and
    have a `reach` of at most 7. Options change its values; `options` shows all.

    - `size`, True or False: The box follows the size of the target.
    - `sweep`, a whole number of 0 to 255: Windows in which each frame is searched for a lost target, besides the one around its last place. From frame to frame they sweep the whole picture. Each takes about as much work as the search of a frame. 0: no sweep.
    - `reach`, a whole number of 4 to 8: The radius of the search in cells. The side of a cell is a tenth of the root of the target's area. The work of an update grows with the square of 2 `reach` + 1. At most 7 in a tracker of the small size.
    - `patience`, a whole number of 0 to 255: The part of its value that the confidence keeps in each frame, in units of 1/256. A higher one holds on to the target for longer: through short occlusions, but also through errors.
    - `lost_below`, a whole number of 0 to 65535: The target is lost while the confidence is below this, in units of 1/65535.
    - `uncertain_below`, a whole number of 0 to 65535: The target is uncertain while the confidence is below this, in units of 1/65535; at least `lost_below`.
    - `learning_rate`, a whole number of 0 to 256: The learning rate of the filter, in units of 1/256: 0 keeps the filter of the first frame, 256 takes the exact step for the present frame.
    - `early_rate`, a whole number of 0 to 1024: The learning rate of the early template, in units of 1/1024.
    - `refiner`, True or False: A small learned network corrects the box. It keeps the box to a target that comes nearer, turns or changes its shape, reads more of the frame, and can make the state *uncertain* or *lost*. In firmware a build without the feature `refiner` refuses it.
    """
    def __new__(
        cls,
        preset: Literal["refined", "robust", "small", "small_refined"] = "refined",
        *,
        size: bool = ...,
        sweep: int = ...,
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
    Linux ("/dev/video0" or its number, 0), or an address ("rtsp://camera.local/stream").

    Iterating over it decodes one frame at a time: arrays of uint8, gray (height, width), or BGR (height, width, 3) with
    `color=True`. A camera or an address yields its newest frame and drops older ones. After a fork, or a Ctrl-C while
    a frame was read, iterate anew. `close` of the iterator ends it, also while another thread waits for a frame.

    Videos, cameras and addresses need ffmpeg (not OpenCV) on the PATH. Raises ValueError if the recording cannot be
    opened; iterating raises OSError at a damaged frame, or if a camera fails.
    """
    def __new__(cls, path: Union[_Path, int], *, color: bool = False) -> Recording: ...
    @property
    def fps(self) -> Optional[float]:
        """Frames per second, from the times of the first 31 frames. None for a live source or with fewer than two times."""
    @property
    def size(self) -> Optional[tuple[int, int]]:
        """Width and height of the frames in pixels; None for a camera or an address."""
    @property
    def name(self) -> str:
        """The name of the folder or file."""
    @property
    def is_live(self) -> bool:
        """True for a camera or an address, whose frames have no end and arrive in real time."""
    @property
    def start(self) -> Optional[_Four]:
        """The initial box, from a file beside the recording: (x, y, width, height) in pixels, or None."""
    @property
    def truth(self) -> Optional[list[Optional[_Four]]]:
        """The true box of each frame, (x, y, width, height) in pixels or None (hidden target). None without ground truth."""
    def __len__(self) -> int: ...
    def __iter__(self) -> Frames: ...
    def score(self, boxes: Sequence[Optional[_Box]]) -> dict[str, Any]:
        """Scores the boxes of any tracker. Returns the figures of `host-sim eval` as a dict from name to value.

        `boxes` has (x, y, width, height) in pixels for each frame, or None where the tracker has no answer. Raises
        ValueError without ground truth, or if the number of boxes differs from it.
        """

class Frames(Iterator[npt.NDArray[np.uint8]]):
    """An iterator over the frames of a `Recording`, from `iter(recording)`."""
    def __iter__(self) -> Frames: ...
    def __next__(self) -> npt.NDArray[np.uint8]: ...
    def close(self) -> None:
        """Ends the iteration, also while another thread waits for a frame. Closes a camera, and ends its ffmpeg."""

class Stop:
    """Ends calls from another thread. A copy in another process ends none."""
    def __new__(cls) -> Stop: ...
    def end(self) -> None:
        """Ends the calls that were given this object, now and later."""

def start_beside(path: _Path) -> Optional[_Four]:
    """The initial box, from a file beside `path`: (x, y, width, height) in pixels, or None. Reads no frame.

    Raises ValueError if a file with boxes cannot be read.
    """
def recordings(paths: Sequence[_Path]) -> list[os.PathLike[str]]:
    """Finds the recordings in folders, as host-sim does: a list of paths. Raises ValueError if a folder has none."""
def measure(
    path: _Path, trackers: Mapping[str, Tracker], starts: Union[str, int], stop: Optional[Stop] = None
) -> dict[str, list[Any]]:
    """Measures trackers on one recording. Returns the table `measured` of `host-sim eval --robustness` as a dict of
    columns. `starts` is 'given', 'near' or the number of frames between starts, as documented at `smr.evaluate`. `stop`
    ends the call from another thread.
    """
def follow(trackers: Sequence[Tracker], frame: _Frame, threads: int) -> list[Answer]:
    """Updates all trackers of a `Group` on at most `threads` threads. Updates no tracker if any tracker is in use by
    another thread or would refuse the frame.
    """
