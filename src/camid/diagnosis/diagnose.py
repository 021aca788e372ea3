"""One diagnosis from recordings and a nominal model: detect → locate → screen → fit → decide → report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.diagnosis import locate as location_step
from camid.diagnosis.decide import ALL_STEPS, FALSE_ALARM, MOST_EFFECTS, Decision, decide, searched
from camid.diagnosis.evidence import (
    coefficients_of,
    errors,
    free_covariance,
    removed_shares,
    signals_of,
    tests_of,
    validation_gains,
)
from camid.diagnosis.limits import undetectable
from camid.diagnosis.parsimony import simplest
from camid.diagnosis.recognise import noise_findings, spoiled_rows
from camid.diagnosis.remainder import reasons_for_structure, unlisted_weight
from camid.diagnosis.result import Coefficient, Finding, Fit, Location, Signals, Test, Undetectable
from camid.diagnosis.screen import screen
from camid.diagnosis.verdict import effect_deviations, explanation, findings, verdict_of
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, fit
from camid.fitting.growing_horizon import fit_growing
from camid.fitting.problem import Model, Problem
from camid.fitting.refit import at_best_start, refit

Array = NDArray[np.float64]
# A residual up to so many times what an earlier diagnosis left unexplained is the same.
KNOWN_REMAINDER = 1.1
# Remainder, as a share of the output's standard deviation, from which a model explains nothing.
LARGEST_REMAINDER = 0.5
Progress = Callable[[str], None] | None


@dataclass(frozen=True)
class Outcome:
    """What a diagnosis found, before it is put into files.

    Attributes
    ----------
    verdict, explanation : str
    location : Location
    findings : list of Finding
    fit : Fit
    undetectable : list of Undetectable
    coefficients : list of Coefficient
    tests : list of Test
    signals : Signals
    decision : Decision
    effects : tuple of Effect
        Of the improved model, declarations and noise-like effects included.
    deviations : list of dict
        Standard deviations of their parameters.
    acquisition : Acquisition
        Corrected declaration.
    covariance : ndarray, shape (p, p)
        Of the free coefficients.
    left : float
        Root mean square of what the improved model leaves, on fitted or on validation rows: the larger.
    """

    verdict: str
    explanation: str
    location: Location
    findings: list[Finding]
    fit: Fit
    undetectable: list[Undetectable]
    coefficients: list[Coefficient]
    tests: list[Test]
    signals: Signals
    decision: Decision
    effects: tuple[Effect, ...]
    deviations: list[dict[str, float | None]]
    acquisition: Acquisition
    covariance: Array
    left: float


def investigate(
    problem: Problem,
    nominal: Model,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    progress: Progress = None,
) -> Outcome:
    """Diagnose.

    Parameters
    ----------
    problem : Problem
        ``used`` marks the rows that may be fitted.
    nominal : Model
        As the simulation says, with the effects that it declares.
    validation : sequence of ndarray of bool
        Rows of each recording that judge.
    chosen : bool
        Whether the tool chose those rows.
    progress : callable, optional
    """

    def say(sentence: str) -> None:
        if progress:
            progress(sentence)

    say("re-estimating the plant's coefficients")
    known = tuple(e for e in nominal.effects if not e.noise_like)
    start = at_best_start(problem, replace(nominal, effects=known))
    base = _base(problem, start, known)
    if not np.all(np.isfinite(base.residual)):
        raise ValueError("the simulation runs away, whatever its coefficients")
    whole = problem
    problem, base = _without_spoiled(problem, base, start, known)
    say("screening the catalogue")
    screened = screen(problem, base)
    settled = _settled(problem, base)
    decision = Decision(base, base)
    if not settled:
        decision = decide(problem, base, screened, validation, progress, start if not known else None)
    base = decision.base  # of another minimum, if one was found
    say("testing what is left")
    decision = decision if settled else _with_noise(problem, decision, len(known))
    before = location_step.places(problem, base)
    judged = _judged(problem, whole, base, decision, before, validation, nominal.effects)
    if settled:
        declared: list[tuple[Effect, dict[str, float | None]]] = [(e, {}) for e in nominal.effects if e.noise_like]
        judged = replace(judged, reasons=[], recognised=[], noise_effects=declared)
    if judged.reasons and len(decision.rivals) > 0:
        share = max((t.share for t in judged.after), default=0.0)
        decision = simplest(problem, _unweighted(problem, decision), len(known), share, progress)
        judged = _judged(problem, whole, base, decision, before, validation, nominal.effects)
    final, after, reasons = decision.fitted, judged.after, judged.reasons
    recognised, noise_effects, structured = judged.recognised, judged.noise_effects, bool(judged.reasons)
    fits = errors(problem, start, decision, validation, chosen, [])
    unlisted = unlisted_weight(base, final, after, reasons, fits)
    removed = removed_shares(base, decision)
    if structured:
        fits = errors(problem, start, decision, validation, chosen, after)
    gains = validation_gains(problem, decision, validation)
    found = findings(problem, decision, len(known), removed, gains, unlisted) + recognised
    verdict = verdict_of(bool(found), structured)
    strongest = max(before, key=lambda t: t.gain)
    elsewhere = "noise" if reasons == ["variance"] else strongest.place
    place = found[0].place if found else (elsewhere if structured else None)
    location = location_step.locate(problem, base, place, location_step.shares(before))
    say("working out what the recording could not have shown")
    names = {f.identifier for f in found} | {e.identifier for e in nominal.effects}
    unseen = undetectable(problem, final, screened, names)
    return Outcome(
        verdict,
        explanation(verdict, found, fits, location, problem.remainder if settled else None),
        location,
        found,
        fits,
        unseen,
        coefficients_of(problem, nominal, base, final),
        tests_of(problem, base, final, before, after),
        signals_of(problem, start, base, final, validation),
        decision,
        (*final.model.effects, *(e for e, _ in noise_effects)),
        [*effect_deviations(final), *(d for _, d in noise_effects)],
        problem.chain(final.model, 0).declared(),
        free_covariance(problem, final),
        _left(problem, final, validation),
    )


@dataclass(frozen=True)
class _Judged:
    """What is left behind a decision."""

    after: list[location_step.PlaceTest]
    reasons: list[str]
    recognised: list[Finding]
    noise_effects: list[tuple[Effect, dict[str, float | None]]]


def _judged(
    problem: Problem,
    whole: Problem,
    base: Fitted,
    decision: Decision,
    before: list[location_step.PlaceTest],
    validation: Sequence[NDArray[np.bool_]],
    nominal: Sequence[Effect],
) -> _Judged:
    """Tests of what is left, and what changes the noise."""
    final = decision.fitted
    after = before if final is base else location_step.places(problem, final)
    every = [e.used | v for e, v in zip(whole.experiments, validation, strict=True)]
    recognised, noise_effects = noise_findings(whole.with_used(every), problem, final, nominal)
    reasons = reasons_for_structure(problem, final, after, validation, {f.identifier for f in recognised})
    if reasons:  # what looks like jitter, outliers or colour may be the structure
        recognised = [f for f in recognised if f.identifier in {"quantisation", "dropped-frames"}]
        noise_effects = [e for e in noise_effects if e[0].identifier in {f.identifier for f in recognised}]
    return _Judged(after, reasons, recognised, noise_effects)


def _base(problem: Problem, start: Model, known: tuple[Effect, ...]) -> Fitted:
    """The nominal structure re-estimated, with the effects that it declares."""
    if not known:
        return refit(problem, start)
    if problem.is_winding(start) or not problem.is_linear(start):
        return fit_growing(problem, start)
    return fit(problem, start, steps=60)


def _without_spoiled(problem: Problem, base: Fitted, start: Model, known: tuple[Effect, ...]) -> tuple[Problem, Fitted]:
    """The problem without rows that say nothing of the motion (repeated frames, outliers), if there are any."""
    spoiled = spoiled_rows(problem, base)
    if not any(s.any() for s in spoiled):
        return problem, base
    problem = problem.with_used([e.used & ~s for e, s in zip(problem.experiments, spoiled, strict=True)])
    return problem, _base(problem, at_best_start(problem, start), known)


def _with_noise(problem: Problem, decision: Decision, known: int) -> Decision:
    """The decision's model fitted anew in the metric of its noise, if that is coloured, and without what it refutes."""
    from scipy.stats import chi2

    for _ in range(MOST_EFFECTS + 1):
        final = decision.fitted
        whitening = final.noise.whitening
        if len(whitening) == 1:
            return decision
        again = fit(problem, final.model, steps=15, whitening=whitening)
        cost = _whitened_cost(problem, again, whitening)
        refuted = None
        for i, effect in enumerate(again.model.effects[known:]):
            without = fit(problem, again.model.without(known + i), steps=15, whitening=whitening)
            ratio = len(again.residual) * float(np.log(_whitened_cost(problem, without, whitening) / cost))
            chance = float(chi2.sf(ratio, max(len(effect.numeric()), 1))) * searched(problem, effect.identifier)
            if chance >= FALSE_ALARM:
                refuted = i, without
        if refuted is None:
            return replace(decision, fitted=again)
        index, fitted = refuted
        decision = replace(
            decision,
            fitted=fitted,
            rivals=decision.rivals[:index] + decision.rivals[index + 1 :],
            without=[
                fit(problem, fitted.model.without(known + i), steps=15, whitening=whitening)
                for i in range(len(decision.without) - 1)
            ],
        )
        if not decision.rivals:
            return replace(decision, fitted=decision.base)
    return decision


def _left(problem: Problem, final: Fitted, validation: Sequence[NDArray[np.bool_]]) -> float:
    """Root mean square of what a model leaves, on fitted or on validation rows: the larger."""
    simulated = problem.simulate(final.model)
    held_out = np.concatenate(
        [(e.output - s)[r] for e, s, r in zip(problem.experiments, simulated, validation, strict=True)]
    )
    return float(np.sqrt(max(np.mean(final.residual**2), np.mean(held_out**2))))


def _settled(problem: Problem, base: Fitted) -> bool:
    """Whether an earlier diagnosis has left as much unexplained as the simulation leaves now.

    A remainder of the size of the output itself is no remainder of a model.
    """
    if problem.remainder is None or problem.remainder > LARGEST_REMAINDER * float(np.std(problem.output)):
        return False
    return bool(np.sqrt(base.cost / len(base.residual)) <= KNOWN_REMAINDER * problem.remainder)


def _unweighted(problem: Problem, decision: Decision) -> Decision:
    """The decision with the estimate of least squares.

    What the laws leave is no noise, and its spectrum no reason to trust some frequencies more than others: a filter
    that whitens it would give the weight to those at which the model is wrong by little because little happens there.
    """
    if not decision.fitted.weighted:
        return decision
    return replace(decision, fitted=fit(problem, decision.fitted.model, steps=ALL_STEPS))


def _whitened_cost(problem: Problem, fitted: Fitted, whitening: Array) -> float:
    innovations = problem.whitened(fitted.residual, whitening)
    return max(float(innovations @ innovations), 1e-300)
