"""Milliseconds of processor time of an update of smr's trackers and of OpenCV's, in frames of recordings: the second half of `run`."""

import statistics
import time

import cv2
import smr

SIDE = 64
WINDOWS = {"+-16": (16, 16), "+-60x50": (60, 50)}
# About this many updates are timed, each up to REPEATS times until ENOUGH seconds are spent; the shortest time counts.
UPDATES, REPEATS, ENOUGH = 60, 15, 0.01
# Pixels by which the target may move in the second frame before its window is cut, where there is room for it.
SPARE = 8
# At most this part of OpenCV's time.
GOALS = [
    ("smr.Paper, +-16", "matchTemplate, +-16", 1 / 10),
    ("smr.Paper, +-60x50", "matchTemplate, +-60x50", 1 / 3),
    ("smr.Robust", "CSRT", 1 / 50),
]


def cases(paths):
    """Three frames in a row, and the box in the first: about UPDATES of them in all."""
    recordings = [smr.Recording(path) for path in paths]
    if hidden := [recording.name for recording in recordings if recording.truth is None]:
        raise ValueError(f"{hidden[0]}: no ground truth beside it")
    every = max(1, sum(len(recording.truth) for recording in recordings) // UPDATES)
    for recording in recordings:
        last = []
        for number, frame in enumerate(recording):
            last = [*last[-2:], frame]
            first = number - 2
            if first >= 0 and first % every == 0 and recording.truth[first] is not None:
                yield last, recording.truth[first]


def boxed(frame, box, reach):
    """A box of 64x64 as close to the middle of `box` as leaves its window inside the frame; None if there is no room."""
    place = []
    for at, side, radius, size in zip(box, box[2:], reach, frame.shape[1::-1]):
        room = size - SIDE - 2 * radius
        if room < 0:
            return None
        spare = min(SPARE, room // 2)
        place.append(min(max(round(at + side / 2 - SIDE / 2), radius + spare), size - SIDE - radius - spare))
    return (*place, SIDE, SIDE)


def shortest(prepare):
    """Seconds of what `prepare` gives: what is timed begins anew each time."""
    times = []
    while len(times) < REPEATS and sum(times) < ENOUGH:
        work = prepare()
        before = time.process_time()
        work()
        times.append(time.process_time() - before)
    return min(times)


def following(make, frames, box):
    def prepare():
        tracker = make()
        tracker.init(frames[0], box)
        tracker.update(frames[1])
        return lambda: tracker.update(frames[2])

    return shortest(prepare)


def add_searches(times, frames, truth):
    for name, reach in WINDOWS.items():
        if (box := boxed(frames[0], truth, reach)) is None:
            continue
        paper = smr.Paper("paper", window=reach, window_limit=reach)
        paper.init(frames[0], box)
        _, (x, y, *_) = paper.update(frames[1])
        left, top, width, height = paper.window()
        if (width, height) != (SIDE + 2 * reach[0], SIDE + 2 * reach[1]):
            continue
        crop, template = frames[2][top : top + height, left : left + width].copy(), frames[1][y : y + SIDE, x : x + SIDE].copy()
        search = lambda crop=crop, template=template: cv2.minMaxLoc(cv2.matchTemplate(crop, template, cv2.TM_CCOEFF_NORMED))
        make = lambda reach=reach: smr.Paper("paper", window=reach, window_limit=reach)
        times.setdefault(f"smr.Paper, {name}", []).append(following(make, frames, box))
        times.setdefault(f"matchTemplate, {name}", []).append(shortest(lambda: search))


def measure(paths):
    """Seconds of each update by the name of the tracker."""
    cv2.setNumThreads(1)
    times = {}
    for frames, truth in cases(paths):
        add_searches(times, frames, truth)
        if (box := boxed(frames[0], truth, WINDOWS["+-16"])) is None:
            continue
        colored = [cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR) for frame in frames]
        for name, make, shown in [
            ("smr.Robust('robust')", lambda: smr.Robust("robust"), frames),
            ("smr.Robust", smr.Robust, frames),
            ("KCF", cv2.TrackerKCF_create, colored),
            ("CSRT", cv2.TrackerCSRT_create, colored),
        ]:
            times.setdefault(name, []).append(following(make, shown, box))
    return times


def table(times):
    lines = ["| an update | median ms | updates |", "|---|---:|---:|"]
    medians = {name: statistics.median(own) for name, own in times.items()}
    lines += [f"| {name} | {1000 * medians[name]:.3f} | {len(own)} |" for name, own in times.items()]
    for name, other, most in GOALS:
        if name in times and other in times:
            part = medians[name] / medians[other]
            lines.append(f"{name} / {other}: {part:.4f}, goal at most {most:.4f}: {'within' if part <= most else 'beyond'}")
    return "\n".join(lines)
