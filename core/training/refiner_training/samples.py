"""Draws samples on all cores. Each chunk has its own seed, so the samples do not depend on the number of cores."""

import itertools
import multiprocessing
from dataclasses import dataclass

import cv2
import numpy as np

from . import clips, crops, cutouts, disturbances, others, pairs
from .errors import BadInput
from .kinds import CORRECTED, Kind
from .progress import Progress

CHUNK = 2500
# Share of samples whose present crop is in poor light.
DIMMED_SHARE = 0.3


@dataclass(frozen=True)
class Samples:
    inputs: np.ndarray  # (samples, 32, 32, 2) of u8, normalised: the first crop, the present one
    corrections: np.ndarray  # (samples, 4)
    kinds: np.ndarray  # (samples,)

    def __len__(self):
        return len(self.inputs)

    @property
    def corrected(self):
        """Number of samples with a correction to learn; they come first."""
        return int(np.isin(self.kinds, CORRECTED).sum())


@dataclass(frozen=True)
class Chunk:
    folder: str
    seed: tuple
    source: str  # a key of SOURCES
    start: int
    count: int


def draw(sources, counts, seed, folder, processes):
    """Draws samples into files in `folder`: as many of each source as `counts` says, in the order of SOURCES."""
    # Checks the recordings before processes start, because a pool whose processes fail at their start never ends.
    if not clips.read(sources):
        raise BadInput("no recording shows its target in two frames")
    samples = opened(folder, sum(counts.values()))
    chunks, start = [], 0
    for source in SOURCES:
        chunks += chunked(folder, seed, source, start, counts[source])
        start += counts[source]
    # Spawns processes, because a fork would copy locks that threads of OpenCV and JAX may hold.
    with multiprocessing.get_context("spawn").Pool(processes, prepare, (sources,)) as pool, Progress("samples", len(samples)) as progress:
        for count in pool.imap_unordered(fill, chunks):
            progress.advance(count)
    return samples


def opened(folder, count=None):
    """Maps the arrays in the files of `folder`; creates them if a count is given."""
    forms = {"inputs": (np.uint8, (crops.SIDE, crops.SIDE, 2)), "corrections": (np.float32, (4,)), "kinds": (np.uint8, ())}
    arrays = {}
    for name, (kind, shape) in forms.items():
        path = f"{folder}/{name}.npy"
        if count is None:
            arrays[name] = np.lib.format.open_memmap(path, "r+")
        else:
            arrays[name] = np.lib.format.open_memmap(path, "w+", kind, (count, *shape))
    return Samples(**arrays)


def chunked(folder, seed, source, start, count):
    for index, offset in enumerate(range(0, count, CHUNK)):
        yield Chunk(str(folder), (seed, list(SOURCES).index(source), index), source, start + offset, min(CHUNK, count - offset))


# The clips that this worker process draws from.
CLIPS = []


def prepare(sources):
    cv2.setNumThreads(1)
    CLIPS[:] = clips.read(sources)


def fill(chunk):
    """Draws a chunk of samples into the files; returns their number."""
    rng = np.random.default_rng(chunk.seed)
    samples = opened(chunk.folder)
    raw = np.empty((chunk.count, 2, crops.SIDE, crops.SIDE), np.uint8)
    drawn = itertools.chain.from_iterable(SOURCES[chunk.source](rng, CLIPS) for _ in itertools.count())
    for index, (first, present, correction, kind) in enumerate(itertools.islice(drawn, chunk.count)):
        raw[index] = first, disturbances.dimmed(rng, present) if rng.random() < DIMMED_SHARE else present
        samples.corrections[chunk.start + index], samples.kinds[chunk.start + index] = correction, kind
    samples.inputs[chunk.start : chunk.start + chunk.count] = crops.normalised(raw).transpose(0, 2, 3, 1)
    return chunk.count


def pair(rng, drawn_from):
    first, present, change, tracked = pairs.drawn(rng, drawn_from)
    return [(first, present, change, Kind.TRACKED if tracked else Kind.JITTERED)]


def cutout(rng, drawn_from):
    return [(*cutouts.drawn(rng, drawn_from), Kind.CUTOUT)]


# Each source draws a group of samples from clips.
SOURCES = {"pairs": pair, "cutouts": cutout, "others": others.drawn}
