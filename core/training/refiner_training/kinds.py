"""The kinds of samples: what the present crop shows, and how it was chosen."""

from enum import IntEnum


class Kind(IntEnum):
    # The target, with a correction to learn.
    JITTERED = 0  # a pair of frames, a box with a random error
    TRACKED = 1  # a pair of frames, the tracker's own box
    CUTOUT = 2  # a made sample
    # Another thing.
    BESIDE = 3  # a place near the target
    RESEMBLING = 4  # a place that correlates with the target
    ELSEWHERE = 5  # a box of another recording
    MISTAKEN = 6  # the tracker's wrong box, or the place of a target that has left
    OTHER_PIECE = 7  # a made sample with another piece, or with none
    # The target, in other light, hidden in part, blurred or turned.
    DISTURBED = 8  # a pair of frames
    DISTURBED_CUTOUT = 9  # a made sample


CORRECTED = (Kind.JITTERED, Kind.TRACKED, Kind.CUTOUT)
OTHERS = (Kind.BESIDE, Kind.RESEMBLING, Kind.ELSEWHERE, Kind.MISTAKEN, Kind.OTHER_PIECE)
