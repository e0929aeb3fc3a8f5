"""Samples for telling the target from another thing: crops that do not show it, and crops that show it disturbed.

A sample is a first crop, a present crop, a correction (0 without the target) and its kind.
"""

import cv2
import numpy as np

from . import boxes, crops, cutouts, disturbances, offsets, pairs
from .kinds import Kind

# Share of each kind among the drawn groups. A group of resembling places has up to MAX_PLACES samples.
SHARES = {
    Kind.BESIDE: 0.20,
    Kind.RESEMBLING: 0.11,
    Kind.ELSEWHERE: 0.13,
    Kind.MISTAKEN: 0.13,
    Kind.OTHER_PIECE: 0.11,
    Kind.DISTURBED: 0.19,
    Kind.DISTURBED_CUTOUT: 0.13,
}
# Largest overlap (IoU) of a box with the target that it does not show.
MAX_OVERLAP = 0.12
ANYWHERE_SHARE = 0.3  # of places beside the target
BESIDE_DEVIATION = 1.3  # of the other places, in sides of the target
RANDOM_PLACE_SHARE = 0.4  # of the boxes of other recordings: a random place
FIRST_SHARE = 0.6  # of first crops that show the first visible frame
AROUND_PLACE = offsets.Spread(0.12, 0.08, 0.05)
AROUND_MISTAKE = offsets.Spread(0.08, 0.05, 0.06)
# Search for resembling places: radius in sides of the target, at least MIN_RADIUS pixels; side of the reduced template.
RADIUS, MIN_RADIUS, TEMPLATE_SIDE = 4, 60, 14
MAX_PLACES, MAX_PEAKS, MIN_CORRELATION = 4, 12, -0.9
TURN = 0.25  # standard deviation of a disturbed target's turn, radians
TURNED_SHARE = 0.4
OTHER_CLIP_SHARE, WITHOUT_PIECE_SHARE = 0.3, 0.3
TRIES = 20


def drawn(rng, clips):
    """Draws a group of one to MAX_PLACES samples."""
    kinds, shares = list(SHARES), np.array(list(SHARES.values()))
    while True:
        # Another kind after a failure: a single recording has no other one, and not every recording has a mistake.
        kind = kinds[rng.choice(len(kinds), p=shares / shares.sum())]
        group = DRAW[kind](rng, clips)
        if group:
            return [(first, present, change, kind) for first, present, change in group]


def any_clip(rng, clips):
    return clips[rng.integers(len(clips))]


def frames(rng, clip):
    """Draws the indices of two frames in which the target is visible; the first is mostly the first visible one."""
    visible = clip.visible
    first = visible[0] if rng.random() < FIRST_SHARE else visible[int(rng.integers(len(visible)))]
    return first, visible[int(rng.integers(len(visible)))]


def usable(frame, box):
    height, width = frame.shape
    return box[2:].min() >= pairs.SMALLEST_SIDE and 0 <= box[0] < width and 0 <= box[1] < height


def without(clip, first, frame, box):
    """The sample of a box that does not show the target."""
    return crops.crop(clip.frames[first], clip.truth[first]), crops.crop(frame, box), np.zeros(4, np.float32)


def beside(rng, clips):
    clip = any_clip(rng, clips)
    first, present = frames(rng, clip)
    frame, truth = clip.frames[present], clip.truth[present]
    for _ in range(TRIES):
        if rng.random() < ANYWHERE_SHARE:
            centre = rng.random(2) * frame.shape[::-1]
        else:
            centre = truth[:2] + rng.normal(0, BESIDE_DEVIATION, 2) * truth[2:]
        box = offsets.drawn(rng, np.concatenate([centre, truth[2:]]))
        if usable(frame, box) and boxes.intersection_over_union(box, truth) < MAX_OVERLAP:
            return [without(clip, first, frame, box)]
    return []


def resembling(rng, clips):
    clip = any_clip(rng, clips)
    first, present = frames(rng, clip)
    template_of = first if rng.random() < FIRST_SHARE else present
    frame, truth = clip.frames[present], clip.truth[present]
    group = []
    for centre in peaks(np.asarray(frame), truth, inside(clip.frames[template_of], clip.truth[template_of])):
        box = offsets.drawn(rng, np.concatenate([centre, truth[2:]]), AROUND_PLACE)
        if usable(frame, box) and boxes.intersection_over_union(box, truth) < MAX_OVERLAP:
            group.append(without(clip, first, frame, box))
        if len(group) == MAX_PLACES:
            break
    return group


def inside(frame, box):
    """The frame's pixels inside the box."""
    low = np.maximum(box[:2] - box[2:] / 2, 0).astype(int)
    high = np.minimum(box[:2] + box[2:] / 2, frame.shape[::-1]).astype(int)
    return np.asarray(frame[low[1] : high[1], low[0] : high[0]])


def peaks(frame, truth, template):
    """The centres of places around the target that correlate with the template, the best one first."""
    reach = np.maximum(truth[2:] * RADIUS, MIN_RADIUS)
    low = np.maximum(truth[:2] - reach, 0).astype(int)
    high = np.minimum(truth[:2] + reach, frame.shape[::-1]).astype(int)
    region = frame[low[1] : high[1], low[0] : high[0]]
    factor = max(1.0, boxes.side(truth) / TEMPLATE_SIDE)
    across, down = (max(3, round(side / factor)) for side in truth[2:])
    if min(template.shape) < 4 or min(region.shape) < 16:
        return
    region = cv2.resize(region, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)
    if region.shape[0] <= down + 2 or region.shape[1] <= across + 2:
        return
    template = cv2.resize(template, (across, down), interpolation=cv2.INTER_AREA)
    values = cv2.matchTemplate(region, template, cv2.TM_CCOEFF_NORMED)
    values[~np.isfinite(values)] = -1
    for _ in range(MAX_PEAKS):
        y, x = np.unravel_index(values.argmax(), values.shape)
        if values[y, x] <= MIN_CORRELATION:
            return
        yield low + np.array([x + across / 2, y + down / 2]) * factor
        values[max(0, y - down // 2) : y + down // 2 + 1, max(0, x - across // 2) : x + across // 2 + 1] = -1


def elsewhere(rng, clips):
    clip, other = any_clip(rng, clips), any_clip(rng, clips)
    if other is clip:
        return []
    first, _ = frames(rng, clip)
    _, present = frames(rng, other)
    frame, box = other.frames[present], offsets.drawn(rng, other.truth[present])
    if rng.random() < RANDOM_PLACE_SHARE:
        box = np.concatenate([rng.random(2) * frame.shape[::-1], box[2:]])
    return [without(clip, first, frame, box)] if usable(frame, box) else []


def mistaken(rng, clips):
    clip = any_clip(rng, clips)
    if not clip.mistaken:
        return []
    present, answer = clip.mistaken[int(rng.integers(len(clip.mistaken)))]
    first, _ = frames(rng, clip)
    truth, box = clip.truth[present], offsets.drawn(rng, answer, AROUND_MISTAKE)
    shows = truth is not None and boxes.intersection_over_union(box, truth) >= MAX_OVERLAP
    return [without(clip, first, clip.frames[present], box)] if not shows and usable(clip.frames[present], box) else []


def other_piece(rng, clips):
    clip, piece = cutouts.textured_piece(rng, clips)
    behind = any_clip(rng, clips) if rng.random() < OTHER_CLIP_SHARE else clip
    present = cutouts.background(rng, behind, piece)
    if rng.random() >= WITHOUT_PIECE_SHARE:
        _, other = cutouts.textured_piece(rng, [clip])
        if other.frame.shape == piece.frame.shape and boxes.intersection_over_union(other.box, piece.box) > MAX_OVERLAP:
            return []
        other = cutouts.Piece(other.frame, np.concatenate([other.box[:2], piece.box[2:]]), piece.mask)
        present = cutouts.pasted(other, offsets.drawn(rng, cutouts.UNIT), rng.normal(0, cutouts.TURN), present)
    first = crops.crop(piece.frame, piece.box).astype(np.float32)
    return [(cutouts.noisy(rng, first), cutouts.noisy(rng, present), np.zeros(4, np.float32))]


def disturbed(rng, clips):
    clip = any_clip(rng, clips)
    first, present = frames(rng, clip)
    frame, truth = clip.frames[present], clip.truth[present]
    box = offsets.drawn(rng, truth)
    change = boxes.correction(box, truth)
    if abs(change).max() > pairs.LARGEST_CORRECTION or not usable(frame, box):
        return []
    turn = rng.normal(0, TURN) if rng.random() < TURNED_SHARE else 0.0
    present = crops.read(frame, disturbances.turned(crops.to_frame(box), turn))
    return [(crops.crop(clip.frames[first], clip.truth[first]), disturbances.drawn(rng, present, clips), change)]


def disturbed_cutout(rng, clips):
    first, present, change = cutouts.drawn(rng, clips)
    return [(first, disturbances.drawn(rng, present, clips), change)]


DRAW = {
    Kind.BESIDE: beside,
    Kind.RESEMBLING: resembling,
    Kind.ELSEWHERE: elsewhere,
    Kind.MISTAKEN: mistaken,
    Kind.OTHER_PIECE: other_piece,
    Kind.DISTURBED: disturbed,
    Kind.DISTURBED_CUTOUT: disturbed_cutout,
}
