import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

from ._answer import Answer, Box

_Frame = npt.NDArray[np.uint8]
_Box = Union[Sequence[float], npt.NDArray[Any]]
_Path = Union[str, os.PathLike[str]]
_Pair = tuple[int, int]
_Four = tuple[float, float, float, float]

class Tracker:
    @property
    def quality(self) -> Optional[float]: ...
    @property
    def options(self) -> dict[str, Any]: ...
    def init(self, frame: _Frame, box: _Box) -> None: ...
    def update(self, frame: _Frame) -> tuple[bool, Box]: ...
    def follow(self, frame: _Frame) -> Answer: ...
    def window(self) -> Optional[Box]: ...
    def sweep_window(self) -> Optional[Box]: ...
    def moved(self, right: float, down: float) -> None: ...
    def save(self) -> bytes: ...
    def restore(self, saved: bytes) -> None: ...

class Paper(Tracker):
    def __new__(
        cls,
        preset: Literal["camera", "paper"] = "camera",
        *,
        window: _Pair = ...,
        window_limit: _Pair = ...,
        k: _Pair = ...,
        first_threshold: int = ...,
        least_threshold: int = ...,
        padding: int = ...,
        growth: int = ...,
        neighbourhood: int = ...,
        update_zone: tuple[int, int, int, int] = ...,
        gate_tracking: _Pair = ...,
        gate_leaving: _Pair = ...,
        gate_returning: _Pair = ...,
        gate_lost: _Pair = ...,
        gate_lead: int = ...,
        least_ratio: int = ...,
        runner_up_always: bool = ...,
    ) -> Paper: ...

class Robust(Tracker):
    def __new__(
        cls,
        preset: Literal["refined", "robust"] = "refined",
        *,
        reach: int = ...,
        size: bool = ...,
        sweep: bool = ...,
        refiner: bool = ...,
        patience: int = ...,
        lost_below: int = ...,
        uncertain_below: int = ...,
        learning_rate: int = ...,
        early_rate: int = ...,
    ) -> Robust: ...

class Recording:
    def __new__(cls, path: _Path) -> Recording: ...
    @property
    def name(self) -> str: ...
    @property
    def start(self) -> Optional[_Four]: ...
    @property
    def truth(self) -> Optional[list[Optional[_Four]]]: ...
    def __iter__(self) -> Iterator[_Frame]: ...
    def score(self, boxes: Sequence[Optional[_Box]]) -> dict[str, Any]: ...

def recordings(paths: Sequence[_Path]) -> list[os.PathLike[str]]: ...
def measure(path: _Path, trackers: Mapping[str, Tracker], starts: Union[str, int]) -> dict[str, list[Any]]: ...
