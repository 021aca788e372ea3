"""What a decision leaves of the residual, and what it says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camid.diagnosis.evidence import errors
from camid.diagnosis.finding import Finding
from camid.diagnosis.improved_simulation import Deviations
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.pruning.rounding import is_rounding_alone
from camid.diagnosis.residual.mismatch_location import PlaceTest, places
from camid.diagnosis.residual.noise_recognition import colours, recognised_noise
from camid.diagnosis.residual.residual_structure import SWING, reasons_for_structure, share_left
from camid.diagnosis.residual.uneven_noise import uneven_spread
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.setting import Setting
from camid.diagnosis.swinging_coefficient import Swing, swinging_coefficient
from camid.diagnosis.verdict import recognised
from camid.effects.base import Effect
from camid.effects.recognition import Recognition
from camid.fitting.fit import Fitted


@dataclass(frozen=True)
class Residue:
    """Tests of what is left, and effects on the noise.

    Attributes
    ----------
    places : list of PlaceTest
    reasons : list of str
        Tests that say that it is more than noise.
    swing : Swing or None
        The coefficient that swings most clearly; one of the reasons where it is no chance.
    findings : list of Finding
        Effects on the noise.
    noise_effects : list of (Effect, dict)
        The same, and those declared already, as the improved simulation declares them.
    """

    places: list[PlaceTest]
    reasons: list[str]
    swing: Swing | None
    findings: list[Finding]
    noise_effects: list[tuple[Effect, Deviations]]

    @property
    def shown_swing(self) -> Swing | None:
        """The coefficient that swings, where that is no chance."""
        return self.swing if SWING in self.reasons else None


def residue_of(setting: Setting, final: Fitted) -> Residue:
    """Tests of what a model of a decision leaves, and what changes the noise.

    Parameters
    ----------
    setting : Setting
    final : Fitted
        The model: with the decision's names alone, or with its laws.
    """
    problem, whole = setting.problem, setting.whole
    every = [e.used | v for e, v in zip(whole.experiments, setting.validation, strict=True)]
    declared = [effect for effect in setting.nominal.effects if effect.noise_like]
    found = recognised_noise(whole.with_used(every), problem, final, setting.nominal.effects)
    spread = uneven_spread(problem, final, [*declared, *(r.effect for r in found)])
    after = setting.places_of(final) if spread is None else places(problem, final, spread)
    # A loop, and a lattice, give what is left a colour, too, which is no name and may still be that of a misfit.
    colour = colours(problem, final, {effect.identifier for effect in setting.nominal.effects})
    named = {r.effect.identifier for r in found} | set(colour)
    swing = swinging_coefficient(problem, final)
    reasons = reasons_for_structure(problem, final, after, setting.judging, named, swing)
    reasons = [] if reasons and is_rounding_alone(problem, final) else reasons
    if reasons:  # what looks like jitter, outliers or colour may be the structure
        found = [r for r in found if r.effect.shows_in_values or r.stands_out]
    return Residue(after, reasons, swing, [recognised(r) for r in found], _as_declared(declared, found))


def _as_declared(declared: Sequence[Effect], found: Sequence[Recognition]) -> list[tuple[Effect, Deviations]]:
    """Effects on the noise as the improved simulation declares them: those declared already, and those found."""
    unchanged: list[tuple[Effect, Deviations]] = [(effect, {}) for effect in declared]
    return [*unchanged, *((r.effect, dict(r.standard_deviations)) for r in found)]


def left_by(setting: Setting, decision: Decision, residue: Residue) -> tuple[float, NormalisedErrors]:
    """Share of the mismatch that a decision leaves, where that is more than noise, and its errors."""
    problem, judging, chosen = setting.problem, setting.judging, setting.chosen
    nominal = (setting.simulated, setting.in_place)
    fits = errors(problem, nominal, decision, judging, chosen, [])
    left = share_left(decision.base, decision.improved, residue.places, residue.reasons, fits)
    if residue.reasons:
        fits = errors(problem, nominal, decision, judging, chosen, residue.places)
    return left, fits
