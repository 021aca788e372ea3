"""What a diagnosis starts from: the plant re-estimated, without rows that say nothing, and the catalogue screened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.noiseless import ask_for_noise
from camid.diagnosis.residual.mismatch_location import PlaceTest, places
from camid.diagnosis.residual.noise_recognition import spoiled_rows
from camid.diagnosis.search.decision import Searches
from camid.diagnosis.search.screening import ScreenedEffect, screen, try_own_effects
from camid.diagnosis.watch import Watch
from camid.engine.work import Work
from camid.fitting.fit import Fitted, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import misfit
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation

# A residual up to this many times what an earlier diagnosis left unexplained is the same.
KNOWN_REMAINDER = 1.1
# Remainder, as a share of the output's standard deviation, from which a model explains nothing.
LARGEST_REMAINDER = 0.5
# Fits of which the tests at every place are kept.
MOST_TESTED = 4
# Largest number of evaluations in a fit of the initial states of the simulation as given.
STATE_STEPS = 40


@dataclass(frozen=True)
class Setting:
    """What a diagnosis starts from.

    Attributes
    ----------
    believed : Simulation
    whole, problem : Problem
        With and without the rows that say nothing of the motion.
    nominal, simulated, in_place, start : Model
        As the simulation says; without effects on the noise and with the initial states that suit it best, as
        ``simulate`` runs it; the same with the offset that suits it where none is declared; and that with initial
        states that a fit can start from.
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
    spoiled : dict of str to int
        How many readings are left out because they look like an effect on the noise, by its identifier.
    tested : list of (Fitted, list of PlaceTest)
        Fits that were tested at every place, the last ones.
    """

    believed: Simulation
    whole: Problem
    problem: Problem
    nominal: Model
    simulated: Model
    in_place: Model
    start: Model
    base: Fitted
    screened: list[ScreenedEffect]
    validation: Sequence[NDArray[np.bool_]]
    judging: Sequence[NDArray[np.bool_]]
    chosen: bool
    searches: Searches
    settled: bool
    spoiled: dict[str, int]
    tested: list[tuple[Fitted, list[PlaceTest]]] = field(default_factory=list)

    @property
    def known(self) -> int:
        """How many effects on the motion the nominal simulation holds already."""
        return len(self.start.effects)

    def places_of(self, fitted: Fitted) -> list[PlaceTest]:
        """Tests of every place of what a model leaves, done once: a loop is simulated with each of many forces."""
        for known, tests in self.tested:
            if known is fitted:
                return tests
        tests = places(self.problem, fitted)
        self.tested[MOST_TESTED - 1 :] = []
        self.tested.insert(0, (fitted, tests))
        return tests


def prepared(
    believed: Simulation,
    whole: Problem,
    nominal: Model,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    watch: Watch,
) -> Setting:
    """The plant re-estimated, rows left out that say nothing of the motion, and the catalogue screened.

    Parameters
    ----------
    believed : Simulation
    whole : Problem
        ``used`` marks the rows that may be fitted.
    nominal : Model
        As the simulation says, with the effects that it declares.
    validation : sequence of ndarray of bool, shapes (N,)
        Rows of each recording that judge.
    chosen : bool
        Whether the tool chose those rows.
    watch : Watch

    Raises
    ------
    NoNoise
        If the simulation leaves less than it is accurate to.
    ValueError
        If the simulation diverges whatever its coefficients.
    """
    watch.say("re-estimating the plant's coefficients")
    known = tuple(e for e in nominal.effects if not e.noise_like)
    start = whole.with_initial_states(replace(nominal, effects=known))
    base = whole.kind.refit(whole, start)
    if not np.all(np.isfinite(base.residual)):
        raise ValueError("the simulation diverges, whatever its coefficients")
    ask_for_noise(whole, base)
    # Rows that say nothing of the motion (repeated frames, outliers) are neither fitted nor do they judge.
    suspect = spoiled_rows(
        whole.with_used([e.used | v for e, v in zip(whole.experiments, validation, strict=True)]), base
    )
    spoiled = [
        np.any([np.zeros(len(time), bool), *rows.values()], axis=0)
        for time, rows in zip(whole.times, suspect, strict=True)
    ]
    problem, base = _without_spoiled(whole, base, start, spoiled)
    judging = [rows & ~s if (rows & ~s).any() else rows for rows, s in zip(validation, spoiled, strict=True)]
    watch.say("screening the catalogue")
    try_own_effects(problem, base)
    searches = Searches()
    screened = screen(problem, base, signatures=searches.signatures)
    settled = _settled(problem, base)
    in_place = _in_best_state(whole, start)
    simulated = _as_simulated(whole, nominal, in_place)
    return Setting(
        believed,
        whole,
        problem,
        nominal,
        simulated,
        in_place,
        start,
        base,
        screened,
        validation,
        judging,
        chosen,
        searches,
        settled,
        {name: int(sum(each[name].sum() for each in suspect if name in each)) for rows in suspect for name in rows},
    )


def over_noise(setting: Setting, noise: tuple[NDArray[np.float64], ...]) -> Setting:
    """The same with rows that are compared over their noise.

    Parameters
    ----------
    setting : Setting
    noise : tuple of ndarray, shapes (N,)
        Relative standard deviation of the noise in each row of each recording.
    """
    problem = replace(setting.problem, relative_noise=noise)
    base, searches = fit(problem, setting.base.model), Searches()
    screened = screen(problem, base, signatures=searches.signatures)
    return replace(setting, problem=problem, base=base, screened=screened, searches=searches)


def _as_simulated(whole: Problem, nominal: Model, in_place: Model) -> Model:
    """The nominal model as ``simulate`` runs it, which takes an offset of which nothing is said for zero."""
    if not any(e.estimate_offset or e.estimate_bias for e in whole.experiments):
        return in_place
    known = whole.with_known_constants()
    effects = tuple(e for e in nominal.effects if not e.noise_like)
    given = replace(nominal, effects=effects, constants=known.kind.constants())
    return _in_best_state(known, known.with_initial_states(given))


def _in_best_state(problem: Problem, model: Model) -> Model:
    """The model with the initial states, and the offset and bias where nothing is said of them, that suit it best.

    What a fit starts from suits the linear part, or the first rows, and a motion that nothing damps never forgets it.
    """
    unknown = any(e.estimate_initial_state for e in problem.experiments)
    if not unknown or problem.kind.finds_initial_states(model):
        return model
    # What is only said of the simulation as given is no part of the work that the effort bounds.
    fixed = replace(problem, structure=problem.structure.all_fixed(), work=Work()).all_fixed()
    try:
        best = fit(fixed, model, steps=STATE_STEPS, fixed=len(model.effects)).model
    except (ValueError, ArithmeticError):
        return model
    return min((best, model), key=lambda each: misfit(problem, each))


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
