"""Times updates of smr's trackers and of OpenCV's on recordings, in milliseconds of processor time. Called by `run`."""

import statistics
import time

import cv2
import smr

SIDE = 64
WINDOWS = {"+-16": (16, 16), "+-60x50": (60, 50)}
# Approximate number of updates to time; largest number of runs of each update; total seconds of these runs, after which no further one starts.
UPDATES, REPEATS, ENOUGH = 60, 15, 0.01
# Largest shift of the target in the second frame in pixels; smaller near the frame's edge.
SPARE = 8
# Name of smr's tracker, name of OpenCV's counterpart, and the largest allowed ratio of their median times (smr/OpenCV).
GOALS = [
    ("smr.Paper, +-16", "matchTemplate, +-16", 1 / 10),
    ("smr.Paper, +-60x50", "matchTemplate, +-60x50", 1 / 3),
    ("smr.Robust", "CSRT", 1 / 50),
]


def cases(paths):
    """Yields three successive frames and the true box in the first, at most about UPDATES times."""
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
    """The box of 64x64 pixels nearest to `box` whose window is inside the frame; None if the frame is too small."""
    place = []
    for at, side, radius, size in zip(box, box[2:], reach, frame.shape[1::-1]):
        room = size - SIDE - 2 * radius
        if room < 0:
            return None
        spare = min(SPARE, room // 2)
        place.append(min(max(round(at + side / 2 - SIDE / 2), radius + spare), size - SIDE - radius - spare))
    return (*place, SIDE, SIDE)


def shortest(prepare):
    """Shortest time in seconds of the function that `prepare` returns; each repetition prepares a new one."""
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
    """{name of the tracker: seconds of each update}."""
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
