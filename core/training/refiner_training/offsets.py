"""Draws wrong boxes at random around a right one."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Spread:
    """Standard deviations of a box's errors: log size, log aspect, and centre in sides of the box."""

    size: float
    aspect: float
    centre: float

    def times(self, factor):
        return Spread(self.size * factor, self.aspect * factor, self.centre * factor)


# Default spread of the drawn errors: equal to that of the tracker's own errors, or slightly larger.
WIDE = Spread(0.21, 0.15, 0.11)
# Share of boxes that are drawn with a larger spread, and the factor by which it is larger.
WIDER_SHARE, WIDER_FACTOR = 0.15, 1.6
LIMIT = Spread(0.6, 0.35, 0.3)


def drawn(rng, box, spread=WIDE):
    """Returns `box` with a random error."""
    if rng.random() < WIDER_SHARE:
        spread = spread.times(WIDER_FACTOR)
    size = limited(rng, spread.size, LIMIT.size)
    aspect = limited(rng, spread.aspect, LIMIT.aspect)
    sides = box[2:] * np.exp([size + aspect, size - aspect])
    move = np.array([limited(rng, spread.centre, LIMIT.centre), limited(rng, spread.centre, LIMIT.centre)])
    return np.concatenate([box[:2] + move * sides, sides])


def limited(rng, deviation, limit):
    return float(np.clip(rng.normal(0, deviation), -limit, limit))
