"""What is decided of what a simulation leaves: names, laws of their own, and what remains."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from camid.diagnosis.improved_simulation import Deviations
from camid.diagnosis.laws.laws_alone import log_evidence
from camid.diagnosis.laws.learned_laws import with_learned_laws
from camid.diagnosis.pruning.held_out import borne_out
from camid.diagnosis.pruning.noise_metric import in_least_squares, in_noise_metric
from camid.diagnosis.pruning.rounding import beyond_rounding
from camid.diagnosis.pruning.settled_effects import with_settled_laws, without_wandered
from camid.diagnosis.pruning.simplest_effects import simplest
from camid.diagnosis.pruning.weak_effects import without_faded, without_weak
from camid.diagnosis.residual import mismatch_location
from camid.diagnosis.residual.residual_structure import STRUCTURE_P_VALUE, reasons_for_structure
from camid.diagnosis.residual.uneven_noise import relative_noise
from camid.diagnosis.residue import Residue, residue_of
from camid.diagnosis.search.beginnings_in_a_loop import Beginning, first_beginning
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.search.effect_selection import select_effects
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, implausible
from camid.diagnosis.search.settled_laws import in_least_minima
from camid.diagnosis.setting import Setting, over_noise
from camid.diagnosis.swinging_coefficient import swinging_coefficient
from camid.diagnosis.watch import LAWS, NAMES, OVERTIME, Watch
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.fitting.fit import Fitted, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

# Fits of the final model at most, and the fall of its sum of squares, as a share, that is none.
MOST_FINAL_FITS = 4
SETTLED = 1e-3
# Share of the work up to which a search leaves enough for another one.
SEARCH_AGAIN = 0.4
# How often a law of impossible values is replaced by another one that is then settled beside the others.
MOST_REPLACED = 1
# Chance of a place's test below which the re-estimated plant may be bent by what is missing.
SUSPECT_P_VALUE = 1e-2


def decided(
    setting: Setting, beginning: Beginning, watch: Watch
) -> tuple[Setting, Decision, list[mismatch_location.PlaceTest], Residue]:
    """What is decided of what a simulation leaves, from where the search begins, and what it rests on.

    Parameters
    ----------
    setting : Setting
    beginning : Beginning
    watch : Watch

    Returns
    -------
    Setting
        With rows that are weighed by their noise, where that is uneven.
    Decision, list of PlaceTest, Residue
        Tests of what the re-estimated plant leaves, and what the decision leaves.
    """
    before, selected = _searched(setting, beginning, watch)
    noise = None if setting.settled else relative_noise(setting.problem, selected.fitted)
    if noise is not None:
        watch.take_stock(SEARCH_AGAIN)
        if not watch.no_time_for("weighing the rows by their noise"):
            watch.say("searching again with rows weighed by their noise")
            setting = over_noise(setting, noise)
            before, selected = _searched(setting, first_beginning(setting.problem, setting.base), watch)
        watch.take_stock(NAMES)
    problem, base = setting.problem, setting.base
    decision, residue = _simplified(setting, selected, watch)
    coloured = any(known_effects()[f.identifier].colours_noise for f in residue.findings)
    if selected.interrupted and (residue.reasons or coloured) and _leaves_colour(decision):
        # What looked like an inexact law is none, or not all that is missing: names are left to look for.
        further = select_effects(problem, base, watch=watch, searches=setting.searches, beginning=Beginning(selected))
        if _names(further) != _names(selected):
            other, what_is_left = _simplified(setting, further, watch)
            if log_evidence(other) > log_evidence(decision):
                decision, residue = other, what_is_left
    return setting, decision, before, residue


def _searched(
    setting: Setting, beginning: Beginning, watch: Watch
) -> tuple[list[mismatch_location.PlaceTest], Decision]:
    """Tests of what the re-estimated plant leaves, and the effects that are called for."""
    problem, base = setting.problem, setting.base
    before = setting.places_of(base)
    if setting.settled:
        return before, Decision(base, base)
    # Coefficients that leave nothing but noise are not bent, and no fit has to start from the nominal ones.
    start = setting.start if not setting.known and _leaves_structure(setting, before) else None
    leaves_structure = partial(_effects_leave_structure, setting)
    return before, select_effects(
        problem,
        base,
        setting.screened if beginning.decision is None else None,  # what was screened was beside the base
        watch,
        start,
        setting.searches,
        beginning,
        leaves_structure,
    )


def _effects_leave_structure(setting: Setting, found: Decision) -> bool:
    """Whether the effects of a decision leave more than noise, or one of them only makes up for others' laws."""
    if residue_of(setting, found.fitted).reasons:
        return True
    if all(type(e).is_plausible is Effect.is_plausible for e in found.fitted.model.effects):
        return False
    settled = setting.problem.kind.refit(setting.problem, found.fitted.model)
    return bool(_wandered(setting, settled.model))


def _wandered(setting: Setting, model: Model) -> set[int]:
    """Which effects of a model have been stretched to values that are not possible, until they are something else."""
    return implausible(setting.problem, model) - set(range(setting.known))


def _leaves_colour(decision: Decision) -> bool:
    """Whether no law was learned, or what names and laws leave is more than white noise."""
    return not decision.laws or len(decision.improved.noise.whitening) > 1


def _names(decision: Decision) -> list[str]:
    """Of the effects that a decision has found."""
    return [effect.identifier for effect in decision.fitted.model.effects]


def _leaves_structure(setting: Setting, places: list[mismatch_location.PlaceTest]) -> bool:
    """Whether the re-estimated plant may leave more than white noise."""
    base = setting.base
    if len(base.noise.whitening) > 1 or any(test.p_value < SUSPECT_P_VALUE for test in places):
        return True
    swing = swinging_coefficient(setting.problem, base)
    return bool(reasons_for_structure(setting.problem, base, places, setting.judging, set(), swing))


def _simplified(
    setting: Setting,
    decision: Decision,
    watch: Watch,
    replaced: tuple[str, ...] = (),
) -> tuple[Decision, Residue]:
    """The decision, and what its effects leave: with the fewest, and laws without a name, where that is structure.

    ``replaced`` are effects that were stretched to impossible values before: what took the place of one that is again
    and again stays as it is, or two laws would turn into each other for ever.
    """
    problem = setting.problem
    if not setting.settled:
        watch.say("testing what is left")
        decision = without_weak(problem, decision, setting.known, watch)
        decision = beyond_rounding(problem, decision, setting.known, watch)
        left = setting.places_of(decision.fitted)
        # What the laws leave of a structure is no noise, and a filter that whitens it no metric to refute them in.
        if not any(test.p_value < STRUCTURE_P_VALUE for test in left):
            decision = in_noise_metric(problem, decision, setting.known)
        decision = borne_out(problem, decision, setting.judging, setting.known, watch)
    if decision.rivals and not decision.fitted.weighted:
        again = fit(problem, decision.fitted.model, steps=ALL_STEPS)
        decision = replace(decision, fitted=min((again, decision.fitted), key=lambda each: each.cost))
    residue = residue_of(setting, decision.fitted)
    if setting.settled:
        declared: list[tuple[Effect, Deviations]] = [(e, {}) for e in setting.nominal.effects if e.noise_like]
        return decision, replace(residue, reasons=[], findings=[], noise_effects=declared)
    if decision.rivals:
        if residue.reasons:
            decision = in_least_squares(problem, decision)
        # Laws that are not settled leave structure that no learned law carries.
        settled = _settled(setting, decision, watch, structured=bool(residue.reasons))
        if settled is not decision:
            decision, residue = settled, residue_of(setting, settled.fitted)
        # Of white noise nothing is a correction: other rows may show a value that is not exact, and no law.
        if set(residue.reasons) - {"validation"}:
            decision = simplest(problem, decision, setting.known, residue.places, watch)
        decision = _converged(problem, decision, setting.known, watch)
        fewer, known = _with_fewer(setting, decision, watch, replaced)
        if fewer is not decision:
            if known is not None:
                return _simplified(setting, fewer, watch, known)
            decision, residue = fewer, residue_of(setting, fewer.fitted)
    if not residue.reasons:
        return decision, residue_of(setting, decision.fitted)
    decision = with_learned_laws(problem, decision, setting.judging, setting.known, watch)
    return decision, residue_of(setting, decision.fitted)


def _settled(setting: Setting, decision: Decision, watch: Watch, *, structured: bool) -> Decision:
    """The decision with its laws under the names that the others call for, and in the detail where it leaves structure.

    A few fits say whether a name with fewer numbers says as much, whatever was done until then.
    """
    if decision.fitted.weighted:
        return decision
    watch.take_stock(OVERTIME)
    detailed = structured and not watch.no_time_for("finer laws")
    return with_settled_laws(setting.problem, decision, setting.known, detailed=detailed)


def _with_fewer(
    setting: Setting, decision: Decision, watch: Watch, replaced: tuple[str, ...]
) -> tuple[Decision, tuple[str, ...] | None]:
    """The decision without an effect that is none, or with another in its place, and the effects that were replaced.

    None in the place of these where it was replaced too often, and nothing is to be made of its successor again.
    """
    wandered = _wandered(setting, decision.fitted.model)
    if not wandered:
        return without_faded(setting.problem, decision, setting.known, watch), replaced
    place = min(wandered)
    gone = decision.fitted.model.effects[place].identifier
    fewer = without_wandered(setting.problem, decision, setting.known, place - setting.known, watch)
    return fewer, None if replaced.count(gone) == MOST_REPLACED else (*replaced, gone)


def _converged(problem: Problem, decision: Decision, known: int, watch: Watch) -> Decision:
    """The decision with its model fitted until more fitting changes nothing: a search stops as soon as it can rank."""
    if not decision.rivals or decision.fitted.weighted:
        return decision
    fitted = decision.fitted
    watch.take_stock(LAWS)
    if not watch.no_time_for("other minima"):
        fitted = in_least_minima(problem, fitted, known)
    return replace(decision, fitted=_fitted_to_the_end(problem, fitted, watch))


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
