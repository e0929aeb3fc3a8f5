"""Samples from recordings: the target in one frame, a wrong box in another, and the correction to the true one.

Half of the pairs that begin in the first frame have the tracker's own box, where it overlaps the target.
"""

from . import boxes, crops, offsets

# Shares of the pairs that begin in the first frame, as all do in tracking, and of those whose second frame may be far.
FIRST_SHARE, FAR_SHARE = 0.4, 0.6
NEAR = 60
TRACKED_SHARE = 0.5
LEAST_OVERLAP = 0.25
# So that two samples with the same answer of the tracker differ.
AROUND_ANSWER = offsets.Spread(0.05, 0.03, 0.03)
# Larger errors are not learned, and boxes with fewer pixels than this.
LARGEST_CORRECTION = 0.75
SMALLEST_SIDE = 3
TRIES = 20


def drawn(rng, clips):
    """First crop, present crop, correction, and whether the box was the tracker's."""
    while True:
        clip = clips[rng.integers(len(clips))]
        for _ in range(TRIES):
            first, present = frames(rng, clip)
            box, tracked = wrong_box(rng, clip, first, present)
            change = boxes.correction(box, clip.truth[present])
            if abs(change).max() <= LARGEST_CORRECTION and box[2:].min() >= SMALLEST_SIDE:
                return crops.crop(clip.frames[first], clip.truth[first]), crops.crop(clip.frames[present], box), change, tracked


def frames(rng, clip):
    """Two frames in which the target is visible."""
    visible = clip.visible
    kind = rng.random()
    first = 0 if kind < FIRST_SHARE else int(rng.integers(len(visible)))
    if kind < FAR_SHARE:
        present = int(rng.integers(len(visible)))
    else:
        present = min(max(first + int(rng.integers(-NEAR, NEAR + 1)), 0), len(visible) - 1)
    return visible[first], visible[present]


def wrong_box(rng, clip, first, present):
    """A box in the present frame, and whether the tracker gave it."""
    truth = clip.truth[present]
    if first == clip.visible[0] and rng.random() < TRACKED_SHARE:
        answer = clip.tracked[present]
        if answer is not None and boxes.intersection_over_union(truth, answer) > LEAST_OVERLAP:
            return offsets.drawn(rng, answer, AROUND_ANSWER), True
    return offsets.drawn(rng, truth), False
