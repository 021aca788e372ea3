"""Which effects a recording supports: forward selection with swaps and backward removal.

Hypotheses are compared by Bayes's criterion, tempered where the residual is not white; see
:meth:`camid.fitting.fit.Fitted.criterion_beyond`. An effect is added where the likelihood ratio would be exceeded by
chance, anywhere in the catalogue, in less than one recording of several hundred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.search.hypothesis_search import (
    BESIDE_OTHERS,
    RIVALS,
    best_of_each,
    first_effort,
    has_run_away,
    hypotheses,
    is_far_off,
)
from camid.diagnosis.search.inexact_laws import laws_are_inexact
from camid.diagnosis.search.models_of_each_recording import models_of_each_recording
from camid.diagnosis.search.related_laws import finer_in_place, plainer_law, relatives_in_place, special_case
from camid.diagnosis.search.screening import ScreenedEffect, Signatures, screen, trials
from camid.diagnosis.watch import NAMES, Watch
from camid.effects import known_effects
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.learned_law import LearnedLaw
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem

# Probability of naming an effect where nothing is missing, for the whole catalogue together.
FALSE_ALARM = 0.002
# The same for an effect beside others, whose law may not be exact.
FALSE_ALARM_BESIDE_OTHERS = 1e-4
# Effects that are looked for in any case, and at most: beyond the first ones, each that is found has to have explained
# more than an inexact law of the others may leave.
FEWEST_EFFECTS, MOST_EFFECTS = 3, 8
# Share of the mismatch that inexact laws may leave.
LAW_ERROR = 0.04
# Share of the mismatch from which an effect is worth a look at what shows beside it, though what it leaves is so
# coloured that chance may do as much: what another effect does is structure until that is found, too.
WORTH_A_LOOK = 0.3
MOST_SWAPS = 4
SWAP_MARGIN = 2.0
# Difference of the criterion within which two fits of the same effects are the same minimum.
SAME_MINIMUM = 1.0


@dataclass(frozen=True)
class Decision:
    """The effects that were added, each with the hypotheses that competed with it.

    Attributes
    ----------
    base, fitted : Fitted
        Without and with the effects.
    rivals : list of list of Hypothesis
        For each effect found: every hypothesis in its place, the best first, the effect itself among them.
    without : list of Fitted
        For each effect found: the model without it, fitted.
    laws : tuple of LearnedLaw
        Laws without a name behind them, for what they leave; each is fitted with those before it.
    certain : frozenset of str
        Effects that hold where everything is allowed for that the inexact laws of the others could do.
    interrupted : bool
        Whether the search for names ended where a law seemed to be inexact.
    """

    base: Fitted
    fitted: Fitted
    rivals: list[list[Hypothesis]] = field(default_factory=list)
    without: list[Fitted] = field(default_factory=list)
    laws: tuple[LearnedLaw, ...] = ()
    certain: frozenset[str] = frozenset()
    interrupted: bool = False

    @property
    def improved(self) -> Fitted:
        """What the improved simulation holds: the effects found come first."""
        return self.laws[-1].fitted if self.laws else self.fitted


class Searches:
    """What was found beside each set of effects, so that nothing is searched for twice."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, ...], tuple[Fitted, list[Hypothesis]]] = {}
        self.signatures = Signatures()

    def beside(self, base: Fitted) -> list[Hypothesis] | None:
        """What an earlier search beside the same effects found, if the coefficients were in the same minimum."""
        earlier, found = self._found.get(self._effects(base), (None, []))
        return found if earlier is not None and abs(earlier.criterion_beyond(base)) < SAME_MINIMUM else None

    def keep(self, base: Fitted, found: list[Hypothesis]) -> None:
        """Remember what a search found."""
        self._found[self._effects(base)] = (base, found)

    @staticmethod
    def _effects(base: Fitted) -> tuple[str, ...]:
        return tuple(sorted(e.identifier for e in base.model.effects))


def p_value(problem: Problem, before: Fitted, after: Fitted, identifier: str) -> float:
    """Bound on the probability that an effect improves the likelihood as much where it is not."""
    added = len(after.penalised_names) - len(before.penalised_names)
    ratio = before.criterion_beyond(after) + added * float(np.log(len(after.residual)))
    return chance(problem, identifier, ratio, added)


def chance(problem: Problem, identifier: str, ratio: float, added: int = 0) -> float:
    """Bound on the probability of twice a logarithm of a likelihood ratio anywhere in a search without the effect.

    It has the freedom of the effect's parameters, or that of all numbers that were ``added``, the states of a mode
    among them.
    """
    from scipy.special import chdtrc

    freedom = max(len(known_effects()[identifier].numeric()), added, 1)
    return min(float(chdtrc(freedom, max(ratio, 0.0))) * searched(problem, identifier), 1.0)


def searched(problem: Problem, identifier: str) -> float:
    """How many hypotheses a search through the catalogue amounts to, from the view of one effect."""
    count = sum(not e.noise_like for e in known_effects().values())
    return trials(known_effects()[identifier], problem) * count


def select_effects(
    problem: Problem,
    base: Fitted,
    screened: Sequence[ScreenedEffect] | None = None,
    watch: Watch | None = None,
    nominal: Model | None = None,
    searches: Searches | None = None,
    begun: Decision | None = None,
) -> Decision:
    """Add effects as long as each is called for, then test each against what could replace it.

    Parameters
    ----------
    problem : Problem
    base : Fitted
        The refitted nominal model.
    screened : sequence of ScreenedEffect, optional
        Of the base, where it was screened already.
    watch : Watch, optional
    nominal : Model, optional
        As the simulation says, without effects.
    searches : Searches, optional
        What was found already, and where what is found is kept.
    begun : Decision, optional
        An interrupted search, which goes on.
    """
    watch = watch or Watch()
    current = base if begun is None else begun.fitted
    rivals: list[list[Hypothesis]] = [] if begun is None else list(begun.rivals)
    interrupted = False
    known = len(base.model.effects)
    searches = searches or Searches()
    doubtful: Fitted | None = None
    while len(current.model.effects) - known < MOST_EFFECTS:
        names = ", ".join(e.identifier for e in current.model.effects)
        watch.take_stock(NAMES)
        if watch.no_time_for(f"effects in addition to {names}" if names else "effects of the catalogue"):
            break
        if doubtful is None and not watch.no_time_for("finer laws"):
            current = finer_in_place(problem, current)
        watch.say(f"fitting what may be missing{' in addition to ' + names if names else ''}")
        found = screen(problem, current, signatures=searches.signatures) if screened is None else screened
        beside = len(current.model.effects) > known
        if beside and not (begun and begun.interrupted) and laws_are_inexact(problem, current, found):
            interrupted = True
            break
        effort = BESIDE_OTHERS if beside else first_effort(problem)
        start = _nominal_start(problem, current, nominal)
        alone = () if beside else models_of_each_recording(problem, current, watch)
        ranked = hypotheses(problem, current, found, start, effort=effort, watch=watch, others=alone)
        searches.keep(current, ranked)
        screened = None
        level = FALSE_ALARM_BESIDE_OTHERS if beside else FALSE_ALARM
        ranked = [h for h in ranked if h.beyond(Hypothesis("", current)) < 0.0]
        if not ranked:
            break
        if p_value(problem, current, ranked[0].fitted, ranked[0].identifier) >= level:
            if doubtful is not None or ranked[0].fitted.cost > (1.0 - WORTH_A_LOOK) * current.cost:
                break
            doubtful, current = current, ranked[0].fitted
            rivals.append(ranked)
            continue
        left, current, doubtful = current, ranked[0].fitted, None
        rivals.append(ranked)
        enough = len(current.model.effects) - known >= FEWEST_EFFECTS
        if enough and left.cost - current.cost < LAW_ERROR * (base.cost - current.cost):
            break
    if doubtful is not None:
        current = doubtful
        rivals.pop()
    if len(rivals) < 2:
        return Decision(base, current, rivals, [base] * len(rivals), interrupted=interrupted)
    return replace(_swapped(problem, base, current, searches, watch), interrupted=interrupted)


def _nominal_start(problem: Problem, current: Fitted, nominal: Model | None) -> Model | None:
    """The nominal model with the effects found, as a start beside the refitted one where that is still far off."""
    if nominal is None:
        return None
    out_of_phase = problem.kind.phases_add_up and not current.model.effects
    if not out_of_phase and not is_far_off(problem, current) and not has_run_away(current, nominal):
        return None
    return replace(nominal, effects=current.model.effects)


def _swapped(problem: Problem, base: Fitted, current: Fitted, searches: Searches, watch: Watch) -> Decision:
    """Put every effect to the test beside the others, until none is swapped or removed."""
    first = len(base.model.effects)
    rivals: list[list[Hypothesis]] = []
    without: list[Fitted] = []
    for _ in range(MOST_SWAPS):
        rivals, without = [], []
        changed = False
        for index in range(first, len(current.model.effects)):
            identifier = current.model.effects[index].identifier
            watch.take_stock(NAMES)
            if watch.no_time_for(f"what could replace {identifier}"):
                break
            watch.say(f"testing what could replace {identifier}")
            others = fit(problem, current.model.without(index), steps=ALL_STEPS)
            own = Hypothesis(identifier, current, prior_penalty(problem, current.model.effects[index]))
            if (
                p_value(problem, others, current, identifier) >= FALSE_ALARM_BESIDE_OTHERS
                or own.beyond(Hypothesis("", others)) >= 0.0
            ):
                current, changed = others, True
                break
            found = searches.beside(others)
            if found is None:
                laws = screen(problem, others, signatures=searches.signatures)
                laws = [c for c in laws if c.effect.identifier != identifier]
                found = hypotheses(problem, others, laws, effort=RIVALS, watch=watch, incumbent=own)
                searches.keep(others, [*found, _last(own, index)])
            simpler = (
                special_case(problem, current, index, {h.identifier for h in found}),
                plainer_law(problem, current, index),
            )
            found = [*found, *(h for h in simpler if h is not None)]
            found += relatives_in_place(problem, current, index)
            best = in_order([own, *found])[0]
            if own.beyond(best) > SWAP_MARGIN:
                current, changed = best.fitted, True
                break
            ranked = best_of_each([own, *(h for h in found if h.identifier != identifier)])
            rivals.append(ranked)
            without.append(others)
        if not changed:
            if len(rivals) == len(current.model.effects) - first:
                current, rivals, without = with_likelier_name(current, rivals, without)
            break
    for index in range(first + len(rivals), len(current.model.effects)):  # the last swap was not tested itself
        without.append(fit(problem, current.model.without(index), steps=ALL_STEPS))
        identifier = current.model.effects[index].identifier
        rivals.append([Hypothesis(identifier, current)])
    return Decision(base, current, rivals, without)


def with_likelier_name(
    current: Fitted, rivals: list[list[Hypothesis]], without: list[Fitted]
) -> tuple[Fitted, list[list[Hypothesis]], list[Fitted]]:
    """The model with the name in the place of one of its effects that is likelier by less than a swap asks for, if any.

    What a swap asks for keeps a search from going round in circles; the likeliest name is the answer all the same. It
    stands last in the model, as it was fitted: effects act in the order in which they stand.

    Parameters
    ----------
    current : Fitted
    rivals : list of list of Hypothesis
        In the place of each of the last effects of the model, the likeliest first.
    without : list of Fitted
        The model without each of them.

    Returns
    -------
    Fitted, list, list
        Model, rivals and models without, in the order of the new model's effects.
    """
    first = len(current.model.effects) - len(rivals)

    def gap(place: int) -> float:
        """By how much the name that the model holds is less likely."""
        identifier = current.model.effects[first + place].identifier
        own = next(h for h in rivals[place] if h.identifier == identifier)
        return own.beyond(rivals[place][0])

    place = max(range(len(rivals)), key=gap, default=0)
    if not rivals or gap(place) <= 0.0:
        return current, rivals, without
    order = [*(i for i in range(len(rivals)) if i != place), place]
    return rivals[place][0].fitted, [rivals[i] for i in order], [without[i] for i in order]


def _last(hypothesis: Hypothesis, index: int) -> Hypothesis:
    """The same hypothesis with one of its effects as the last, as one beside the others."""
    effects = list(hypothesis.fitted.model.effects)
    effects.append(effects.pop(index))
    fitted = evaluate(hypothesis.fitted.problem, replace(hypothesis.fitted.model, effects=tuple(effects)))
    return replace(hypothesis, fitted=fitted)
