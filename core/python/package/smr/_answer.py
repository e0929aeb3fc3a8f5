"""The answer of a tracker: its state, its boxes and its figures."""

import enum
from typing import NamedTuple, Optional, Union


class State(str, enum.Enum):
    """The state of the target after a frame, as the tracker judges it. The value is the word that host-sim prints."""

    TRACKING = "tracking"
    LEAVING = "leaving"
    UNCERTAIN = "uncertain"
    LOST = "lost"

    __str__ = str.__str__


# The states, indexed by their code in smr-core.
STATES = tuple(State)


class Box(NamedTuple):
    """A box in whole pixels: the left and the top edge, the width and the height."""

    x: int
    y: int
    width: int
    height: int

    @property
    def xyxy(self) -> tuple[int, int, int, int]:
        """The left, top, right and bottom edge, as detectors give boxes."""
        return self.x, self.y, self.x + self.width, self.y + self.height


class FineBox(NamedTuple):
    """A box in pixels, in steps of 1/256."""

    x: float
    y: float
    width: float
    height: float

    @property
    def xyxy(self) -> tuple[float, float, float, float]:
        """The left, top, right and bottom edge."""
        return self.x, self.y, self.x + self.width, self.y + self.height


class Answer(NamedTuple):
    """The box of the target, and its reliability. Confidence, ratios and identity are 0 to 1."""

    box: Box
    """The box of the target. When it is lost, `Paper` gives the last box that it accepted, `Robust` its best guess."""
    fine_box: FineBox
    """The box with fractions of a pixel. `Paper` always gives whole pixels."""
    state: State
    confidence: float
    """The confidence in the box."""
    ratio: float
    """The similarity of the box to the template: from `Paper`, the similarity matching ratio."""
    runner_up_ratio: Optional[float]
    """The ratio of the runner-up, or None if no decision depended on it. Always None from `Robust`."""
    alpha: Optional[int]
    """The threshold of the frame in gray levels, 1 to 255. None from `Robust`."""
    identity: Optional[float]
    """The judgement of the refiner's network that the box shows the target of the `init`, a running mean over about four frames: 1 is certain,
    0.5 undecided, 0 certain that it shows something else. Below 0.583 the state is uncertain or lost. None without the refiner."""
    scale: float
    """The size of the target divided by its size at `init`. Always 1 from `Paper`."""
    found_again: bool
    """True in the frame in which a lost target was found."""

    def row(self) -> dict[str, Union[str, float, None]]:
        """The answer as a flat dict, for `pandas.DataFrame(answer.row() for answer in answers)`. x, y, width and height are of `fine_box`."""
        figures = {name: getattr(self, name) for name in self._fields[3:]}
        return {"state": self.state.value, **self.fine_box._asdict(), **figures}
