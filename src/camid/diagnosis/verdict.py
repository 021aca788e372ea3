"""From a decision to words: findings, verdict and explanation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import UNLISTED, Correction, Finding, Location, NormalisedErrors, ParameterEstimate
from camid.diagnosis.effect_selection import Decision, p_value
from camid.diagnosis.hypothesis import weights
from camid.effects import known_effects
from camid.effects.base import Effect, Recognition
from camid.effects.separating_experiment import advice
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.number_text import SPACE, number, percentage, plain, with_deviation

Array = NDArray[np.float64]

# Per cent of the output's standard deviation from which a simulation explains hardly anything.
EXPLAINS_NOTHING = 90.0


def parameters_of(effect: Effect, deviations: Mapping[str, float | None]) -> dict[str, ParameterEstimate]:
    """Values with standard deviations and units."""
    return {p.name: ParameterEstimate(effect.values[p.name], deviations.get(p.name), p.unit) for p in effect.parameters}


def effect_deviations(fitted: Fitted) -> list[dict[str, float | None]]:
    """Standard deviations of every effect's parameters; None where the data leave one undetermined."""
    variances = np.diag(fitted.covariance)
    found: list[dict[str, float | None]] = []
    for i, effect in enumerate(fitted.model.effects):
        row: dict[str, float | None] = {}
        for parameter in effect.numeric():
            variance = float(variances[fitted.packing.names.index(f"{i} {parameter.name}")])
            row[parameter.name] = sqrt(variance) if np.isfinite(variance) and variance >= 0.0 else None
        found.append(row)
    return found


def findings(
    problem: Problem,
    decision: Decision,
    known: int,
    removed: Sequence[float],
    validation: Sequence[float | None],
    unlisted: float,
) -> list[Finding]:
    """One finding per effect, the strongest first.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    removed, validation : sequence of float
        Share of the refitted sum of squares that each effect removes, on fitted and on other rows.
    unlisted : float
        Weight of physics outside of the catalogue.
    """
    deviations = effect_deviations(decision.improved)
    # Effects that describe much of the same leave little for each beside the others.
    together = min(max(1.0 - decision.fitted.cost / max(decision.base.cost, 1e-300), 0.0), 1.0)
    common = {} if len(removed) < 2 else {"share_together": together}
    result = []
    for i, effect in enumerate(decision.improved.model.effects[known : len(decision.fitted.model.effects)]):
        ranked = decision.rivals[i]
        names = weights(ranked, decision.without[i])
        own = next((w for name, w in names if name == effect.identifier), 1.0)
        others = [(name, w) for name, w in names if name != effect.identifier]
        scale = (1.0 - unlisted) / (own + sum(w for _, w in others))
        own, others = own * scale, [(name, w * scale) for name, w in others]
        if unlisted > 0.0:
            others.append((UNLISTED, unlisted))
        runner = ranked[1] if len(ranked) > 1 else None
        evidence = {
            "share": float(removed[i]),
            **common,
            "validation_gain": validation[i],
            "false_alarm_probability": p_value(problem, decision.without[i], decision.fitted, effect.identifier),
            "delta_bic": float(decision.without[i].criterion_beyond(ranked[0].fitted) - ranked[0].penalty),
            "next_best": None if runner is None else runner.identifier,
            "delta_bic_to_next_best": None if runner is None else float(runner.beyond(ranked[0])),
        }
        result.append(
            Finding(
                effect.identifier,
                effect.place,
                effect.title,
                effect.equation,
                effect.reference,
                parameters_of(effect, deviations[known + i]),
                evidence,
                own,
                others,
                advice(
                    effect.separated_by,
                    [known_effects()[n].separated_by for n, w in others if n != UNLISTED and w > 0.02],
                ),
            )
        )
    return sorted(result, key=lambda f: -f.evidence["share"])


def corrections_of(decision: Decision, known: int) -> list[Correction]:
    """What the improved model holds behind the effects that are named.

    Parameters
    ----------
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    """
    first = known + len(decision.rivals)
    deviations = effect_deviations(decision.improved)
    return [
        Correction(effect.identifier, effect.place, effect.title, parameters_of(effect, deviations[first + i]))
        for i, effect in enumerate(decision.improved.model.effects[first:])
    ]


def recognised(recognition: Recognition) -> Finding:
    """Finding of a noise-like effect."""
    effect = recognition.effect
    return Finding(
        effect.identifier,
        effect.place,
        effect.title,
        effect.equation,
        effect.reference,
        parameters_of(effect, recognition.standard_deviations),
        {"share": 0.0, "validation_gain": None, "false_alarm_probability": recognition.p_value},
    )


def verdict_of(named: bool, structured: bool) -> str:
    """One of the four verdicts."""
    if named:
        return "partly-explained" if structured else "explained"
    return "unexplained" if structured else "adequate"


def explanation(
    verdict: str,
    found: Sequence[Finding],
    fit: NormalisedErrors,
    location: Location,
    remainder: float | None = None,
    corrections: Sequence[Correction] = (),
) -> str:
    """Two or three plain sentences with the numbers in them."""
    before, after, floor = (_share(v) for v in (fit.refitted, fit.improved, fit.noise_floor))
    if remainder is not None:
        return (
            f"Nothing is left out beyond what an earlier diagnosis left unexplained: the simulation declares a "
            f"remainder of {number(remainder)} (root mean square), and with its coefficients re-estimated it leaves no "
            f"more than that: {before} of the output's standard deviation on rows that were not fitted. Remove "
            f"the key remainder to have that looked into again."
        )
    if verdict == "adequate":
        return (
            f"Nothing is left out that this recording could show: with its coefficients re-estimated the simulation "
            f"leaves {before} of the output's standard deviation on rows that were not fitted, and the noise "
            f"alone {floor}. What the recording could not have shown is listed."
            + (
                " But it explains hardly anything of the output, which may be noise."
                if 100.0 * fit.refitted > EXPLAINS_NOTHING
                else ""
            )
        )
    where = f" The mismatch sits at the {location.place}." if location.place else ""
    if verdict == "unexplained":
        return (
            f"Something is left out, and no effect of the catalogue explains it: re-estimating the coefficients leaves "
            f"{before} of the output's standard deviation on rows that were not fitted (the noise in the fitted "
            f"ones is estimated as {floor}), and what is left is structured.{where}"
        )
    names = " and ".join(_described(f) for f in found)
    sentence = (
        f"The simulation leaves out: {names}. On rows that were not fitted the error falls from {before} "
        f"(coefficients re-estimated) to {after} of the output's standard deviation; noise alone is {floor}."
        f"{where}"
    )
    if corrections:
        titles = " and ".join(c.title.lower() for c in corrections)
        sentence += (
            f" The improved simulation also holds {titles}, not as a finding but as a correction: it lowers this "
            f"error, and may only stand for what the law above has inexactly."
        )
    if verdict == "partly-explained":
        sentence += " What is left is still structured, so something else is missing, too, or the law is another."
    classes = [f for f in found if [n for n, w in f.alternatives if w >= 0.02 and n != UNLISTED]]
    if classes:
        others = ", ".join(n for n, w in classes[0].alternatives if n != UNLISTED)
        sentence += f" This recording cannot tell {classes[0].identifier} from {others}."
    return sentence


def _share(value: float) -> str:
    return percentage(value).replace(SPACE, " ")


def _described(finding: Finding) -> str:
    """Title with the leading parameter."""
    for name, parameter in finding.parameters.items():
        words = name.replace("_", " ")
        if isinstance(parameter.value, float):
            deviation = parameter.standard_deviation
            estimate = with_deviation(parameter.value, deviation, parameter.unit)
            shown = f"about {plain(parameter.value, unit=parameter.unit)}" if deviation is None else estimate
            if deviation is not None and abs(parameter.value) < deviation:
                shown = f"not determined, {estimate}"
            return f"{finding.title} ({words} {shown.replace(SPACE, ' ')})"
        if isinstance(parameter.value, str):
            return f"{finding.title} ({parameter.value})"
    return finding.title
