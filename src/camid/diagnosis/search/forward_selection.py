"""Forward selection: effects are added to a model as long as each is called for.

Hypotheses are compared by Bayes's criterion, tempered where the residual is not white; see
:meth:`camid.fitting.fit.Fitted.criterion_beyond`. An effect is added where the likelihood ratio would be exceeded by
chance, anywhere in the catalogue, in less than one recording of several hundred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.noiseless import ask_for_noise
from camid.diagnosis.search.beginnings_in_a_loop import Beginning
from camid.diagnosis.search.decision import Decision, Searches
from camid.diagnosis.search.false_alarms import FALSE_ALARM, FALSE_ALARM_BESIDE_OTHERS, STRONG_EVIDENCE, p_value
from camid.diagnosis.search.hypothesis import Hypothesis
from camid.diagnosis.search.hypothesis_search import (
    BESIDE_OTHERS,
    first_effort,
    has_run_away,
    hypotheses,
    is_far_off,
)
from camid.diagnosis.search.inexact_laws import laws_are_inexact
from camid.diagnosis.search.models_of_each_recording import models_of_each_recording
from camid.diagnosis.search.screening import ScreenedEffect, screen
from camid.diagnosis.search.settled_laws import finer_in_place
from camid.diagnosis.watch import NAMES, Watch
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

Array = NDArray[np.float64]

# Effects that are looked for in any case, and at most: beyond the first ones, each that is found has to have explained
# more than an inexact law of the others may leave.
FEWEST_EFFECTS, MOST_EFFECTS = 3, 8
# Different linear dynamics that are begun beside the nominal coefficients, too, and the factor by which an estimated
# one has to differ for that.
MOST_LINEAR, FAR = 4, 2.0
# Effects that are looked for though all work is done, among the likeliest alone.
MOST_IN_OVERTIME = 2
# Share of the mismatch that inexact laws may leave, and of what was left that no correction of such explains.
LAW_ERROR, NO_CORRECTION = 0.04, 0.5
# Share of the mismatch from which an effect is worth a look at what shows beside it, though what it leaves is so
# coloured that chance may do as much: what another effect does is structure until that is found, too.
WORTH_A_LOOK = 0.3


def with_added_effects(
    problem: Problem,
    base: Fitted,
    searches: Searches,
    watch: Watch,
    screened: Sequence[ScreenedEffect] | None = None,
    nominal: Model | None = None,
    beginning: Beginning | None = None,
) -> Decision:
    """Add effects to a model as long as each is called for.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        The refitted nominal model.
    searches : Searches
        Where what is found is kept.
    watch : Watch
    screened : sequence of ScreenedEffect, optional
        Of the base, where it was screened already.
    nominal : Model, optional
        As the simulation says, without effects.
    beginning : Beginning, optional
        With effects that stand already; an interrupted search goes on though a law of it seems to be inexact.

    Returns
    -------
    Decision
        Of which no effect was put to the test beside the others.

    Raises
    ------
    NoNoise
        If a model leaves less than a simulation is accurate to.
    """
    beginning = beginning or Beginning()
    begun = beginning.decision
    current, rivals = (base, []) if begun is None else (begun.fitted, list(begun.rivals))
    # Where small changes add up to a phase error, the screening of few is a poor guide.
    interrupted, overtime = False, MOST_IN_OVERTIME if problem.kind.phases_add_up else 0
    known = len(base.model.effects)
    doubtful: Fitted | None = None
    while len(current.model.effects) - known < MOST_EFFECTS:
        ask_for_noise(problem, current)
        names = ", ".join(e.identifier for e in current.model.effects)
        watch.take_stock(NAMES)
        part = f"effects in addition to {names}" if names else "effects of the catalogue"
        # The likeliest are fitted whatever is done: what slow laws leave no time for may be what matters most.
        if watch.no_time_for(part, needed=overtime < MOST_IN_OVERTIME):
            break
        overtime += watch.no_time_for(f"all but the likeliest {part}")
        refined = begun is not None and current is begun.fitted  # what stands already was
        if doubtful is None and not refined and not watch.no_time_for("finer laws"):
            current = finer_in_place(problem, current)
        watch.say(f"fitting what may be missing{' in addition to ' + names if names else ''}")
        found = screen(problem, current, signatures=searches.signatures) if screened is None else screened
        beside = len(current.model.effects) > known
        if beside and not (begun and begun.interrupted) and laws_are_inexact(problem, current, found):
            interrupted = True
            break
        effort = BESIDE_OTHERS if beside else first_effort(problem)
        start = _nominal_start(problem, current, nominal, begun is not None or not current.model.effects)
        others = [] if beside else [*models_of_each_recording(problem, current, watch), *beginning.models]
        others += _linear_from_nominal(current, nominal if start is None else None, found)
        ranked = hypotheses(problem, current, found, start, effort=effort, watch=watch, others=others)
        searches.keep(current, ranked)
        screened = None
        level = FALSE_ALARM_BESIDE_OTHERS if beside else FALSE_ALARM
        ranked = [h for h in ranked if h.beyond(Hypothesis("", current)) < -STRONG_EVIDENCE]
        if not ranked:
            break
        left, best = current, ranked[0].fitted
        if p_value(problem, current, best, ranked[0].identifier) >= level:
            if doubtful is not None or best.cost > (1.0 - WORTH_A_LOOK) * current.cost:
                break
            doubtful, current, rivals = current, best, [*rivals, ranked]
            continue
        doubtful, current, rivals = None, best, [*rivals, ranked]
        enough = len(current.model.effects) - known >= FEWEST_EFFECTS
        explained = left.cost - current.cost
        if enough and explained < min(LAW_ERROR * (base.cost - current.cost), NO_CORRECTION * left.cost):
            break
    if doubtful is not None:
        current = doubtful
        rivals.pop()
    return Decision(base, current, rivals, interrupted=interrupted)


def _linear_from_nominal(current: Fitted, nominal: Model | None, screened: Sequence[ScreenedEffect]) -> list[Model]:
    """Models with linear dynamics beside the nominal coefficients.

    The estimated ones have taken the place of a delay or a lag that is missing, and from there to those beside it a
    fit follows a long valley; the nominal ones were never bent.
    """
    if nominal is None or not _are_far(current.model.coefficients, nominal.coefficients):
        return []
    beside = replace(current.model, coefficients=nominal.coefficients)
    found: dict[str, Model] = {}
    for candidate in screened:
        if candidate.effect.imitates_linear_dynamics and len(found) < MOST_LINEAR:
            found.setdefault(candidate.effect.identifier, beside.plus(candidate.start))
    return list(found.values())


def _are_far(found: Array, given: Array) -> bool:
    """Whether a coefficient has moved so far that what is begun beside the other value may end elsewhere."""
    sizes = np.abs(found[given != 0.0] / given[given != 0.0])
    return bool(np.any((sizes > FAR) | (sizes < 1.0 / FAR)))


def _nominal_start(problem: Problem, current: Fitted, nominal: Model | None, anew: bool) -> Model | None:
    """The nominal model with the effects found, as a start beside the refitted one where that is still far off."""
    if nominal is None:
        return None
    out_of_phase = problem.kind.phases_add_up and anew
    if not out_of_phase and not is_far_off(problem, current) and not has_run_away(current, nominal):
        return None
    return replace(nominal, effects=current.model.effects)
