"""Measures the weights before any tracker runs: mean absolute errors of boxes before and after one correction, with the file's integers."""

import numpy as np

from . import integers
from .layers import OUTPUT_UNIT
from .kinds import CORRECTED, OTHERS, Kind

NAMES = {Kind.JITTERED: "pairs, random error", Kind.TRACKED: "pairs, the tracker's error", Kind.CUTOUT: "cut-outs"}


def measured(parameters, samples):
    """Mean errors before and after a correction, by kind of sample: centre in sides of the box, log size, log aspect."""
    outputs = integers.in_batches(parameters, samples.inputs)
    left = samples.corrections - outputs[:, :4] / OUTPUT_UNIT
    return {NAMES[kind]: compared(samples.corrections, left, samples.kinds == kind) for kind in CORRECTED if (samples.kinds == kind).any()}


def matched(parameters, samples):
    """Area under the ROC curve of the match: samples of the target, of all kinds, against each kind of other thing and against all."""
    logits = integers.in_batches(parameters, samples.inputs)[:, 6]
    other = np.isin(samples.kinds, OTHERS)
    kinds = {kind.name.lower().replace("_", " "): samples.kinds == kind for kind in OTHERS}
    return {name: area(logits[~other], logits[chosen]) for name, chosen in ({"all": other} | kinds).items() if chosen.any()}


def area(target, others):
    """Share of pairs (a sample of the target, one of another thing) that the logits order rightly; equal logits count half."""
    ordered = np.sort(others)
    below, up_to = np.searchsorted(ordered, target, "left"), np.searchsorted(ordered, target, "right")
    return round(float((below + up_to).mean() / (2 * len(others))), 4)


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


def table(results):
    lines = [f"Mean absolute errors, before to after, on {results['on']}", f"{'':28}{'samples':>8}   {'centre':16}{'size':16}{'aspect':16}"]
    for name, result in results["kinds"].items():
        cells = [f"{result['before'][what]:.3f} to {result['after'][what]:.3f}" for what in ("centre", "size", "aspect")]
        lines.append(f"{name:28}{result['samples']:8}   " + "".join(f"{cell:16}" for cell in cells).rstrip())
    lines.append("Area under the ROC curve of the match, the target against: " + ", ".join(f"{name} {value:.3f}" for name, value in results["match"].items()))
    return "\n".join(lines)
