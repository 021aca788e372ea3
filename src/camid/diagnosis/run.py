"""One diagnosis from recordings and a nominal model: detect → locate → screen → fit → decide → report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis import mismatch_location
from camid.diagnosis.detection_limits import undetectable
from camid.diagnosis.diagnosis import Diagnosis, Finding, NormalisedErrors
from camid.diagnosis.effect_selection import Decision, Searches, select_effects
from camid.diagnosis.effect_signals import effect_signals
from camid.diagnosis.evidence import (
    coefficients_of,
    errors,
    errors_without,
    removed_shares,
    signals_of,
    tests_of,
)
from camid.diagnosis.explanation import explained
from camid.diagnosis.formula.account import with_words
from camid.diagnosis.held_out import borne_out
from camid.diagnosis.hypothesis_fit import ALL_STEPS
from camid.diagnosis.improved_simulation import Deviations, improved_simulation, remainder_of
from camid.diagnosis.laws_alone import with_laws
from camid.diagnosis.learned_laws import with_learned_laws
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.noise_metric import in_least_squares, in_noise_metric
from camid.diagnosis.noise_recognition import recognised_noise, spoiled_rows, uneven_spread
from camid.diagnosis.remaining_hypotheses import conditions_of, remaining
from camid.diagnosis.residual_structure import STRUCTURE_P_VALUE, reasons_for_structure, share_left
from camid.diagnosis.screening import ScreenedEffect, screen, try_own_effects
from camid.diagnosis.simplest_effects import simplest
from camid.diagnosis.verdict import as_simulated, beside_others, findings, verdict_of
from camid.diagnosis.watch import LAWS, Watch
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, effect_deviations, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation

Array = NDArray[np.float64]
# A residual up to this many times what an earlier diagnosis left unexplained is the same.
KNOWN_REMAINDER = 1.1
# Remainder, as a share of the output's standard deviation, from which a model explains nothing.
LARGEST_REMAINDER = 0.5
# Fits of the final model at most, and the fall of its sum of squares, as a share, that is none.
MOST_FINAL_FITS = 4
SETTLED = 1e-3
# Chance of a place's test below which the re-estimated plant may be bent by what is missing.
SUSPECT_P_VALUE = 1e-2


@dataclass(frozen=True)
class Residue:
    """What a decision leaves of the residual, and what it says.

    Attributes
    ----------
    places : list of PlaceTest
    reasons : list of str
        Tests that say that it is more than noise.
    findings : list of Finding
        Effects on the noise.
    noise_effects : list of (Effect, dict)
        The same, and those declared already, as the improved simulation declares them.
    """

    places: list[mismatch_location.PlaceTest]
    reasons: list[str]
    findings: list[Finding]
    noise_effects: list[tuple[Effect, Deviations]]


@dataclass(frozen=True)
class Setting:
    """What a diagnosis starts from.

    Attributes
    ----------
    believed : Simulation
    whole, problem : Problem
        With and without the rows that say nothing of the motion.
    nominal, simulated, start : Model
        As the simulation says; without effects on the noise and with the initial states that suit it, as ``simulate``
        runs it; and the same with the offset that suits it where none is declared.
    base : Fitted
        The nominal structure re-estimated.
    screened : list of ScreenedEffect
        Of the base.
    validation, judging : sequence of ndarray of bool
        Rows of each recording that are not fitted, and those of them that say something of the motion.
    chosen : bool
        Whether the tool chose those rows.
    searches : Searches
        What is found beside each set of effects.
    settled : bool
        Whether an earlier diagnosis has left as much unexplained as the simulation leaves now.
    """

    believed: Simulation
    whole: Problem
    problem: Problem
    nominal: Model
    simulated: Model
    start: Model
    base: Fitted
    screened: list[ScreenedEffect]
    validation: Sequence[NDArray[np.bool_]]
    judging: Sequence[NDArray[np.bool_]]
    chosen: bool
    searches: Searches
    settled: bool

    @property
    def known(self) -> int:
        """How many effects on the motion the nominal simulation holds already."""
        return len(self.start.effects)


def investigate(
    believed: Simulation,
    problem: Problem,
    nominal: Model,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    watch: Watch,
) -> Diagnosis:
    """Diagnose.

    Parameters
    ----------
    believed : Simulation
    problem : Problem
        ``used`` marks the rows that may be fitted.
    nominal : Model
        As the simulation says, with the effects that it declares.
    validation : sequence of ndarray of bool
        Rows of each recording that judge.
    chosen : bool
        Whether the tool chose those rows.
    watch : Watch

    Raises
    ------
    ValueError
        If the simulation diverges whatever its coefficients.
    """
    setting = _prepared(believed, problem, nominal, validation, chosen, watch)
    problem, base = setting.problem, setting.base
    before = mismatch_location.places(problem, base)
    selected = Decision(base, base)
    if not setting.settled:
        # Coefficients that leave nothing but noise are not bent, and no fit has to start from the nominal ones.
        start = setting.start if not setting.known and _leaves_structure(setting, before) else None
        selected = select_effects(problem, base, setting.screened, watch, start, setting.searches)
    decision, residue = _simplified(setting, selected, before, watch)
    if selected.interrupted and not decision.laws and residue.reasons:
        # What looked like an inexact law is none that can be learned, and names are all that is left to look for.
        selected = select_effects(problem, base, watch=watch, searches=setting.searches, begun=selected)
        decision, residue = _simplified(setting, selected, before, watch)
    return _diagnosis(setting, decision, before, residue, watch)


def _prepared(
    believed: Simulation,
    whole: Problem,
    nominal: Model,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    watch: Watch,
) -> Setting:
    """The plant re-estimated, rows left out that say nothing of the motion, and the catalogue screened."""
    watch.say("re-estimating the plant's coefficients")
    known = tuple(e for e in nominal.effects if not e.noise_like)
    start = whole.with_initial_states(replace(nominal, effects=known))
    base = whole.kind.refit(whole, start)
    if not np.all(np.isfinite(base.residual)):
        raise ValueError("the simulation diverges, whatever its coefficients")
    # Rows that say nothing of the motion (repeated frames, outliers) are neither fitted nor do they judge.
    spoiled = spoiled_rows(
        whole.with_used([e.used | v for e, v in zip(whole.experiments, validation, strict=True)]), base
    )
    problem, base = _without_spoiled(whole, base, start, spoiled)
    judging = [rows & ~s if (rows & ~s).any() else rows for rows, s in zip(validation, spoiled, strict=True)]
    watch.say("screening the catalogue")
    try_own_effects(problem, base)
    searches = Searches()
    screened = screen(problem, base, signatures=searches.signatures)
    settled = _settled(problem, base)
    simulated = _as_simulated(whole, nominal, start)
    return Setting(
        believed,
        whole,
        problem,
        nominal,
        simulated,
        start,
        base,
        screened,
        validation,
        judging,
        chosen,
        searches,
        settled,
    )


def _as_simulated(whole: Problem, nominal: Model, start: Model) -> Model:
    """The nominal model as ``simulate`` runs it, which takes an offset of which nothing is said for zero."""
    if not any(e.estimate_offset or e.estimate_bias for e in whole.experiments):
        return start
    known = whole.with_known_constants()
    effects = tuple(e for e in nominal.effects if not e.noise_like)
    return known.with_initial_states(replace(nominal, effects=effects, constants=known.kind.constants()))


def _leaves_structure(setting: Setting, places: list[mismatch_location.PlaceTest]) -> bool:
    """Whether the re-estimated plant may leave more than white noise."""
    base = setting.base
    if len(base.noise.whitening) > 1 or any(test.p_value < SUSPECT_P_VALUE for test in places):
        return True
    return bool(reasons_for_structure(setting.problem, base, places, setting.judging, set()))


def _simplified(
    setting: Setting, decision: Decision, before: list[mismatch_location.PlaceTest], watch: Watch
) -> tuple[Decision, Residue]:
    """The decision, and what its effects leave: with the fewest, and laws without a name, where that is structure."""
    problem = setting.problem
    if not setting.settled:
        watch.say("testing what is left")
        left = mismatch_location.places(problem, decision.fitted) if decision.rivals else before
        # What the laws leave of a structure is no noise, and a filter that whitens it no metric to refute them in.
        if not any(test.p_value < STRUCTURE_P_VALUE for test in left):
            decision = in_noise_metric(problem, decision, setting.known)
        decision = borne_out(problem, decision, setting.judging, setting.known, watch)
    if decision.rivals and not decision.fitted.weighted:
        again = fit(problem, decision.fitted.model, steps=ALL_STEPS)
        decision = replace(decision, fitted=min((again, decision.fitted), key=lambda each: each.cost))
    residue = _residue(setting, decision, decision.fitted, before)
    if setting.settled:
        declared: list[tuple[Effect, Deviations]] = [(e, {}) for e in setting.nominal.effects if e.noise_like]
        return decision, replace(residue, reasons=[], findings=[], noise_effects=declared)
    if not residue.reasons:
        decision = _converged(problem, decision, watch)
        return decision, _residue(setting, decision, decision.fitted, before)
    if decision.rivals:
        decision = simplest(problem, in_least_squares(problem, decision), setting.known, residue.places, watch)
        decision = _converged(problem, decision, watch)
    decision = with_learned_laws(problem, decision, setting.judging, setting.known, watch)
    return decision, _residue(setting, decision, decision.fitted, before)


def _converged(problem: Problem, decision: Decision, watch: Watch) -> Decision:
    """The decision with its model fitted until more fitting changes nothing: a search stops as soon as it can rank."""
    if not decision.rivals or decision.fitted.weighted:
        return decision
    return replace(decision, fitted=_fitted_to_the_end(problem, decision.fitted, watch))


def _fitted_to_the_end(problem: Problem, fitted: Fitted, watch: Watch) -> Fitted:
    for _ in range(MOST_FINAL_FITS):
        watch.take_stock(LAWS)
        if watch.no_time_for("fitting to the last digit"):
            break
        again = problem.kind.refit(problem, fitted.model)
        settled = again.cost > (1.0 - SETTLED) * fitted.cost
        fitted = min((again, fitted), key=lambda each: each.cost)
        if settled:
            break
    return fitted


def _residue(setting: Setting, decision: Decision, final: Fitted, before: list[mismatch_location.PlaceTest]) -> Residue:
    """Tests of what a model of a decision leaves, and what changes the noise."""
    problem, whole = setting.problem, setting.whole
    every = [e.used | v for e, v in zip(whole.experiments, setting.validation, strict=True)]
    found, noise_effects = recognised_noise(whole.with_used(every), problem, final, setting.nominal.effects)
    spread = uneven_spread(problem, final, [effect for effect, _ in noise_effects])
    known = spread is None and final is decision.base
    after = before if known else mismatch_location.places(problem, final, spread)
    reasons = reasons_for_structure(problem, final, after, setting.judging, {f.identifier for f in found})
    if reasons:  # what looks like jitter, outliers or colour may be the structure
        found = [f for f in found if known_effects()[f.identifier].shows_in_values]
        noise_effects = [e for e in noise_effects if e[0].identifier in {f.identifier for f in found}]
    return Residue(after, reasons, found, noise_effects)


def _diagnosis(
    setting: Setting,
    decision: Decision,
    before: list[mismatch_location.PlaceTest],
    residue: Residue,
    watch: Watch,
) -> Diagnosis:
    """What is said of a decision."""
    believed, problem, judging = setting.believed, setting.problem, setting.judging
    held, learned = with_laws(problem, decision, judging, setting.known, watch, setting.believed.units)
    base, final = decision.base, held.improved
    left, fits = _left(setting, replace(decision, laws=()), residue)
    beside_laws = left
    named = residue
    if decision.laws:
        residue = _residue(setting, decision, decision.improved, before)
        beside_laws, fits = _left(setting, decision, residue)
    if held is not decision:
        residue = _residue(setting, held, final, before)
        _, fits = _left(setting, held, residue)
    without = errors_without(problem, decision, judging)
    found = findings(problem, decision, setting.known, removed_shares(base, decision), without, left, beside_laws)
    if held is not decision:
        found = as_simulated(found, held, setting.known)
    found += beside_others(residue.findings, found)
    verdict = verdict_of(found, bool(learned), bool(named.reasons))
    location = _location(problem, base, found, learned, before, named)
    watch.say("working out what the recording could not have shown")
    names = {f.identifier for f in found} | {e.identifier for e in setting.nominal.effects}
    deviations: list[Deviations] = [*effect_deviations(final)[: len(final.model.effects) - len(learned)]]
    deviations += [{"values": part.standard_deviations} for part in learned]
    effects = [*zip(with_words(final.model.effects, learned), deviations, strict=True), *residue.noise_effects]
    first, *further = signals_of(problem, setting.start, base, final, setting.validation)
    remainder = remainder_of(bool(found or learned), bool(named.reasons), believed, problem, final, judging)
    conditions = conditions_of(problem, final)
    diagnosis = Diagnosis(
        verdict,
        "",
        location,
        found,
        fits,
        undetectable(problem, final, setting.screened, names),
        coefficients_of(problem, believed, setting.nominal, base, final),
        tests_of(problem, base, final, before, residue.places),
        first,
        improved_simulation(believed, problem, final, effects, remainder),
        learned=learned,
        structured=bool(residue.reasons),
        rows_fitted=int(sum(e.used.sum() for e in setting.whole.experiments)),
        period=problem.acquisition.period,
        residual_of=problem.kind.residual_of,
        known_remainder=problem.remainder if setting.settled else None,
        further_signals=further,
        hypotheses=remaining(believed, problem, decision, found, conditions),
        conditions=conditions,
        effect_signals=effect_signals(
            problem, final, [*(f.identifier for f in found), *(p.identifier for p in learned)]
        ),
        refitted=problem.kind.written_back(believed, problem.structure, base),
    )
    return replace(diagnosis, explanation=explained(diagnosis))


def _left(setting: Setting, decision: Decision, residue: Residue) -> tuple[float, NormalisedErrors]:
    """Share of the mismatch that a decision leaves, where that is more than noise, and its errors."""
    problem, judging, chosen = setting.problem, setting.judging, setting.chosen
    fits = errors(problem, setting.simulated, decision, judging, chosen, [])
    left = share_left(decision.base, decision.improved, residue.places, residue.reasons, fits)
    if residue.reasons:
        fits = errors(problem, setting.simulated, decision, judging, chosen, residue.places)
    return left, fits


def _location(
    problem: Problem,
    base: Fitted,
    found: list[Finding],
    learned: list[LearnedPart],
    before: list[mismatch_location.PlaceTest],
    residue: Residue,
) -> mismatch_location.Location:
    """Where the mismatch sits: at the strongest effect or the law in its place, or where the tests say it is."""
    if found:
        shares = mismatch_location.shares_of(found, mismatch_location.shares(residue.places), learned)
        place = found[0].place if found[0].simulated or not learned else learned[0].place
        return mismatch_location.locate(problem, base, place, shares)
    shares = mismatch_location.shares(before)
    if not residue.reasons:
        return mismatch_location.locate(problem, base, None, shares)
    strongest = max(shares, key=lambda place: shares[place])
    return mismatch_location.locate(problem, base, "noise" if residue.reasons == ["variance"] else strongest, shares)


def _without_spoiled(
    problem: Problem, base: Fitted, start: Model, spoiled: Sequence[NDArray[np.bool_]]
) -> tuple[Problem, Fitted]:
    """The problem without spoiled rows, if there are any among those that are fitted, and its base."""
    if not any((e.used & s).any() for e, s in zip(problem.experiments, spoiled, strict=True)):
        return problem, base
    problem = problem.with_used([e.used & ~s for e, s in zip(problem.experiments, spoiled, strict=True)])
    return problem, problem.kind.refit(problem, problem.with_initial_states(start))


def _settled(problem: Problem, base: Fitted) -> bool:
    """Whether an earlier diagnosis has left as much unexplained as the simulation leaves now.

    A remainder of the size of the output itself is not the remainder of a model.
    """
    if problem.remainder is None or problem.remainder > LARGEST_REMAINDER * problem.output_spread:
        return False
    return bool(np.sqrt(base.cost / len(base.residual)) <= KNOWN_REMAINDER * problem.remainder)
