"""Recognise effects that change the noise: repeated frames, outliers, jitter, quantisation, coloured noise."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.residual.uneven_noise import (
    FEWEST_AT_A_LIMIT,
    LARGEST_P_VALUE,
    at_a_limit,
    longest_first,
    standard_deviation,
    with_rate_of_reading,
)
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.noise import AROUND, Quantisation, tail
from camid.effects.recognition import Recognition
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.fitting.unseen import unseen

Array = NDArray[np.float64]

# Rows are left out already where they are suspect: few rows more or less cost nothing.
SUSPECT_P_VALUE = 1e-2
# Rows that stand out beside their neighbours alone, at least.
FEWEST_ALONE = 3
# A resonance rises this much above the middle of the spectrum; two are the same within this ratio (logarithm).
RESONANCE_RATIO = 4.0
SAME_RESONANCE = 0.2
# Share of the variance that is left from which it is that of a lattice.
MOSTLY_ROUNDING = 0.5


def spoiled_rows(problem: Problem, base: Fitted) -> list[dict[str, NDArray[np.bool_]]]:
    """Rows of each recording to leave out, by the effect that they look like: repeated frames, residuals far off."""
    result = []
    for index in range(len(problem.experiments)):
        situation = problem.situation(base.model, index)
        rows: dict[str, NDArray[np.bool_]] = {}
        spoiling = [e for _, e in sorted(known_effects().items()) if e.spoils_rows and unseen(problem, e) is None]
        for effect in spoiling if situation.used.any() else ():  # a recording may validate only
            found = _alone(effect, situation) or effect.recognise(situation)
            if found is not None and found.p_value < SUSPECT_P_VALUE:
                rows[effect.identifier] = found.spoiled & situation.used
        result.append(rows)
    return result


def _alone(effect: type[Effect], situation: Situation) -> Recognition | None:
    """What the residual shows beside its rows' neighbours, where that stands out; None where nothing does.

    Structure that lasts for several frames, and is yet to be explained, hides what is smaller than itself.
    """
    around = np.lib.stride_tricks.sliding_window_view(np.pad(situation.residual, AROUND, mode="edge"), 2 * AROUND + 1)
    beside = np.median(np.delete(around, AROUND, axis=-1), axis=-1)
    found = effect.recognise(replace(situation, residual=situation.residual - beside))
    # Where a command jumps, a wrong hold or delay leaves single rows, too, of which one is the largest.
    several = found is not None and found.stands_out and np.count_nonzero(found.spoiled) >= FEWEST_ALONE
    return found if several else None


def recognised_noise(whole: Problem, problem: Problem, final: Fitted, declared: Sequence[Effect]) -> list[Recognition]:
    """Noise-like effects that are not declared already.

    Parameters
    ----------
    whole, problem : Problem
        With and without the rows that say nothing of the motion.
    final : Fitted
        The improved model.
    declared : sequence of Effect
        Of the nominal simulation.
    """
    known = {e.identifier for e in declared}
    situation, *others = (
        _where_motion_is_finite(with_rate_of_reading(whole, final.model, run)) for run in longest_first(whole)
    )
    found: list[Recognition] = []
    for identifier, effect in sorted(known_effects().items()):  # repeated frames come before outliers
        possible = effect.noise_like and unseen(problem, effect) is None
        if possible and identifier not in known:
            recognition = effect.recognise(situation)
            if recognition is not None and recognition.p_value < LARGEST_P_VALUE:
                refuted = any(recognition.effect.is_refuted(other) for other in others)
                found += [recognition] if recognition.named and not refuted else []
                situation = replace(situation, used=situation.used & ~recognition.spoiled)
    found = _without_imitations(situation, found)
    step = _step_of([*declared, *(r.effect for r in found)])
    found = _beyond_rounding(situation, found, step)
    rounding = step**2 / 12.0 > MOSTLY_ROUNDING * float(np.mean(situation.residual[situation.used] ** 2))
    for identifier in () if rounding else colours(problem, final, known):
        effect = known_effects()[identifier]
        if unseen(problem, effect) is None:
            p_value = problem.whiteness(final.residual, final.moving_sensitivities)
            found.append(_coloured(effect, problem, final, p_value))
    return found


def colours(problem: Problem, final: Fitted, known: Collection[str]) -> list[str]:
    """Effects that would give what is left its colour, by their identifiers; none where it has none.

    Parameters
    ----------
    problem : Problem
    final : Fitted
    known : collection of str
        Effects that are declared already.
    """
    if len(final.noise.whitening) == 1:
        return []
    kinds = [i for i, effect in sorted(known_effects().items()) if effect.colours_noise and i not in known]
    return kinds if kinds and problem.whiteness(final.residual, final.moving_sensitivities) < LARGEST_P_VALUE else []


def _where_motion_is_finite(situation: Situation) -> Situation:
    """Without rows in which the motion has run away: a sensor that clips hides that, and the residual is finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        finite = np.isfinite(situation.position**2 + situation.velocity**2)
    return replace(situation, used=situation.used & finite)


def _without_imitations(situation: Situation, found: list[Recognition]) -> list[Recognition]:
    """Without what is only the tails of noise whose variance another effect makes uneven: outliers of a jitter."""
    spread = standard_deviation([r.effect for r in found], situation)
    if spread is None:
        return found
    residual = situation.residual / spread

    def shows_in_even_noise(recognition: Recognition) -> bool:
        scaled = replace(situation, residual=residual, used=situation.used | recognition.spoiled)
        again = recognition.effect.recognise(scaled)
        return again is not None and again.named and again.p_value < LARGEST_P_VALUE

    return [r for r in found if not r.effect.judged_by_even_spread or shows_in_even_noise(r)]


def _step_of(effects: Sequence[Effect]) -> float:
    """Step of the lattice to which readings are rounded; zero where there is none.

    Where most of what is left is rounding, it has the colour that the motion gives it.
    """
    return max((float(effect.values["step"]) for effect in effects if isinstance(effect, Quantisation)), default=0.0)


def _beyond_rounding(situation: Situation, found: list[Recognition], step: float) -> list[Recognition]:
    """Without those that only rows tell of in which readings keep their value: of motion rounding is even noise."""
    if step == 0.0 or not any(_is_spread(r.effect) for r in found):
        return found
    passing = np.abs(situation.velocity) * situation.acquisition.period >= step
    moving = replace(situation, used=situation.used & passing)

    def shows_in_motion(recognition: Recognition) -> bool:
        again = recognition.effect.recognise(moving)
        return again is not None and again.named and again.p_value < LARGEST_P_VALUE

    return [r for r in found if not _is_spread(r.effect) or shows_in_motion(r)]


def _is_spread(effect: Effect) -> bool:
    """Whether it makes the variance uneven, and that alone shows it."""
    return effect.makes_variance_uneven and not (effect.shows_in_values or effect.spoils_rows)


def _coloured(kind: type[Effect], problem: Problem, final: Fitted, p_value: float) -> Recognition:
    """The autoregression of the residual, with standard deviations of its coefficients (Ljung 1999, section 9.4)."""
    coefficients = -final.noise.whitening[1:]
    rows = np.lib.stride_tricks.sliding_window_view(final.residual, len(coefficients))
    innovations = problem.whitened(final.residual, final.noise.whitening)
    variance = float(np.mean(innovations**2))
    covariance = variance * np.linalg.pinv(rows.T @ rows)
    deviations = np.sqrt(np.diag(covariance))[::-1]
    effect = kind.of_autoregression(coefficients)
    (parameter,) = effect.parameters
    spoiled = np.zeros(len(problem.times[0]), bool)
    return Recognition(effect, {parameter.name: deviations.tolist()}, p_value, spoiled)


def depends_on_position(problem: Problem, final: Fitted) -> float:
    """P-value of a variance of the noise that does not change with the position.

    Readings at a limit say nothing of it. Spearman's rank correlation (1904, Am. J. Psychol. 15, 72-101) of the squares
    of both: a score in the values themselves hangs on the few rows that are far out, and its tails are then not those
    of a Gaussian. Of equal values a later one ranks higher; scipy.stats, which would share ranks out, takes longer to
    load than a diagnosis.
    """
    situation = problem.situation(final.model)
    compared = situation.signal if situation.controlled else situation.recorded
    rows = situation.used & ~at_a_limit(compared, situation.used)
    if np.count_nonzero(rows) < FEWEST_AT_A_LIMIT:
        return 1.0
    squares = (situation.residual[rows] ** 2, situation.position[rows] ** 2)
    residual, position = (np.argsort(np.argsort(s, kind="stable"), kind="stable") for s in squares)
    correlation = float(np.corrcoef(residual, position)[0, 1])
    return min(2.0 * tail(abs(correlation) * np.sqrt(len(residual) - 1.0)), 1.0)


def force_like(problem: Problem, final: Fitted) -> bool:
    """Whether coloured noise has the plant's own resonance: then it is rather an unmodelled force.

    The spectrum of the fitted autoregression is compared with that of a white force after plant and camera.
    """
    if len(final.noise.whitening) < 3:
        return False
    plant = problem.structure.plant(final.model.coefficients)
    period = problem.acquisition.period
    angular = np.linspace(0.02, 0.98, 200) * np.pi / period
    response = np.abs(plant.frequency_response(angular)) ** 2
    peak = int(np.argmax(response))
    if peak in {0, len(angular) - 1} or response[peak] < RESONANCE_RATIO * float(np.median(response)):
        return False
    shift = np.exp(-1j * np.outer(angular * period, np.arange(len(final.noise.whitening))))
    spectrum = 1.0 / np.abs(shift @ final.noise.whitening) ** 2
    highest = int(np.argmax(spectrum))
    near = abs(np.log(angular[highest] / angular[peak])) < SAME_RESONANCE
    return bool(near and spectrum[highest] > RESONANCE_RATIO * float(np.median(spectrum)))
