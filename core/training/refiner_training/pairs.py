"""Samples from recordings: the target in one frame, a wrong box in another, and the correction to the true one.

Half of the pairs that begin in the first frame use the tracker's own box, if it overlaps the target.
"""

from . import boxes, crops, offsets

# Share of pairs whose first frame is the first visible one, as in tracking, and share of pairs with any distance
# between their frames, which includes the former. In all other pairs the frames are at most NEAR visible frames apart.
FIRST_SHARE, FAR_SHARE = 0.4, 0.6
NEAR = 60
TRACKED_SHARE = 0.5
MIN_OVERLAP = 0.25
# Random error around the tracker's box, so that two samples with the same box differ.
AROUND_ANSWER = offsets.Spread(0.05, 0.03, 0.03)
# Largest absolute element of a sample's correction, in sides of the wrong box or log ratios, and smallest side of the
# wrong box, in pixels of the reduced frame. Samples beyond these limits are not used.
LARGEST_CORRECTION = 0.75
SMALLEST_SIDE = 3
TRIES = 20


def drawn(rng, clips):
    """Draws a sample: first crop, present crop, correction, and whether the box is the tracker's."""
    while True:
        clip = clips[rng.integers(len(clips))]
        for _ in range(TRIES):
            first, present = frames(rng, clip)
            box, tracked = wrong_box(rng, clip, first, present)
            change = boxes.correction(box, clip.truth[present])
            if abs(change).max() <= LARGEST_CORRECTION and box[2:].min() >= SMALLEST_SIDE:
                return crops.crop(clip.frames[first], clip.truth[first]), crops.crop(clip.frames[present], box), change, tracked


def frames(rng, clip):
    """Draws the indices of two frames in which the target is visible."""
    visible = clip.visible
    kind = rng.random()
    first = 0 if kind < FIRST_SHARE else int(rng.integers(len(visible)))
    if kind < FAR_SHARE:
        present = int(rng.integers(len(visible)))
    else:
        present = min(max(first + int(rng.integers(-NEAR, NEAR + 1)), 0), len(visible) - 1)
    return visible[first], visible[present]


def wrong_box(rng, clip, first, present):
    """Draws a wrong box in the present frame, and whether it is the tracker's."""
    truth = clip.truth[present]
    if first == clip.visible[0] and rng.random() < TRACKED_SHARE:
        answer = clip.tracked[present]
        if answer is not None and boxes.intersection_over_union(truth, answer) > MIN_OVERLAP:
            return offsets.drawn(rng, answer, AROUND_ANSWER), True
    return offsets.drawn(rng, truth), False
