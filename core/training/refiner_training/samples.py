"""Draws samples on all cores. Each chunk has its own seed, so the samples do not depend on the number of cores."""

import multiprocessing
from dataclasses import dataclass
from enum import IntEnum

import cv2
import numpy as np

from . import clips, crops, cutouts, pairs
from .errors import BadInput
from .progress import Progress

CHUNK = 2500


class Kind(IntEnum):
    """The source of a sample and of its box's error."""

    JITTERED = 0  # a pair of frames, drawn at random
    TRACKED = 1  # a pair of frames, the tracker's own
    CUTOUT = 2  # a made sample


@dataclass(frozen=True)
class Samples:
    inputs: np.ndarray  # (samples, 32, 32, 2) of u8, normalised: the first crop, the present one
    corrections: np.ndarray  # (samples, 4)
    kinds: np.ndarray  # (samples,)

    def __len__(self):
        return len(self.inputs)


@dataclass(frozen=True)
class Chunk:
    folder: str
    seed: tuple
    cutouts: bool
    start: int
    count: int


def draw(sources, pair_count, cutout_count, seed, folder, processes):
    """Draws samples into files in `folder`: pairs, then cut-outs."""
    # Checks the recordings before processes start, because a pool whose processes fail at their start never ends.
    if not clips.read(sources):
        raise BadInput("no recording shows its target in two frames")
    samples = opened(folder, pair_count + cutout_count)
    chunks = [*chunked(folder, seed, False, 0, pair_count), *chunked(folder, seed, True, pair_count, cutout_count)]
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


def chunked(folder, seed, made, start, count):
    for index, offset in enumerate(range(0, count, CHUNK)):
        yield Chunk(str(folder), (seed, int(made), index), made, start + offset, min(CHUNK, count - offset))


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
    for index in range(chunk.count):
        place = chunk.start + index
        raw[index, 0], raw[index, 1], samples.corrections[place], samples.kinds[place] = sample(rng, chunk.cutouts)
    samples.inputs[chunk.start : chunk.start + chunk.count] = crops.normalised(raw).transpose(0, 2, 3, 1)
    return chunk.count


def sample(rng, made):
    if made:
        return *cutouts.drawn(rng, CLIPS), Kind.CUTOUT
    first, present, change, tracked = pairs.drawn(rng, CLIPS)
    return first, present, change, Kind.TRACKED if tracked else Kind.JITTERED
