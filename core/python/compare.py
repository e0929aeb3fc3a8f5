"""The table of the README: the trackers of smr beside those of OpenCV, on recordings with ground truth.

    python compare.py FOLDER... [--json FILE] [--models DIR] [--every MIL=2]

Every tracker starts once, in the first box of each recording, and follows it to the end on one thread. OpenCV's trackers get the same gray
frames, as BGR. Needs `opencv-contrib-python-headless`, and for Vit and Nano their model files.
"""

import argparse
import glob
import json
import math
import os
import statistics
import sys
import time

import cv2
import smr

# For each network of OpenCV: the parameters that take its files, with patterns for the files' names in `--models`.
NETWORKS = {
    "Vit": {"net": "*vit*.onnx"},
    "Nano": {"backbone": "*nano*backbone*.onnx", "neckhead": "*nano*head*.onnx"},
}


class OfSmr:
    """A tracker of smr with OpenCV's interface. It returns the box in fractions of a pixel; None if lost, as in `host-sim eval`."""

    def __init__(self, tracker):
        self.tracker, self.init = tracker, tracker.init

    def update(self, frame):
        answer = self.tracker.follow(frame)
        return None if answer.state == smr.State.LOST else answer.fine_box


class OfOpenCV:
    """A tracker of OpenCV. It returns the box, or None if it has failed."""

    def __init__(self, tracker):
        self.tracker, self.init = tracker, tracker.init

    def update(self, frame):
        try:
            ok, box = self.tracker.update(frame)
        except cv2.error:
            # Some of OpenCV's trackers throw when their box leaves the frame.
            return None
        return box if ok else None


def networks(folder):
    """Constructors of Vit and Nano by name, and the reasons why a network is skipped."""
    makers, skipped = {}, []
    for name, patterns in NETWORKS.items():
        found = {parameter: glob.glob(os.path.join(folder or "", pattern)) for parameter, pattern in patterns.items()}
        missing = [patterns[parameter] for parameter, files in found.items() if not files]
        if folder is None or missing:
            where = f"in {folder}" if folder else "(--models DIR)"
            skipped.append(f"{name}: no model file {', '.join(missing if folder else patterns.values())} {where}")
            continue
        parameters = getattr(cv2, f"Tracker{name}_Params")()
        for parameter, files in found.items():
            setattr(parameters, parameter, min(files))
        create = getattr(cv2, f"Tracker{name}_create")
        try:
            create(parameters)
        except cv2.error:
            raise ValueError(f"{name}: OpenCV cannot read {', '.join(map(min, found.values()))}") from None
        makers[name] = lambda create=create, parameters=parameters: OfOpenCV(create(parameters))
    return makers, skipped


def trackers(models):
    """Constructors of trackers by name, and the reasons why a tracker is skipped."""
    makers = {
        "smr.Robust": lambda: OfSmr(smr.Robust()),
        # Measures the robust tracker also without the refiner, whose network may be trained on these recordings.
        "smr.Robust(robust)": lambda: OfSmr(smr.Robust("robust")),
        "smr.Paper": lambda: OfSmr(smr.Paper()),
    }
    for name in ("CSRT", "KCF", "MIL"):
        create = getattr(cv2, f"Tracker{name}_create")
        makers[name] = lambda create=create: OfOpenCV(create())
    others, skipped = networks(models)
    return makers | others, skipped


def run(tracker, frames, start):
    """A box or None for each frame (always None if the tracker refuses the start), and the mean milliseconds of an update.

    Milliseconds of processor time, summed over threads: other programs hardly change it, and more threads do not reduce it.
    """
    shown = (lambda gray: gray) if isinstance(tracker, OfSmr) else (lambda gray: cv2.cvtColor(gray, cv2.COLOR_GRAY2BGR))
    try:
        tracker.init(shown(frames[0]), start)
    except (ValueError, cv2.error):
        return [None] * len(frames), 0.0
    boxes, spent = [start], 0.0
    for frame in map(shown, frames[1:]):
        before = time.process_time()
        box = tracker.update(frame)
        spent += time.process_time() - before
        boxes.append(box)
    return boxes, 1000 * spent / max(1, len(frames) - 1)


def measure(path, makers):
    """One row for each tracker, with the keys of `host-sim eval --json`."""
    recording = smr.Recording(path)
    if recording.truth is None or recording.start is None:
        raise ValueError(f"{path}: no ground truth beside it")
    frames = list(recording)
    # Rounds the start box, as OpenCV requires and as smr does itself. The score shifts and scales all boxes until the
    # first equals the ground truth, so the first must be the box that the tracker was given.
    start = tuple(math.floor(side + 0.5) for side in recording.start)
    for name, make in makers.items():
        boxes, milliseconds = run(make(), frames, start)
        score = recording.score(boxes)
        started = boxes[0] is not None
        yield {"tracker": name, "sequence": recording.name, "started": started, "milliseconds": milliseconds, **score}


def mean(values):
    """The mean and its standard error; None for the error of a single value."""
    return statistics.fmean(values), statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else None


def means(rows):
    """Averages each tracker over its recordings. `behind`: the recall of smr.Robust on the same recordings, minus the tracker's."""
    robust = {row["sequence"]: row["recall"] for row in rows if row["tracker"] == "smr.Robust"}
    table = []
    for name in dict.fromkeys(row["tracker"] for row in rows):
        own = [row for row in rows if row["tracker"] == name]
        line = {"tracker": name, "sequences": len(own), "refused": sum(not row["started"] for row in own)}
        for key, values in {
            "recall": [row["recall"] for row in own],
            "f": [row["f"] for row in own],
            "behind": [robust[row["sequence"]] - row["recall"] for row in own],
        }.items():
            line[key], line[f"{key}_standard_error"] = mean(values)
        times = [row["milliseconds"] for row in own if row["started"]]
        line["milliseconds"] = statistics.median(times) if times else None
        table.append(line)
    return table


def with_error(row, key):
    error = row[f"{key}_standard_error"]
    return f"{row[key]:.3f}" + (f" ± {error:.3f}" if error is not None else "")


def markdown(table, skipped):
    lines = ["| tracker | accuracy | behind smr.Robust | F | ms a frame | recordings |", "|---|---|---|---|---|---|"]
    for row in table:
        behind = "" if row["tracker"] == "smr.Robust" else with_error(row, "behind")
        # Three significant digits, because the times differ by a factor of 100.
        speed = "" if row["milliseconds"] is None else f"{row['milliseconds']:#.3g}".rstrip(".")
        figures = [with_error(row, "recall"), behind, with_error(row, "f"), speed, str(row["sequences"])]
        lines.append(f"| {row['tracker']} | {' | '.join(figures)} |")
    most = max(row["sequences"] for row in table)
    notes = [f"{row['tracker']}: measured on {row['sequences']} of the {most} recordings" for row in table if row["sequences"] < most]
    notes += [f"{row['tracker']}: refused the box of {row['refused']} recordings (accuracy 0)" for row in table if row["refused"]]
    return "\n".join([*lines, "", *notes, *(f"skipped: {reason}" for reason in skipped)])


def every(text):
    """Parses `MIL=2` to ("MIL", 2)."""
    name, _, step = text.partition("=")
    if not step.isdecimal() or int(step) < 1:
        raise argparse.ArgumentTypeError(f"expected TRACKER=N with N of 1 or more, found {text}")
    return name, int(step)


def arguments():
    parser = argparse.ArgumentParser(description="Compares smr with OpenCV's trackers on recordings with ground truth.")
    parser.add_argument("paths", nargs="+", metavar="FOLDER", help="a recording, or a folder of recordings")
    parser.add_argument("--json", metavar="FILE", help="write all figures of all recordings to FILE")
    parser.add_argument("--models", metavar="DIR", help="a folder with the model files of Vit and Nano")
    parser.add_argument("--every", metavar="TRACKER=N", type=every, action="append", default=[], help="measure TRACKER on every N-th recording only")
    return parser.parse_args()


def progress(done, count, name):
    if sys.stderr.isatty():
        print(f"\r{done}/{count} {name}\033[K", end="" if done < count else "\n", file=sys.stderr, flush=True)


def main():
    options = arguments()
    cv2.setNumThreads(1)
    makers, skipped = trackers(options.models)
    steps = dict(options.every)
    if unknown := steps.keys() - makers.keys():
        raise ValueError(f"--every: no tracker {min(unknown)}: expected {', '.join(makers)}")
    paths, rows, failures = smr.recordings(options.paths), [], []
    for number, path in enumerate(paths):
        progress(number, len(paths), path)
        try:
            rows += list(measure(path, {name: make for name, make in makers.items() if number % steps.get(name, 1) == 0}))
        except (ValueError, OSError) as error:
            failures.append(str(error))
    progress(len(paths), len(paths), "recordings")
    if not rows:
        raise ValueError("; ".join(failures))
    table, skipped = means(rows), skipped + failures
    print(markdown(table, skipped))
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"opencv": cv2.__version__, "measured": rows, "means": table, "skipped": skipped}, file, indent=1)


if __name__ == "__main__":
    try:
        main()
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
