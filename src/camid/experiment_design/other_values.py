"""Hypotheses with other values than those that fit the earlier recordings best.

What a rival leaves of an experiment is computed around values of its parameters. Around those that fit the first
recording best it is too much wherever others fit that nearly as well: a stop that begins elsewhere, another period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.remaining_hypotheses import stable_names
from camid.effects.base import Effect
from camid.experiment_design.hypothesis import Hypothesis
from camid.experiment_design.together import Earlier, Together

Array = NDArray[np.float64]

# Evaluations of a fit with given shape, and those by which it may leave more than the best, in variances of the noise.
STEPS = 8
MOST_BEYOND = 40.0
# What a shape has to remove of the mismatch, in variances of the noise.
SMALLEST_GAIN = 4.0
# Shapes that are kept of one name, and how much the numbers of two have to differ.
MOST_SHAPES = 3
ALIKE = 0.15
# Another size of an effect.
LARGER = 2.0


def own_sums(hypotheses: Sequence[Hypothesis], earlier: Earlier) -> list[float]:
    """Sums of squares that hypotheses leave of the earlier recordings, in variances of the noise."""
    found = []
    for hypothesis in hypotheses:
        whole = Together(hypothesis, earlier, finest=True)
        start = whole.start if earlier.at_rest else whole.least(whole.start, STEPS)[0]
        found.append(whole.cost(start))
    return found


def other_values(hypotheses: Sequence[Hypothesis], earlier: Earlier, sums: Sequence[float]) -> list[Hypothesis]:
    """Names with other shapes, each with the size and coefficients that fit the earlier recordings best then.

    Parameters
    ----------
    hypotheses : sequence of Hypothesis
    earlier : Earlier
    sums : sequence of float
        Of :func:`own_sums`.
    """
    found: list[Hypothesis] = []
    for hypothesis, least in zip(hypotheses, sums, strict=True):
        place = next(
            (i for i, h in enumerate(hypotheses) if not h.identifier and h.question == hypothesis.question), None
        )
        if hypothesis.effect is None or place is None:
            continue
        # What removes nothing has no size, and is the simulation without the effect.
        most = min(MOST_BEYOND, sums[place] - least - SMALLEST_GAIN)
        guesses = _shapes(hypothesis, hypotheses[place], earlier)
        fitted = [_with_shape(hypothesis, guess, earlier, least) for guess in guesses]
        near = sorted((f for f in fitted if f is not None and f.beyond < most), key=lambda f: f.beyond)
        found += near[:MOST_SHAPES]
    return found


def shape_of(effect: Effect) -> list[str]:
    """Numbers of an effect that are the same at another size of it; none where nothing is its size."""
    names = [p.name for p in effect.numeric()]
    larger = effect.scaled(LARGER)
    return [n for n in names if larger.values[n] == effect.values[n]] if effect.strength in names else []


def _shapes(hypothesis: Hypothesis, without: Hypothesis, earlier: Earlier) -> list[Effect]:
    """First guesses of a name's effect that differ in their shape, with the size that it was fitted with."""
    effect = hypothesis.effect
    if effect is None or not shape_of(effect):
        return []
    names = shape_of(effect)
    problem, model = earlier.problem(without)
    kept: list[Array] = [np.array([effect.values[n] for n in names], float)]
    found = []
    try:
        for guess in type(effect).candidates(problem.situations(model).of(type(effect))):
            if type(guess) is not type(effect):  # a law with more detail has other numbers
                continue
            numbers = np.array([guess.values[n] for n in names], float)
            if not any(np.allclose(numbers, k, rtol=ALIKE, atol=0.0) for k in kept):
                kept.append(numbers)
                found.append(guess)
    except (ValueError, ArithmeticError):  # what is no guess for this plant ends them
        pass
    return found


def _with_shape(hypothesis: Hypothesis, guess: Effect, earlier: Earlier, least: float) -> Hypothesis | None:
    """A name with another shape, the rest fitted to the earlier recordings; None where that fails."""
    effects = tuple(guess if e.identifier == guess.identifier else e for e in hypothesis.model.effects)
    moved = replace(hypothesis, model=replace(hypothesis.model, effects=effects), held=held_shape(hypothesis))
    try:
        whole = Together(moved, earlier)
        vector, _ = whole.least(whole.start, STEPS)
        return around(whole, vector, least)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None


def held_shape(hypothesis: Hypothesis) -> frozenset[str]:
    """Names of the parameters that are the shape of a name's effect."""
    effect = hypothesis.effect
    return frozenset() if effect is None else frozenset(f"{effect.identifier} {n}" for n in shape_of(effect))


def around(whole: Together, vector: Array, least: float) -> Hypothesis:
    """What the earlier recordings say of a hypothesis around given values; its shape is held there.

    Parameters
    ----------
    whole : Together
        Of the hypothesis and the earlier recordings alone.
    vector : ndarray, shape (p,)
    least : float
        Sum of squares of the hypothesis with its own values.
    """
    hypothesis, packing = whole.hypothesis, whole.packing
    model = packing.unpack(vector)
    columns = np.zeros((len(whole.recorded), len(vector)))
    columns[:, whole.free] = whole.table(vector)
    columns = columns / packing.units
    left = whole.whitened(whole.recorded - whole.simulated(vector))
    information, slope, beyond = columns.T @ columns, -columns.T @ left, float(left @ left) - least
    names = stable_names(packing.names, model.effects)
    initial = np.array([n.startswith("initial ") for n in names], bool)
    if initial.any():  # what initial states take of it
        across = information[np.ix_(~initial, initial)] @ np.linalg.pinv(
            information[np.ix_(initial, initial)], hermitian=True
        )
        beyond -= float(slope[initial] @ np.linalg.pinv(information[np.ix_(initial, initial)]) @ slope[initial])
        slope = slope[~initial] - across @ slope[initial]
        information = information[np.ix_(~initial, ~initial)] - across @ information[np.ix_(initial, ~initial)]
        names = [n for n, is_initial in zip(names, initial, strict=True) if not is_initial]
    return replace(
        hypothesis,
        model=replace(model, initial=hypothesis.model.initial),
        variant=True,
        known={name: i for i, name in enumerate(names)},
        information=0.5 * (information + information.T),
        slope=slope,
        beyond=beyond,
        held=held_shape(hypothesis),
    )
