"""Training: Adam on a robust loss with a cosine learning rate. The last three quarters of the steps use rounded parameters."""

import jax
import jax.numpy as jnp
import numpy as np

from . import network
from .kinds import OTHERS
from .progress import Progress

BATCH = 256
# Samples of a batch that are drawn to tell the target from other things; in all others the network also learns a correction.
OTHER_BATCH = 112
# Largest element of a correction of a target that the match must recognise: a box further off may count as either.
RECOGNISED = 0.5
# The logit of a match is this number of times the network's output.
LOGIT = 4
LEARNING_RATE, WARM_UP, MIN_RATE = 2.5e-3, 200, 1e-6
DECAY = 2e-3  # of weights, times the learning rate
MOMENTUM, SQUARES = 0.9, 0.999
LARGEST_GRADIENT = 5.0
UNROUNDED_SHARE = 0.25
# The loss is quadratic in errors of the correction below this value, and linear in larger errors. The errors are in
# sides of the box (dx, dy) or in natural logarithms (width, height).
SMOOTH = 0.03
# Minimum and maximum of the log spreads that the network predicts for its errors, and the log spread at a network output of 0.
MIN_SPREAD, MAX_SPREAD, SPREAD_AT_ZERO = -5.0, 1.0, -1.5


def loss(parameters, inputs, corrections, shown, judged, rounded):
    """The loss of the correction in samples that show the target, plus that of the match in samples whose match is judged."""
    outputs = network.forward(parameters, inputs, rounded)
    return mean(correction_loss(outputs, corrections), shown) + mean(match_loss(outputs, shown), judged)


def mean(values, weights):
    return (values * weights).sum() / weights.sum()


def correction_loss(outputs, corrections):
    """The negative log likelihood of the errors for the spreads that the network predicts: one for the place, one for the size."""
    errors = smooth(jnp.abs(outputs[:, :4] - corrections))
    spreads = jnp.clip(outputs[:, 4:6] + SPREAD_AT_ZERO, MIN_SPREAD, MAX_SPREAD)
    sums = jnp.stack([errors[:, 0] + errors[:, 1], errors[:, 2] + errors[:, 3]], 1)
    return (sums * jnp.exp(-spreads) + 2 * spreads).sum(1)


def match_loss(outputs, shown):
    """The cross entropy of the match: whether the present crop shows the target."""
    logits = LOGIT * outputs[:, 6]
    return jnp.logaddexp(0, logits) - logits * shown


def smooth(error):
    return jnp.where(error < SMOOTH, error * error / (2 * SMOOTH) + SMOOTH / 2, error)


def learning_rate(step, steps):
    return LEARNING_RATE * (0.5 + 0.5 * jnp.cos(jnp.pi * step / steps)) * jnp.minimum(1, step / WARM_UP) + MIN_RATE


def clipped(gradients):
    norm = jnp.sqrt(sum((gradient * gradient).sum() for gradient in jax.tree.leaves(gradients)))
    return jax.tree.map(lambda gradient: gradient * jnp.minimum(1, LARGEST_GRADIENT / (norm + 1e-9)), gradients)


def advanced(state, inputs, corrections, shown, judged, step, steps, rounded):
    """Returns the state after a step of Adam (parameters, means of the gradients, means of their squares), and the loss."""
    parameters, means, squares = state
    value, gradients = jax.value_and_grad(loss)(parameters, inputs, corrections, shown, judged, rounded)
    gradients = clipped(gradients)
    rate = learning_rate(step, steps)
    means = jax.tree.map(lambda mean, new: MOMENTUM * mean + (1 - MOMENTUM) * new, means, gradients)
    squares = jax.tree.map(lambda mean, new: SQUARES * mean + (1 - SQUARES) * new * new, squares, gradients)
    mean_scale, square_scale = 1 - MOMENTUM ** (step + 1), 1 - SQUARES ** (step + 1)

    def moved(parameter, mean, square):
        return parameter * (1 - rate * DECAY) - rate * (mean / mean_scale) / (jnp.sqrt(square / square_scale) + 1e-7)

    return (jax.tree.map(moved, parameters, means, squares), means, squares), value


def batch(samples, rng, step):
    """Draws a batch, mirrored left to right in every second step, and upside down in two of four steps.

    Returns the inputs, the corrections, and two weights for each sample: 1 if it shows the target, 1 if its match is judged.
    """
    corrected = samples.corrected
    chosen = np.concatenate([np.sort(rng.integers(0, corrected, BATCH - OTHER_BATCH)), np.sort(rng.integers(corrected, len(samples), OTHER_BATCH))])
    inputs, corrections = samples.inputs[chosen], samples.corrections[chosen]
    shown = ~np.isin(samples.kinds[chosen], OTHERS)
    judged = ~shown | (abs(corrections).max(1) < RECOGNISED)
    if step & 1:
        inputs, corrections = inputs[:, :, ::-1], corrections * np.float32([-1, 1, 1, 1])
    if step & 2:
        inputs, corrections = inputs[:, ::-1], corrections * np.float32([1, -1, 1, 1])
    return np.ascontiguousarray(inputs), corrections, shown.astype(np.float32), judged.astype(np.float32)


def fit(samples, steps, seed):
    """Trains the network and returns its parameters."""
    parameters = network.initial(seed)
    zeros = jax.tree.map(jnp.zeros_like, parameters)
    state = (parameters, zeros, zeros)
    step_of = jax.jit(advanced, static_argnums=(6, 7))
    rng = np.random.default_rng(seed)
    with Progress("training", steps) as progress:
        for step in range(steps):
            state, value = step_of(state, *batch(samples, rng, step), step, steps, step >= steps * UNROUNDED_SHARE)
            progress.advance(note=f"loss {float(value):.3f}")
    return state[0]
