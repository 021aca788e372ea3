"""What a decision leaves of the residual, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

from camid.diagnosis.diagnosis import NormalisedErrors
from camid.diagnosis.evidence import errors
from camid.diagnosis.finding import Finding
from camid.diagnosis.improved_simulation import Deviations
from camid.diagnosis.residual.mismatch_location import PlaceTest, places
from camid.diagnosis.residual.noise_recognition import colours, recognised_noise
from camid.diagnosis.residual.residual_structure import reasons_for_structure, share_left
from camid.diagnosis.residual.uneven_noise import uneven_spread
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.setting import Setting
from camid.effects import known_effects
from camid.effects.base import Effect
from camid.fitting.fit import Fitted


@dataclass(frozen=True)
class Residue:
    """Tests of what is left, and effects on the noise.

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

    places: list[PlaceTest]
    reasons: list[str]
    findings: list[Finding]
    noise_effects: list[tuple[Effect, Deviations]]


def residue_of(setting: Setting, decision: Decision, final: Fitted, before: list[PlaceTest]) -> Residue:
    """Tests of what a model of a decision leaves, and what changes the noise.

    Parameters
    ----------
    setting : Setting
    decision : Decision
    final : Fitted
        The model: with the decision's names alone, or with its laws.
    before : list of PlaceTest
        Of what the re-estimated plant leaves.
    """
    problem, whole = setting.problem, setting.whole
    every = [e.used | v for e, v in zip(whole.experiments, setting.validation, strict=True)]
    found, noise_effects = recognised_noise(whole.with_used(every), problem, final, setting.nominal.effects)
    spread = uneven_spread(problem, final, [effect for effect, _ in noise_effects])
    known = spread is None and final is decision.base
    after = before if known else places(problem, final, spread)
    # A loop, and a lattice, give what is left a colour, too, which is no name and may still be that of a misfit.
    colour = colours(problem, final, {effect.identifier for effect in setting.nominal.effects})
    recognised = {f.identifier for f in found} | set(colour)
    reasons = reasons_for_structure(problem, final, after, setting.judging, recognised)
    if reasons:  # what looks like jitter, outliers or colour may be the structure
        found = [f for f in found if known_effects()[f.identifier].shows_in_values]
        noise_effects = [e for e in noise_effects if e[0].identifier in {f.identifier for f in found}]
    return Residue(after, reasons, found, noise_effects)


def left_by(setting: Setting, decision: Decision, residue: Residue) -> tuple[float, NormalisedErrors]:
    """Share of the mismatch that a decision leaves, where that is more than noise, and its errors."""
    problem, judging, chosen = setting.problem, setting.judging, setting.chosen
    nominal = (setting.simulated, setting.in_place)
    fits = errors(problem, nominal, decision, judging, chosen, [])
    left = share_left(decision.base, decision.improved, residue.places, residue.reasons, fits)
    if residue.reasons:
        fits = errors(problem, nominal, decision, judging, chosen, residue.places)
    return left, fits
