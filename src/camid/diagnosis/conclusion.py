"""From a decision to the diagnosis: names and laws with their weights, verdict, place and improved simulation."""

from __future__ import annotations

from dataclasses import replace

from camid.diagnosis.detection_limits import undetectable
from camid.diagnosis.diagnosis import Coefficient, Diagnosis
from camid.diagnosis.effect_signals import effect_signals
from camid.diagnosis.evidence import coefficients_of, errors_without, removed_shares, signals_of, tests_of
from camid.diagnosis.explanation import explained, within_sentence
from camid.diagnosis.finding import Finding
from camid.diagnosis.improved_simulation import Deviations, improved_simulation, remainder_of
from camid.diagnosis.laws.formula.account import with_words
from camid.diagnosis.laws.laws_alone import with_laws
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.remaining_hypotheses import conditions_of, remaining
from camid.diagnosis.residual import mismatch_location
from camid.diagnosis.residue import Residue, left_by, residue_of
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.setting import Setting
from camid.diagnosis.swinging_coefficient import sits_at
from camid.diagnosis.time_unit import said_of_time_unit
from camid.diagnosis.verdict import as_simulated, beside_others, findings, verdict_of
from camid.diagnosis.watch import Watch
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.fitting.covariance import effect_deviations
from camid.fitting.fit import Fitted
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation


def concluded(
    setting: Setting,
    decision: Decision,
    before: list[mismatch_location.PlaceTest],
    residue: Residue,
    watch: Watch,
) -> Diagnosis:
    """What is said of a decision, with formulas for its laws or laws in the place of its names.

    Parameters
    ----------
    setting : Setting
    decision : Decision
    before : list of PlaceTest
        Of what the re-estimated plant leaves.
    residue : Residue
        Of what the decision's names leave.
    watch : Watch
    """
    believed, problem, judging = setting.believed, setting.problem, setting.judging
    held, learned = with_laws(problem, decision, judging, setting.known, watch, setting.believed.units)
    base, final = decision.base, held.improved
    left, fits = left_by(setting, replace(decision, laws=()), residue)
    beside_laws, named = left, residue
    if decision.laws:
        residue = residue_of(setting, decision.improved)
        beside_laws, fits = left_by(setting, decision, residue)
    if held is not decision:
        residue = residue_of(setting, final)
        _, fits = left_by(setting, held, residue)
    without = errors_without(problem, decision, judging)
    found = findings(problem, decision, setting.known, removed_shares(base, decision), without, left, beside_laws)
    if held is not decision:
        found = as_simulated(found, held, setting.known)
    found += beside_others(residue.findings, found)
    carried = setting.settled or fits.carries_over  # beyond a declared remainder nothing is looked for
    verdict = verdict_of(found, bool(learned), bool(named.reasons or residue.reasons), carries_over=carried)
    location = _location(problem, base, found, learned, before, named)
    watch.say("working out what the recording could not have shown")
    names = {f.identifier for f in found} | {e.identifier for e in setting.nominal.effects}
    effects = [*_with_deviations(final, learned), *residue.noise_effects]
    first, *further = signals_of(problem, setting.in_place, base, final, setting.validation)
    remainder = remainder_of(bool(found or learned), bool(residue.reasons), believed, problem, final, judging)
    conditions = conditions_of(problem, final)
    coefficients = coefficients_of(problem, believed, setting.nominal, base, final)
    diagnosis = Diagnosis(
        verdict,
        "",
        location,
        found,
        fits,
        undetectable(problem, final, setting.screened, names),
        coefficients,
        tests_of(problem, base, final, before, residue.places, residue.swing),
        first,
        improved_simulation(believed, problem, final, effects, remainder),
        learned=learned,
        structured=bool(residue.reasons),
        swing=residue.shown_swing,
        rows_fitted=int(sum(e.used.sum() for e in problem.experiments)),
        period=problem.acquisition.period,
        residual_of=problem.kind.residual_of,
        known_remainder=problem.remainder if setting.settled else None,
        further_signals=further,
        hypotheses=remaining(believed, problem, decision, found, conditions),
        conditions=conditions,
        effect_signals=effect_signals(problem, final, [f.identifier for f in found] + [p.identifier for p in learned]),
        refitted=problem.kind.written_back(believed, problem.structure, base),
        warnings=[*_left_out(setting, found), *_of_time(believed, coefficients), *_of_laws(final)],
    )
    return replace(diagnosis, explanation=explained(diagnosis))


def _with_deviations(final: Fitted, learned: list[LearnedPart]) -> list[tuple[Effect, Deviations]]:
    """Effects and laws of the improved model, with the standard deviations of their numbers."""
    deviations: list[Deviations] = [*effect_deviations(final)[: len(final.model.effects) - len(learned)]]
    deviations += [{"values": part.standard_deviations} for part in learned]
    return [*zip(with_words(final.model.effects, learned), deviations, strict=True)]


def _of_time(believed: Simulation, coefficients: list[Coefficient]) -> list[str]:
    """That times seem to be in a unit that is not declared."""
    declared = believed.reading.time.unit is not None or believed.reading.period is not None
    return said_of_time_unit(coefficients, believed.time_column, declared=declared)


def _of_laws(final: Fitted) -> list[str]:
    """What has to be known of the coefficients beside the effects that were found."""
    said = (effect.said_of_coefficients() for effect in final.model.effects)
    return [sentence for sentence in said if sentence is not None]


def _left_out(setting: Setting, found: list[Finding]) -> list[str]:
    """That readings are left out which look like an effect on the noise that has neither been named nor declared."""
    known = {f.identifier for f in found} | {e.identifier for e in setting.nominal.effects}
    sentences = []
    for identifier, count in sorted(setting.spoiled.items()):
        if count and identifier not in known:
            looks = within_sentence(known_effects()[identifier].title)
            sentences.append(
                f"{count} of the readings may be {looks}, and count neither in the fit nor in what judges it; "
                f"that does not suffice to name {looks}"
            )
    return sentences


def _location(
    problem: Problem,
    base: Fitted,
    found: list[Finding],
    learned: list[LearnedPart],
    before: list[mismatch_location.PlaceTest],
    residue: Residue,
) -> mismatch_location.Location:
    """Where the mismatch sits: where the effects, or the law in their place, have most of it, or where the tests say.

    Physics outside the catalogue that the effects only act like may sit anywhere: its share alone names no place.
    """
    if found:
        shares = mismatch_location.shares_of(found, mismatch_location.shares(residue.places), learned)
        names_noise = all(known_effects()[finding.identifier].noise_like for finding in found)
        place = max((f.place for f in found), key=lambda name: shares.get(name, 0.0))
        if learned and (names_noise or not found[0].simulated):
            place = learned[0].sits_at
        return mismatch_location.locate(problem, base, place, shares)
    shares = mismatch_location.shares(before)
    if not residue.reasons:
        return mismatch_location.locate(problem, base, None, shares)
    if learned:
        # What no law carries sits where the tests say.
        carried = min(sum(part.share for part in learned), 1.0)
        shares = {place: (1.0 - carried) * share for place, share in shares.items()}
        for part in learned:
            shares[part.sits_at] = shares.get(part.sits_at, 0.0) + part.share
        return mismatch_location.locate(problem, base, max(shares, key=lambda name: shares[name]), shares)
    if residue.shown_swing is not None:
        return mismatch_location.locate(problem, base, sits_at(residue.shown_swing), shares)
    strongest = max(shares, key=lambda place: shares[place])
    return mismatch_location.locate(problem, base, "noise" if residue.reasons == ["variance"] else strongest, shares)
