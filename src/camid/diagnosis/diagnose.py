"""One diagnosis from recordings and a nominal model: detect → locate → screen → fit → decide → report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.chain import Acquisition
from camid.diagnosis import locate as location_step
from camid.diagnosis.decide import ALL_STEPS, FALSE_ALARM, MOST_EFFECTS, Decision, decide, searched
from camid.diagnosis.fit import Fitted, at_best_start, fit, refit
from camid.diagnosis.horizon import fit_growing
from camid.diagnosis.limits import undetectable
from camid.diagnosis.parsimony import simplest
from camid.diagnosis.problem import Model, Problem
from camid.diagnosis.recognise import noise_findings, spoiled_rows
from camid.diagnosis.remainder import reasons_for_structure, unlisted_weight
from camid.diagnosis.result import Coefficient, Finding, Fit, Location, Signals, Test, Undetectable
from camid.diagnosis.screen import screen
from camid.diagnosis.verdict import effect_deviations, explanation, findings, verdict_of
from camid.physics.effect import Effect

Array = NDArray[np.float64]
# A residual up to so many times what an earlier diagnosis left unexplained is the same.
KNOWN_REMAINDER = 1.1
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
    fits = _errors(problem, start, decision, validation, chosen, [])
    unlisted = unlisted_weight(base, final, after, reasons, fits)
    removed = _shares(base, decision)
    if structured:
        fits = _errors(problem, start, decision, validation, chosen, after)
    gains = _gains(problem, decision, validation)
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
        _coefficients(problem, nominal, base, final),
        _tests(problem, base, final, before, after),
        _signals(problem, start, base, final, validation),
        decision,
        (*final.model.effects, *(e for e, _ in noise_effects)),
        [*effect_deviations(final), *(d for _, d in noise_effects)],
        problem.chain(final.model, 0).declared(),
        _free_covariance(problem, final),
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
    if not problem.is_linear(start):
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


def _settled(problem: Problem, base: Fitted) -> bool:
    """Whether an earlier diagnosis has left as much unexplained as the simulation leaves now."""
    if problem.remainder is None:
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


def _shares(base: Fitted, decision: Decision) -> list[float]:
    """Share of the refitted sum of squares that each effect removes."""
    total = max(base.cost, 1e-300)
    return [min(max((w.cost - decision.fitted.cost) / total, 0.0), 1.0) for w in decision.without]


def _simulated_error(problem: Problem, model: Model, rows: Sequence[NDArray[np.bool_]]) -> float:
    """Root of the mean square error on some rows of all recordings, over the spread of the recorded output there."""
    simulated = problem.simulate(model)
    errors = np.concatenate([(e.output - s)[r] for e, s, r in zip(problem.experiments, simulated, rows, strict=True)])
    recorded = np.concatenate([e.output[r] for e, r in zip(problem.experiments, rows, strict=True)])
    spread = float(np.std(recorded)) or 1.0
    return float(np.sqrt(np.mean(errors**2))) / spread


def _errors(
    problem: Problem,
    nominal: Model,
    decision: Decision,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    left: Sequence[location_step.PlaceTest],
) -> Fit:
    final = decision.fitted
    recorded = np.concatenate([e.output[r] for e, r in zip(problem.experiments, validation, strict=True)])
    structured = max((t.share for t in left), default=0.0)
    variance = final.cost * (1.0 - structured) / max(len(final.residual) - len(final.packing.names), 1)
    index = next(i for i, r in enumerate(validation) if r.any())
    times = problem.times[index][validation[index]]
    return Fit(
        _simulated_error(problem, nominal, validation),
        _simulated_error(problem, decision.base.model, validation),
        _simulated_error(problem, final.model, validation),
        float(np.sqrt(variance)) / (float(np.std(recorded)) or 1.0),
        (float(times[0]), float(times[-1])),
        chosen,
        _position_errors(problem, decision, validation) if problem.closed else None,
    )


def _position_errors(
    problem: Problem, decision: Decision, validation: Sequence[NDArray[np.bool_]]
) -> tuple[float, float]:
    """Errors of the position in a closed loop, with coefficients re-estimated and with the effects found."""
    recorded = np.concatenate([p[r] for p, r in zip(problem.positions, validation, strict=True)])
    errors = []
    for model in (decision.base.model, decision.fitted.model):
        moved = np.concatenate([m[0][r] for m, r in zip(problem.motion(model), validation, strict=True)])
        errors.append(float(np.sqrt(np.mean((recorded - moved) ** 2))) / (float(np.std(recorded)) or 1.0))
    return errors[0], errors[1]


def _gains(problem: Problem, decision: Decision, validation: Sequence[NDArray[np.bool_]]) -> list[float | None]:
    """Share of the mean square error on validation rows that each effect removes beside the others."""
    if not decision.without:
        return []
    final = _simulated_error(problem, decision.fitted.model, validation) ** 2
    gains: list[float | None] = []
    for without in decision.without:
        other = _simulated_error(problem, without.model, validation) ** 2
        gains.append(1.0 - final / other if other > 0.0 else None)
    return gains


def _free_covariance(problem: Problem, fitted: Fitted) -> Array:
    count = int(np.count_nonzero(problem.structure.free))
    return fitted.covariance[:count, :count]


def _coefficients(problem: Problem, nominal: Model, base: Fitted, final: Fitted) -> list[Coefficient]:
    """How far the coefficients had been bent by what was left out."""
    degree, order = problem.structure.degree, problem.structure.order
    names = [f"b{degree - i}" for i in range(degree + 1)] + [f"a{order - 1 - i}" for i in range(order)]
    free = np.flatnonzero(problem.structure.free)
    spreads = []
    for fitted in (base, final):
        deviation = np.zeros(len(names))
        deviation[free] = np.sqrt(np.diag(_free_covariance(problem, fitted)))
        spreads.append(deviation)
    return [
        Coefficient(
            name,
            float(nominal.coefficients[i]),
            float(base.model.coefficients[i]),
            float(spreads[0][i]),
            float(final.model.coefficients[i]),
            float(spreads[1][i]),
        )
        for i, name in enumerate(names)
    ]


def _tests(
    problem: Problem,
    base: Fitted,
    final: Fitted,
    before: Sequence[location_step.PlaceTest],
    after: Sequence[location_step.PlaceTest],
) -> list[Test]:
    white = problem.whiteness(base.residual, base.sensitivities)
    still = white if final is base else problem.whiteness(final.residual, final.sensitivities)
    rows = [Test("whiteness", "Does the residual depend on its own past?", white, still)]
    rows += [Test(b.place, b.question, b.p_value, a.p_value) for b, a in zip(before, after, strict=True)]
    return rows


def _signals(
    problem: Problem, nominal: Model, base: Fitted, final: Fitted, validation: Sequence[NDArray[np.bool_]]
) -> Signals:
    """What the report draws, of the first recording."""
    experiment, time = problem.experiments[0], problem.times[0]
    refitted = problem.simulate(base.model)[0]
    residual = experiment.output - refitted
    position, velocity = problem.motion(base.model)[0]
    return Signals(
        time,
        experiment.signal,
        experiment.output,
        problem.simulate(nominal)[0],
        refitted,
        refitted if final is base else problem.simulate(final.model)[0],
        position if problem.closed else refitted,
        velocity,
        _equivalent_input(problem, base, residual),
        ~validation[0],
    )


def _equivalent_input(problem: Problem, base: Fitted, residual: Array) -> Array:
    """Input that would have caused a residual, where the plant lets the camera see it (a Wiener filter)."""
    if problem.closed:  # the control is an input already
        return residual
    count, period = len(residual), problem.acquisition.period
    size = 2 * count
    angular = 2.0 * np.pi * np.fft.rfftfreq(size, period)
    acquisition = problem.acquisition
    exposure = 0.0 if acquisition.sensor == "instant" else float(acquisition.exposure or 0.0)
    lag = acquisition.latency + 0.5 * exposure
    response = problem.structure.plant(base.model.coefficients).frequency_response(np.maximum(angular, 1e-6 / period))
    response = response * np.sinc(angular * exposure / (2.0 * np.pi)) * np.exp(-1j * angular * lag)
    power = np.abs(response) ** 2
    power = np.where(np.isfinite(power), power, 0.0)
    regular = 1e-2 * float(np.max(power[1:], initial=0.0)) or 1.0
    spectrum = np.fft.rfft(residual, size) * np.conj(np.nan_to_num(response)) / (power + regular)
    return np.asarray(np.fft.irfft(spectrum, size)[:count])
