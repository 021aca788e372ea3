"""From a decision to findings, and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.finding import Finding, ParameterEstimate
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.false_alarms import p_value
from camid.diagnosis.search.hypothesis import members_of
from camid.diagnosis.weights import HEADLINE_WEIGHT, UNLISTED, Comparison, Member, weights
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.parameter import Parameter
from camid.effects.recognition import Recognition
from camid.effects.separating_experiment import advice
from camid.effects.special_cases import same_in_place
from camid.engine.work import Work
from camid.fitting.covariance import effect_deviations
from camid.fitting.possible_laws import over_of, visited
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Distance from a bound, in standard deviations, up to which a fit has ended there: a search stays a hair inside.
AT_BOUND = 1e-3
# Weight from which another name is worth an experiment.
LEAST_RIVAL = 0.02
# Difference of two inputs, as a share of the sum of their sizes, up to which one is a repetition of the other.
SAME_INPUT = 0.05


def parameters_of(effect: Effect, deviations: Mapping[str, float | None]) -> dict[str, ParameterEstimate]:
    """Values with standard deviations and units; none of a number of which the recording shows nothing."""
    declared = {p.name: p for p in effect.parameters}
    shown = {n: None if n in effect.idle else d for n, d in deviations.items()}
    found = {}
    for name, value in effect.stated().items():
        bound = _bound_at(declared[name], value, shown.get(name))
        if bound is None:
            found[name] = ParameterEstimate(value, shown.get(name), declared[name].unit, stated=declared[name].stated)
        else:
            found[name] = ParameterEstimate(bound, None, declared[name].unit, at_bound=True)
    return found


def _bound_at(parameter: Parameter, value: Any, deviation: float | None) -> float | None:
    """The bound of a parameter that a fit has ended at; None where it lies within them."""
    if deviation is None or not isinstance(value, float):
        return None
    bounds = (b for b in (parameter.lower, parameter.upper) if np.isfinite(b))
    return next((b for b in bounds if abs(value - b) <= AT_BOUND * deviation), None)


def findings(
    problem: Problem,
    decision: Decision,
    known: int,
    removed: Sequence[float],
    without: Sequence[float],
    left: float,
    beside_laws: float,
) -> list[Finding]:
    """One finding per effect, the one first that costs most to leave out, in rows that were not fitted.

    Parameters
    ----------
    problem : Problem
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    removed : sequence of float
        Share of the refitted sum of squares that each effect removes, on fitted rows.
    without : sequence of float
        Normalised error on rows that were not fitted without each effect, and last with all.
    left, beside_laws : float
        Share of the mismatch that all effects leave, and what laws without a name leave beside them, where that is more
        than noise.
    """
    deviations = effect_deviations(decision.improved)
    # Effects that describe much of the same leave little for each beside the others.
    together = min(max(1.0 - decision.fitted.cost / max(decision.base.cost, 1e-300), 0.0), 1.0)
    common = {} if len(removed) < 2 else {"share_together": together}
    result = []
    effects = decision.improved.model.effects[known : len(decision.fitted.model.effects)]
    named = {e.identifier for e in effects}
    strongest = int(np.argmax(removed)) if len(removed) else 0
    views = problem.situations(decision.fitted.model)
    for i, effect in enumerate(effects):
        ranked = decision.rivals[i]
        comparison = Comparison(
            members_of(
                ranked,
                decision.without[i],
                named,
                constant=problem.kind.constant_beside(problem) or problem.own_zeros,
                same=[law.identifier for law in same_in_place(effect, views.of)],
            ),
            float(removed[i]),
            beside_laws if effect.identifier in decision.certain else left,
            gain_of(decision, i),
            i == strongest,
            linear=effect.imitates_linear_dynamics,
            experiments=different_inputs(problem),
            rows=len(decision.fitted.residual),
        )
        names, unlisted = weights(comparison)
        own = next((w for name, w in names if name == effect.identifier), 0.0)
        others = [*((name, w) for name, w in names if name != effect.identifier), (UNLISTED, unlisted)]
        evidence = {"share": float(removed[i]), **common, **_evidence(problem, decision, i, effect, without)}
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
                _separating(problem, effect, others),
                comparison,
            )
        )
    return sorted(result, key=lambda f: (-f.evidence["nrmse_without"], -f.evidence["share"]))


def _separating(problem: Problem, effect: Effect, others: Sequence[tuple[str, float]]) -> str | None:
    """What to record to tell an effect from those that it may be, too."""
    return advice(
        effect.separated_by,
        [known_effects()[n].separated_by for n, w in others if n != UNLISTED and w > LEAST_RIVAL],
        driven=any(np.any(e.signal) for e in problem.experiments),
        filmed=any(e.acquisition.sensor == "camera" for e in problem.experiments),
    )


def _evidence(
    problem: Problem, decision: Decision, index: int, effect: Effect, without: Sequence[float]
) -> dict[str, Any]:
    """What diagnosis.json says for one of the effects found, but for the shares that it removes."""
    ranked, other = decision.rivals[index], decision.without[index]
    gained = float(other.criterion_beyond(ranked[0].fitted) - ranked[0].penalty)
    runner = ranked[1] if len(ranked) > 1 else None
    if runner is not None and runner.beyond(ranked[0]) >= gained:
        runner = None  # what is worse than nothing is no next best
    return {
        "validation_gain": 1.0 - (without[-1] / without[index]) ** 2 if without[index] > 0.0 else None,
        "nrmse_without": without[index],
        "false_alarm_probability": p_value(problem, other, decision.fitted, effect.identifier),
        "delta_bic": gained,
        "next_best": None if runner is None else runner.identifier,
        "delta_bic_to_next_best": None if runner is None else float(runner.beyond(ranked[0])),
    }


def gain_of(decision: Decision, index: int) -> float:
    """Mismatch that one of the effects found removes beside the others, in variances of what they leave."""
    fitted = decision.fitted
    variance = fitted.cost / max(len(fitted.residual) - len(fitted.packing.names), 1)
    return max(decision.without[index].cost - fitted.cost, 0.0) / max(variance, 1e-300)


def as_simulated(found: Sequence[Finding], decision: Decision, known: int) -> list[Finding]:
    """Findings as the improved simulation of another decision holds them: with its values, or not at all.

    Parameters
    ----------
    found : sequence of Finding
    decision : Decision
    known : int
        How many of the model's effects the nominal simulation holds already.
    """
    count = len(decision.fitted.model.effects)
    pairs = zip(decision.improved.model.effects, effect_deviations(decision.improved), strict=True)
    held = {effect.identifier: parameters_of(effect, row) for effect, row in list(pairs)[known:count]}
    return [
        replace(f, parameters=held[f.identifier]) if f.identifier in held else replace(f, simulated=False)
        for f in found
    ]


def different_inputs(problem: Problem) -> int:
    """How many of the recordings are experiments of their own: a repetition of an input says nothing new of a law."""
    kinds: list[Array] = []
    for run in problem.fitted_runs:
        signal, known = problem.experiments[run].signal, False
        for other in kinds:
            rows = min(len(signal), len(other))
            size = float(np.linalg.norm(signal[:rows]) + np.linalg.norm(other[:rows]))
            known |= float(np.linalg.norm(signal[:rows] - other[:rows])) <= SAME_INPUT * size
        if not known:
            kinds.append(signal)
    return max(len(kinds), 1)


def learned_parts(decision: Decision) -> list[LearnedPart]:
    """The laws without a name that the improved model holds behind the effects that are named."""
    result = []
    before, total = decision.fitted.cost, max(decision.base.cost, 1e-300)
    # What is only said of a law is no part of the work that the effort bounds.
    uncounted = replace(decision.improved.problem, work=Work())
    seen = visited(uncounted, decision.improved) if decision.laws else {}
    for learned in decision.laws:
        law = learned.law
        result.append(
            LearnedPart(
                law.identifier,
                law.place,
                law.title,
                str(law.values["variables"]),
                law.knots.tolist(),
                law.heights.tolist(),
                learned.deviations.tolist(),
                law.knot_unit,
                law.unit,
                learned.log_evidence - learned.without,
                min(max((before - learned.fitted.cost) / total, 0.0), 1.0),
                visited=_middle(seen[over_of(law)]),
            )
        )
        before = learned.fitted.cost
    return result


def _middle(values: Array) -> tuple[float, float]:
    """Where the middle 98 % of some values lie."""
    low, high = np.percentile(values, [1.0, 99.0])
    return float(low), float(high)


def recognised(recognition: Recognition) -> Finding:
    """Finding of a noise-like effect, as if it were alone; see :func:`beside_others`."""
    effect = recognition.effect
    return Finding(
        effect.identifier,
        effect.place,
        effect.title,
        effect.equation,
        effect.reference,
        parameters_of(effect, recognition.standard_deviations),
        {"share": 0.0, "validation_gain": None, "false_alarm_probability": recognition.false_alarm_probability},
        certain=effect.shows_in_values or recognition.stands_out,
    )


def beside_others(noise: Sequence[Finding], motion: Sequence[Finding]) -> list[Finding]:
    """Findings of noise-like effects with their weights beside what else is named.

    What the residual shows may be the shadow of another effect. What the recorded values themselves show, such as
    repeated frames, is certain, and so are single rows far beyond all that the motion leaves.
    """
    result = []
    linear = any(known_effects()[finding.identifier].linear_dynamics for finding in motion)
    for finding in noise:
        if finding.certain:
            result.append(finding)
            continue
        alone = len(noise) == 1 and not motion
        own = (Member(finding.identifier, 0.0, 0.0),)
        comparison = Comparison(own, 0.0, 0.0, strongest=alone, linear=linear, noise=True)
        ((_, weight),), unlisted = weights(comparison)
        result.append(replace(finding, weight=weight, alternatives=[(UNLISTED, unlisted)], comparison=comparison))
    return result


def verdict_of(found: Sequence[Finding], learned: bool, structured: bool, *, carries_over: bool = True) -> str:
    """One of the four verdicts.

    A mismatch is explained where what has a name leaves nothing but noise, and that all of it has its name is likelier
    than that something of it is physics outside the catalogue, which only acts like it. Beside effects on the motion
    one on the noise says how that looks, and takes nothing from them. Rows that were not fitted choose no name, but
    where they are left larger than the noise something is left out there.

    Parameters
    ----------
    found : sequence of Finding
    learned : bool
        Whether a law without a name is modelled.
    structured : bool
        Whether what has a name leaves more than noise.
    carries_over : bool
        Whether rows that were not fitted are left about as small as the noise in those that were.
    """
    structured |= not carries_over
    if not found and not learned:
        return "unexplained" if structured else "adequate"
    motion = [finding for finding in found if not known_effects()[finding.identifier].noise_like]
    named = prod(finding.named for finding in motion or found)
    return "partly-explained" if structured or named < HEADLINE_WEIGHT else "explained"
