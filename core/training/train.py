"""Makes the weights of the refiner from recordings.

    python core/training/train.py ../shared/sequences/{tld,more,many} --half all --out weights.bin

Writes the weights, and beside them a recipe (`weights.json`); prints the errors of boxes before and after correction.
"""

import argparse
import os
import shlex
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from refiner_training import recipe, recordings, report, samples, weights
from refiner_training.clips import Source
from refiner_training.errors import BadInput
from refiner_training.progress import Progress
from refiner_training.tracked import HostSim

TARGET = Path(__file__).resolve().parents[2] / "target"
OTHER = {"a": "b", "b": "a"}
# Numbers of samples for the report. They are drawn with another seed than the samples for training.
REPORT_COUNTS = {"pairs": 4000, "cutouts": 2000, "others": 6000}


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise BadInput(message)


def options():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", metavar="FOLDER", help="a recording (a video and gt.txt), or a folder of recordings")
    parser.add_argument("--half", choices=["all", "a", "b"], default="all", help="the recordings to train on, by a hash of their names [all]")
    parser.add_argument("--list-half", choices=["a", "b"], help="print the folders of this half and stop")
    parser.add_argument("--out", type=Path, metavar="FILE", help="the weights; the recipe goes beside them, with the ending .json")
    parser.add_argument("--host-sim", default=str(TARGET / "release" / "host-sim"), metavar="FILE", help="[target/release/host-sim]")
    parser.add_argument("--cache", type=Path, default=TARGET / "training", metavar="DIR", help="frames and tracker's boxes [target/training]")
    parser.add_argument("--pairs", type=count, default=350_000, metavar="N", help="samples from pairs of frames [350000]")
    parser.add_argument("--cutouts", type=count, default=190_000, metavar="N", help="samples that are made [190000]")
    parser.add_argument("--others", type=count, default=270_000, metavar="N", help="samples of other things, and of the disturbed target [270000]")
    parser.add_argument("--steps", type=count, default=10_000, metavar="N", help="steps of 256 samples [10000]")
    parser.add_argument("--seed", type=count, default=1, metavar="N", help="[1]")
    parser.add_argument("--processes", type=count, default=len(os.sched_getaffinity(0)), metavar="N", help="for samples [one a core]")
    chosen = parser.parse_args()
    if not chosen.out and not chosen.list_half:
        parser.error("--out FILE is missing")
    return chosen


def count(word):
    if not word.isdecimal() or int(word) < 1:
        raise argparse.ArgumentTypeError(f"{word}: expected a whole number, 1 or more")
    return int(word)


def main():
    try:
        chosen = options()
        found = recordings.find(chosen.folders)
        if chosen.list_half:
            print(*(recording.folder for recording in found if recording.half == chosen.list_half), sep="\n")
        else:
            print(run(chosen, found))
    except BadInput as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)


def run(chosen, found):
    """Trains on recordings, and writes the weights and the recipe. Returns the report."""
    if not chosen.out.resolve().parent.is_dir():
        raise BadInput(f"no folder {chosen.out.parent}")
    host_sim = HostSim(chosen.host_sim)
    sources, tracked = prepared(found, host_sim, chosen)
    train_on, judge_on = halves(found, sources, chosen.half)
    chosen.cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=chosen.cache) as drawn:
        parameters = trained(chosen, train_on, drawn)
        results = judged(chosen, judge_on, parameters, drawn)
    data = weights.packed(parameters)
    content = recipe.recipe(shlex.join(["python", *sys.argv]), settings(chosen), host_sim, found, tracked, data, results)
    chosen.out.write_bytes(data)
    chosen.out.with_suffix(".json").write_text(recipe.text(content))
    return report.table(results)


def settings(chosen):
    return {name: getattr(chosen, name) for name in ("half", "seed", "pairs", "cutouts", "others", "steps")}


def prepared(found, host_sim, chosen):
    """Fills the cache with frames and tracker's boxes. Returns the sources of clips, and the files of the boxes."""
    with ThreadPoolExecutor(chosen.processes) as pool, Progress("recordings", len(found)) as progress:

        def both(recording):
            files = recordings.cached_frames(recording, chosen.cache), host_sim.tracked(recording, chosen.cache)
            progress.advance(note=recording.name)
            return files

        files = list(pool.map(both, found))
    sources = [Source(recording.truth, *paths, recording.reduction()) for recording, paths in zip(found, files)]
    return sources, [tracked for _, tracked in files]


def halves(found, sources, half):
    """Splits the sources: to train on, and to judge on."""
    by_half = {name: [source for recording, source in zip(found, sources) if recording.half == name] for name in "ab"}
    by_half["all"] = sources
    train_on, judge_on = by_half[half], by_half[OTHER.get(half, "all")]
    if not train_on or not judge_on:
        raise BadInput(f"half {'b' if by_half['a'] else 'a'} has no recordings: expected some in both, or --half all")
    return train_on, judge_on


def trained(chosen, sources, folder):
    """Draws samples and trains on them; returns the integers of the weights."""
    # Imported here, because JAX takes a second to load, and neither the processes that draw samples nor the checks of the input need JAX.
    from refiner_training import fit, network

    counts = {source: getattr(chosen, source) for source in samples.SOURCES}
    drawn = samples.draw(sources, counts, chosen.seed, folder, chosen.processes)
    return network.whole(fit.fit(drawn, chosen.steps, chosen.seed))


def judged(chosen, sources, parameters, folder):
    """The report: the samples that it is on, and the errors by kind of sample."""
    drawn = samples.draw(sources, REPORT_COUNTS, chosen.seed + 1_000_000, folder, chosen.processes)
    if chosen.half == "all":
        on = "held-out samples of the recordings trained on: unseen recordings do worse (see --half a)"
    else:
        on = f"half {OTHER[chosen.half]}, whose recordings were not trained on"
    return {"on": on, "kinds": report.measured(parameters, drawn), "match": report.matched(parameters, drawn)}


if __name__ == "__main__":
    main()
