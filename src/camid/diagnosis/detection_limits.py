"""What a recording could not have shown: the smallest size of each effect that it would have detected."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from camid.diagnosis.diagnosis import Undetectable
from camid.diagnosis.search.false_alarms import FALSE_ALARM, FALSE_ALARM_BESIDE_OTHERS
from camid.diagnosis.search.screening import Metric, ScreenedEffect, metrics, signature, trials
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.situation import Situation
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.fitting.unseen import unseen
from camid.number_text import number
from camid.side_by_side import side_by_side

# Standard deviations beyond the threshold at which 95 % of the recordings detect an effect.
POWER = 1.645
# A size is found to this accuracy in the root of the expected gain, in at most this many simulations.
ACCURACY = 0.03
SIMULATIONS = 6
LARGEST_FACTOR = 1e4
# By how much an effect is made stronger to see to which side of a size it shows: of a limit smaller values do.
STRONGER = 1.25


def needed(problem: Problem, effect: type[Effect], level: float = FALSE_ALARM) -> float:
    """Root of the expected gain at which 95 % of recordings detect an effect at a probability of false alarms."""
    from scipy.special import chdtri

    count = sum(not e.noise_like for e in known_effects().values())
    freedom = max(len(effect.numeric()), 1)
    threshold = float(chdtri(freedom, level / (trials(effect, problem) * count)))
    return float(np.sqrt(threshold)) + POWER


def undetectable(
    problem: Problem, fitted: Fitted, screened: Sequence[ScreenedEffect], found: set[str]
) -> list[Undetectable]:
    """Every effect of the catalogue that was not found, with its smallest detectable size.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
        The improved model.
    screened : sequence of ScreenedEffect
        Of the refitted nominal model.
    found : set of str
        Identifiers of the effects that were found.
    """
    situation, view = problem.situation(fitted.model), metrics(problem, fitted)[-1]
    level = FALSE_ALARM_BESIDE_OTHERS if found else FALSE_ALARM
    shapes: dict[str, list[ScreenedEffect]] = {}
    for candidate in screened:
        shapes.setdefault(candidate.effect.identifier, []).append(candidate)

    items = [(e, shapes.get(i, [])) for i, e in sorted(known_effects().items()) if i not in found]
    return side_by_side(partial(_judged, problem, fitted, situation, view, level), items)


def _judged(
    problem: Problem,
    fitted: Fitted,
    situation: Situation,
    view: Metric,
    level: float,
    item: tuple[type[Effect], Sequence[ScreenedEffect]],
) -> Undetectable:
    """What of an effect the recording could have shown."""
    effect, shapes = item
    identifier = effect.identifier
    reason = unseen(problem, effect)
    if reason is None and effect.noise_like:
        return Undetectable(identifier, effect.limit_of_recognition(situation))
    reason = reason or effect.invisible(situation)
    if reason is not None:
        return Undetectable(identifier, reason)
    visible = [c for c in shapes if c.visible > 0.0]
    if not visible and effect.bends_coefficients:
        return Undetectable(
            identifier,
            "the re-estimated motion never gets to where it would show, so that nothing is known of its size",
        )
    if not visible:
        return Undetectable(
            identifier,
            "with this input a change of the plant's coefficients imitates it, or it has no meaning here",
        )
    # A law with more detail has no smallest size of its own beside that of its name.
    plain = [c for c in visible if type(c.effect) is effect] or visible
    return _smallest(problem, fitted, view, max(plain, key=lambda c: c.visible), level)


def _visible(problem: Problem, fitted: Fitted, view: Metric, effect: Effect) -> tuple[float, float]:
    """Root of the gain to be expected, and the share that the coefficients imitate."""
    change = signature(problem, fitted, effect)
    if change is None:
        return 0.0, 1.0
    rest, whole = view.left(problem, change)
    size = float(np.linalg.norm(rest))
    return size / float(np.sqrt(max(view.variance, 1e-300))), 1.0 - (size / whole) ** 2 if whole > 0.0 else 1.0


def _smallest(problem: Problem, fitted: Fitted, view: Metric, candidate: ScreenedEffect, level: float) -> Undetectable:
    """Size of an effect of one shape at which it is detected in 95 % of the recordings."""
    effect, kind = candidate.effect, type(candidate.effect)
    wanted = needed(problem, kind, level)
    visible, imitated = _visible(problem, fitted, view, effect)
    factor = 1.0
    for _ in range(SIMULATIONS):
        if visible <= 0.0 or abs(visible / wanted - 1.0) < ACCURACY:
            break
        following = factor * min(max(wanted / visible, 1e-2), 1e2)
        if following > LARGEST_FACTOR:
            break
        scaled = candidate.effect.scaled(following).within(problem.acquisition)
        if scaled.values == effect.values:
            break
        factor, effect = following, scaled
        visible, imitated = _visible(problem, fitted, view, effect)
    numeric = kind.numeric()
    share = f"the coefficients imitate {100.0 * imitated:.3g} % of it" if imitated > 0.005 else "noise hides it"
    if not numeric:
        times = visible / wanted
        visibly = f"{number(times, 2)} times as visible as needed"
        if times < 1.0:
            return Undetectable(kind.identifier, f"{share}; it would have been {visibly}")
        return Undetectable(kind.identifier, visibly, shows=True)
    if visible < 0.5 * wanted:
        return Undetectable(kind.identifier, f"{share}; no size of it would have been seen in this recording")
    acting = [p for p in numeric if p.name not in candidate.effect.idle] or numeric
    parameter = next((p for p in acting if p.name == kind.strength), acting[0])
    others = [p for p in acting if p.name != parameter.name]
    shape = {p.name: (float(effect.values[p.name]), p.unit) for p in others}
    idle = candidate.effect.idle | {parameter.name}
    rest = {name: value for name, value in effect.stated().items() if name not in idle}
    value = float(effect.values[parameter.name])
    none, more = (_scaled_value(effect, times, parameter.name) for times in (0.0, STRONGER))
    return Undetectable(
        kind.identifier,
        f"{share} where it is weaker",
        parameter.name,
        value,
        parameter.unit,
        rest,
        shape=shape,
        neutral=none if np.isfinite(none) and none != value else None,
        shows_above=more >= value,
    )


def _scaled_value(effect: Effect, times: float, name: str) -> float:
    """A parameter of an effect of another strength; infinite where a limit that does nothing has no value."""
    try:
        return float(effect.scaled(times).values[name])
    except (ValueError, ArithmeticError):
        return float(np.inf)
