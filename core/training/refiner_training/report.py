"""Measures the weights before any tracker runs: mean absolute errors of boxes before and after one correction, with the file's integers."""

import numpy as np

from . import integers
from .layers import OUTPUT_UNIT
from .samples import Kind

NAMES = {Kind.JITTERED: "pairs, random error", Kind.TRACKED: "pairs, the tracker's error", Kind.CUTOUT: "cut-outs"}


def measured(parameters, samples):
    """Mean errors before and after a correction, by kind of sample: centre in sides of the box, log size, log aspect."""
    outputs = integers.in_batches(parameters, samples.inputs)
    left = samples.corrections - outputs[:, :4] / OUTPUT_UNIT
    return {NAMES[kind]: compared(samples.corrections, left, samples.kinds == kind) for kind in Kind if (samples.kinds == kind).any()}


def compared(before, after, chosen):
    return {"samples": int(chosen.sum()), "before": errors(before[chosen]), "after": errors(after[chosen])}


def errors(corrections):
    """Mean absolute errors: the centre over x and y; log size and log aspect are half the sum and half the difference of log width and height."""
    width, height = corrections[:, 2], corrections[:, 3]
    return {
        "centre": rounded(abs(corrections[:, :2])),
        "size": rounded(abs(width + height) / 2),
        "aspect": rounded(abs(width - height) / 2),
    }


def rounded(values):
    return round(float(np.mean(values)), 4)


def table(results, title):
    lines = [title, f"{'':28}{'samples':>8}   {'centre':16}{'size':16}{'aspect':16}"]
    for name, result in results.items():
        cells = [f"{result['before'][what]:.3f} to {result['after'][what]:.3f}" for what in ("centre", "size", "aspect")]
        lines.append(f"{name:28}{result['samples']:8}   " + "".join(f"{cell:16}" for cell in cells).rstrip())
    return "\n".join(lines)
