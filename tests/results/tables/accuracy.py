"""Accuracy on recordings with ground truth."""

import hashlib
import shutil

from .programs import Skipped
from .returns import make_returns
from .statistics import Recordings, percent
from .table import Table

SETS = {"tld": "TLD", "more": "eleven of OTB, VOT, UAV123", "many": "73 others"}
ROBUST = ["--method", "robust", "--set", "refiner=off"]
TLD = ["01_david", "02_jumping", "03_pedestrian1", "04_pedestrian2", "05_pedestrian3", "06_car"]


def starts(programs, *options, half=None, paths=None, shown=None):
    """Runs `eval --robustness` on the 90 recordings or on `paths`."""
    paths = programs.recordings(*SETS) if paths is None else paths
    rows = programs.eval("--robustness", *options, *paths, half=half, shown=shown)["measured"]
    return Recordings(rows)


def other_half_of(programs, half):
    """The recordings that were not in a half's training, as paths for host-sim."""
    paths = []
    for folder in programs.recordings(*SETS):
        for path in sorted((programs.sequences / folder.split("/")[1]).iterdir()):
            is_b = hashlib.md5(path.name.encode()).digest()[0] & 1
            if (path / "gt.txt").exists() and "ab"[is_b] != half:
                paths.append(f"{folder}/{path.name}")
    return paths


def by_set(tracker):
    """For each set of recordings its name and figures, then those of all."""
    return [*((name, tracker.of(folder)) for folder, name in SETS.items()), ("all", tracker)]


def count_frames(programs):
    """Correct frames of the paper's six recordings, of every tracker."""
    paths = programs.recordings("tld")
    counts = {}

    def add(rows, name=None):
        for row in rows:
            counts.setdefault(name or row["tracker"], {})[row["sequence"]] = row["correct"]

    every = programs.eval(*paths)
    add(every["printed"])
    add(every["measured"])
    add(programs.eval("--method", "paper", "--config", "camera", *paths)["measured"], "camera")
    add(programs.eval(*ROBUST, *paths)["measured"], "robust without refiner")
    labels = {
        "SMR, the paper": "printed in the paper",
        "paper": "**smr, `Config::paper()`, k = 1/4**",
        "paper, k = 7/20, inclusive": "**smr, `Config::paper()`, `--set k=7/20 --inclusive`**",
        "camera": "smr, `Config::camera()`",
        "robust": "smr, robust (trained on these recordings)",
        "robust without refiner": "smr, robust, `--set refiner=off` (tuned on these recordings)",
        "sad": "SAD, same window and update",
        "ssd": "SSD, same window and update",
        "ncc": "NCC, same window and update",
        "lk": "Lucas-Kanade, same window and update",
    }
    labels |= {f"OpenCV-5.0.0-{name}": f"OpenCV 5.0.0 {name}" for name in ("TLD", "MedianFlow", "KCF", "CSRT", "MIL")}
    rows = {key: [label, *(str(counts[key].get(name, "")) for name in TLD)] for key, label in labels.items()}
    short = {key: rows[key] for key in ("paper", "paper, k = 7/20, inclusive", "SMR, the paper", "robust")}
    return {}, {"all": list(rows.values()), "short": list(short.values())}


def compare_presets(programs):
    """The paper tracker with its two presets."""
    paper = starts(programs, "--method", "paper", "--config", "paper")
    camera = starts(programs, "--method", "paper", "--config", "camera")
    rows = [
        [name, str(len(own)), own.mean("mean_correct"), other.mean("mean_correct"), other.against(own, "mean_correct")]
        for (name, own), (_, other) in zip(by_set(paper), by_set(camera))
    ]
    return {}, {"all": rows}


def summary(name, own):
    said = [own.with_error("mean_correct"), own.mean("mean_correct_50"), own.with_error("f"), own.mean("mean_iou")]
    return [name, str(len(own)), *said, own.share("tracking_wrong", "wrong"), own.share("right_unsaid", "right")]


def without_refiner(programs):
    """The robust tracker without its network, in both sizes."""
    standard = starts(programs, *ROBUST)
    small = starts(programs, *ROBUST, "--config", "small")
    figures = {
        "correct": standard.mean("mean_correct"),
        "at-0.5": standard.mean("mean_correct_50"),
        "small": small.mean("mean_correct"),
        "small-difference": small.against(standard, "mean_correct"),
        "small-difference-at-0.5": small.against(standard, "mean_correct_50"),
        "wrong-tracking": standard.share("tracking_wrong", "wrong"),
        "right-unsaid": standard.share("right_unsaid", "right"),
    }
    return figures, {"all": [summary(name, own) for name, own in by_set(standard)]}


def across_halves(programs, *options, shown):
    """Each half of the recordings, measured with weights that were trained on the other half."""
    halves = [starts(programs, *options, half=half, paths=other_half_of(programs, half), shown=shown) for half in "ab"]
    return halves[0] + halves[1]


def cross_trained(programs):
    """The robust tracker with its network, on recordings that the network was not trained on."""
    shown = "host-sim eval --robustness --method robust HALF  # built with weights of the other half"
    refined = across_halves(programs, "--method", "robust", shown=shown)
    plain = starts(programs, *ROBUST)
    gain = [refined.against(plain, name) for name in ("mean_correct", "mean_correct_50", "f", "mean_iou")]
    rows = [summary(name, own) for name, own in by_set(refined)]
    rows.append(["all: difference to the tracker without refiner, paired", str(len(plain)), *gain, "", ""])
    short = {"paper": "`Paper`", "refined": "**`Robust`**, the refiner trained on other recordings", "plain": "`Robust` without refiner"}
    paper = starts(programs, "--method", "paper", "--config", "paper")
    trackers = {"refined": refined, "plain": plain, "paper": paper}
    both = [[label, *(own.mean("mean_correct") for _, own in by_set(trackers[key]))] for key, label in short.items()]
    figures = {
        "correct": refined.mean("mean_correct"),
        "at-0.5": refined.mean("mean_correct_50"),
        "wrong-tracking": refined.share("tracking_wrong", "wrong"),
        "right-unsaid": refined.share("right_unsaid", "right"),
    }
    return figures, {"all": rows, "short": sorted(both, key=lambda row: "**" not in row[0])}


def returning(programs):
    """Targets that leave twice and come back elsewhere, with weights of the other half."""
    folder = programs.folder / "returns"
    shown = "host-sim eval --robustness --starts 1 --method robust RETURNS  # tests/results/tables/returns.py makes them"
    trackers = {"with the refiner": [], "without": []}
    for half in "ab":
        for made in make_returns(programs, other_half_of(programs, half), folder):
            for name, options in {"with the refiner": [], "without": ["--set", "refiner=off"]}.items():
                own = starts(programs, "--starts", "1", "--method", "robust", *options, half=half, paths=made, shown=shown)
                trackers[name].append(own)
    shutil.rmtree(folder, ignore_errors=True)
    rows, figures = [], {}
    for name, parts in trackers.items():
        own = sum(parts[1:], parts[0])
        found = f"{own.sum('found_again')} of {own.sum('returns')}"
        gone = own.share("answered_hidden", "hidden")
        rows.append([name, own.with_error("mean_correct"), own.with_error("f"), gone, found])
        if name == "with the refiner":
            figures = {"gone": gone, "found": found, "found-share": percent(own.sum("found_again"), own.sum("returns"))}
    return figures, {"all": rows}


def parts(programs):
    """The tracker without single parts."""
    options = {
        "**robust**": [],
        "without size": ["--set", "size=off"],
        "without sweep": ["--set", "sweep=0"],
        "without refiner": ["--set", "refiner=off"],
    }
    rows, figures = [], {}
    for name, changed in options.items():
        own = starts(programs, "--starts", "1", "--method", "robust", *changed)
        sets = [of.mean("mean_correct") for _, of in by_set(own)[:-1]]
        wrong = percent(own.sum("tracking_wrong"), own.sum("tracking"))
        rows.append([name, own.with_error("mean_correct"), *sets, wrong, own.share("tracking_wrong", "wrong"), own.share("right_unsaid", "right")])
        if not changed:
            tld = own.of("tld")
            figures = {
                "tld-wrong": f"{tld.sum('wrong'):,}",
                "tld-wrong-said": f"{tld.sum('wrong') - tld.sum('tracking_wrong'):,}",
                "tld-right": f"{tld.sum('right'):,}",
                "tld-right-unsaid": f"{tld.sum('right_unsaid'):,}",
            }
    return figures, {"all": rows}


def frame_rates(programs):
    """Every N-th frame only."""
    rates = [starts(programs, "--starts", "1", *(["--every", str(every)] if every > 1 else []), *ROBUST) for every in (1, 2, 3, 6)]
    return {}, {"all": [[f"{own.mean('mean_correct')} ({own.mean('mean_correct_50')})" for own in rates]]}


def peers(programs):
    """Other trackers, scored by their boxes beside the recordings."""
    sets = {folder: programs.eval("--compare", "--method", "paper,robust", *programs.recordings(folder)) for folder in ("tld", "many")}
    plain = {folder: programs.eval(*ROBUST, *programs.recordings(folder)) for folder in ("tld", "many")}
    recall = {}
    for folder, said in sets.items():
        for row in said["measured"]:
            recall.setdefault(row["tracker"], {}).setdefault(folder, {})[row["sequence"]] = row["recall"]
        for row in plain[folder]["measured"]:
            recall.setdefault("robust without refiner", {}).setdefault(folder, {})[row["sequence"]] = row["recall"]
    names = {name.lower(): name for name in recall}
    network = next(name for lower, name in names.items() if "nano" in lower)
    common = set(recall[network]["many"])
    if not common:
        raise Skipped("no boxes of NanoTrack beside the recordings")
    shown = {network: "NanoTrack v2 (a network of 1.7 MB)", "robust without refiner": "smr, robust without refiner (tuned on these recordings)", "paper": "smr, paper"}
    shown |= {f"OpenCV-5.0.0-{name}": f"OpenCV {name}" for name in ("CSRT", "KCF", "MIL", "MedianFlow")}
    rows, figures = [], {"recordings": str(len(common))}
    for name, label in shown.items():
        cells, own = [], recall.get(name, {})
        for folder in sets:
            values = [value for key, value in own.get(folder, {}).items() if folder == "tld" or key in common]
            full = len(common) if folder == "many" else len(TLD)
            cells.append(f"{sum(values) / len(values):.3f}" + (f" ({len(values)})" if len(values) < full else "") if values else "")
        rows.append([label, *cells])
        if cells[1]:
            figures["NanoTrack" if name == network else name.removeprefix("OpenCV-5.0.0-")] = cells[1].split(" ")[0]
    return figures, {"all": rows}


TABLES = [
    Table("paper-table", "correct frames of the paper's six recordings", ("paper", "robust"), count_frames),
    Table("presets", "the paper tracker with its two presets", ("paper",), compare_presets),
    Table("robust", "the robust tracker without refiner, five starts", ("robust",), without_refiner),
    Table("cross-trained", "the refiner on recordings that it was not trained on, five starts", ("paper", "robust"), cross_trained),
    Table("returns", "targets that leave and come back", ("robust",), returning),
    Table("parts", "the robust tracker without single parts", ("robust",), parts),
    Table("frame-rates", "every second, third, sixth frame only", ("robust",), frame_rates),
    Table("peers", "other trackers on the same recordings", ("paper", "robust"), peers),
]
