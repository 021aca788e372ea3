"""One diagnosis from recordings and a nominal model: detect → locate → screen → fit → decide → report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.conclusion import concluded
from camid.diagnosis.decided import decided
from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.held_by_observer import Pulled, is_astray, undriven_error, with_observer
from camid.diagnosis.noiseless import NoNoise, said_of_noise, with_least_noise
from camid.diagnosis.search.beginnings_in_a_loop import Beginning, beginning_with, first_beginning
from camid.diagnosis.search.hypothesis_fit import takes_input_away
from camid.diagnosis.search.hypothesis_search import is_far_off
from camid.diagnosis.search.sharpened_starts import as_start_of
from camid.diagnosis.setting import Setting, prepared
from camid.diagnosis.watch import Watch
from camid.diagnosis.zeros_of_recordings import CountedFromOwn, with_own_zeros
from camid.effects.declared import effects_of
from camid.fitting.multiple_shooting import may_be_cut
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.identification.unknown_constants import integrates
from camid.side_by_side import with_a_copy
from camid.simulation.model import Simulation


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
    untouched = watch.state()
    try:
        return _of_readings(believed, problem, nominal, validation, chosen, watch)
    except NoNoise:
        noisy = with_least_noise(problem)
    watch.set(untouched)
    watch.count(noisy.work, len(noisy.output), len(noisy.fitted_runs))
    found = _of_readings(believed, noisy, nominal, validation, chosen, watch)
    return replace(found, warnings=[*found.warnings, said_of_noise()])


def _of_readings(
    believed: Simulation,
    problem: Problem,
    nominal: Model,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    watch: Watch,
) -> Diagnosis:
    """Diagnosis of readings as they are; :class:`NoNoise` is raised where they have none."""
    with with_a_copy(problem, nominal, watch):
        setting = prepared(believed, problem, nominal, validation, chosen, watch)
    held = with_observer(believed, setting.problem, nominal)
    pulled_problem = None if held is None else replace(held[1], work=setting.problem.work)
    with with_a_copy(setting.problem, pulled_problem, nominal, watch):
        beginning = first_beginning(setting.problem, setting.base, pulled_problem)
    beginning = _shown_by_one(setting, beginning, watch) or beginning
    counted = _counted_from_own_zeros(setting, watch)
    if counted is not None and counted.tells_all:
        return counted.taken(watch)
    pulled, told = _held(setting, watch) if beginning.runs_away else (None, None)
    if told is not None:
        return told
    with with_a_copy(setting.whole, setting.problem, nominal, watch):
        found = concluded(*decided(setting, beginning, watch), watch)
    if counted is not None and counted.is_likelier(found):
        return counted.taken(watch)
    if not is_astray(found):
        return found
    if not beginning.runs_away:
        pulled, told = _held(setting, watch)
    return told or (pulled.taken(watch) if pulled is not None and pulled.tells_more else found)


def _shown_by_one(setting: Setting, beginning: Beginning, watch: Watch) -> Beginning | None:
    """What a search begins with where one of several recordings shows alone what is missing; None where none does.

    A plant that integrates runs away from each recording on a way of its own until all that is missing is there.
    """
    whole = setting.whole
    apart = len(whole.fitted_runs) > 1 and may_be_cut(whole) and not setting.nominal.initial
    if beginning.decision is not None or not apart or not integrates(setting.believed):
        return None
    if not is_far_off(setting.problem, setting.base) or watch.no_time_for("what one recording shows alone"):
        return None
    watch.say("looking at the first recording alone")
    first = whole.fitted_runs[0]
    alone, rows = whole.alone(first), [setting.validation[first]]
    aside = watch.aside(alone.work, len(alone.output), 1)
    try:
        with with_a_copy(alone, setting.nominal, aside):
            own = prepared(setting.believed, alone, setting.nominal, rows, setting.chosen, aside)
            _, decision, _, residue = decided(own, first_beginning(own.problem, own.base), aside)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # it diverges alone
        return None
    return None if residue.reasons else beginning_with(setting.problem, setting.base, decision.fitted.model)


def _counted_from_own_zeros(setting: Setting, watch: Watch) -> CountedFromOwn | None:
    """Diagnosis with a zero of the sensor for each recording, where these explain much; None where they do not."""
    found = with_own_zeros(setting.problem, setting.base, setting.start)
    if found is None or watch.no_time_for("a zero of the sensor for each recording"):
        return None
    problem, moved = found
    watch.say("counting each recording from its own zero")
    whole = problem.with_used([e.used for e in setting.whole.experiments])
    nominal = replace(setting.nominal, constants=whole.kind.constants())
    aside = watch.aside(whole.work, len(whole.output), len(whole.fitted_runs))
    try:
        with with_a_copy(whole, nominal, aside):
            own = prepared(setting.believed, whole, nominal, setting.validation, setting.chosen, aside)
            found_so = decided(own, first_beginning(own.problem, own.base), aside)
            recorded = [e.output for e in setting.problem.experiments]
            return CountedFromOwn.of(concluded(*found_so, aside), found_so[1].improved, moved, recorded, aside)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # it diverges so
        return None


def _held(setting: Setting, watch: Watch) -> tuple[Pulled | None, Diagnosis | None]:
    """Diagnosis with an observer, and the one that nothing else need be looked for beside, if there is one."""
    pulled = _pulled(setting, watch)
    if pulled is None:
        return None, None
    return pulled, _released(setting, pulled, watch) or (pulled.taken(watch) if pulled.tells_all else None)


def _pulled(setting: Setting, watch: Watch) -> Pulled | None:
    """Diagnosis with a simulation that an observer pulls towards the recording; None where there can be none."""
    held = with_observer(setting.believed, setting.whole, setting.nominal)
    if held is None or watch.no_time_for("a simulation that an observer pulls", needed=True):
        return None
    believed, problem, nominal = held
    watch.say("pulling the simulation towards the recording")
    aside = watch.aside(problem.work, len(problem.output), len(problem.fitted_runs))
    try:
        with with_a_copy(problem, nominal, aside):
            pulled = prepared(believed, problem, nominal, setting.validation, setting.chosen, aside)
            found_so = decided(pulled, first_beginning(pulled.problem, pulled.base, held=True), aside)
            found = concluded(*found_so, aside)
            undriven = undriven_error(pulled)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):  # it diverges all the same
        return None
    if takes_input_away(problem, effects_of(found.improved)):
        return None
    found = replace(found, warnings=[*found.warnings, *problem.kind.remarks(found.improved)])
    return Pulled(found, found_so[1].fitted.model, undriven, aside)


def _released(setting: Setting, pulled: Pulled, watch: Watch) -> Diagnosis | None:
    """Diagnosis without the observer, from what it has shown; None where the plant does not follow the recording so.

    A pull bends what is estimated, and leaves a structure of its own.
    """
    none_found = len(pulled.model.effects) <= setting.known
    if none_found or watch.no_time_for("a simulation without the observer", needed=True):
        return None
    watch.say("simulating without the observer what it has shown")
    with with_a_copy(setting.whole, setting.problem, setting.nominal, watch):
        start = as_start_of(setting.problem, pulled.model)
        beginning = beginning_with(setting.problem, setting.base, start)
        found = None if beginning is None else concluded(*decided(setting, beginning, watch), watch)
    return None if found is None or is_astray(found) else found
