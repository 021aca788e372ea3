"""Which effects a recording supports: forward selection from several beginnings, with swaps and backward removal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from camid.diagnosis.search.beginnings_in_a_loop import Beginning
from camid.diagnosis.search.decision import Decision, Searches
from camid.diagnosis.search.false_alarms import FALSE_ALARM_BESIDE_OTHERS, STRONG_EVIDENCE, p_value
from camid.diagnosis.search.forward_selection import LAW_ERROR, with_added_effects
from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS
from camid.diagnosis.search.hypothesis_search import RIVALS, best_of_each, hypotheses
from camid.diagnosis.search.other_beginnings import SWAP_MARGIN, with_other_beginnings
from camid.diagnosis.search.related_laws import plainer_law, relatives_in_place, special_case_in_place
from camid.diagnosis.search.screening import ScreenedEffect, screen
from camid.diagnosis.search.settled_laws import finer_instead, fitted_in_place
from camid.diagnosis.watch import FORMULAS, NAMES, Watch
from camid.effects import known_effects
from camid.fitting.fit import Fitted, evaluate, fit
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

MOST_SWAPS = 4
# Names known from a search beside fewer effects, or beside others that fell with the one they replace, that are held
# against it beside all.
MOST_KNOWN = 3
# Factor by which the first number of an effect changes where it comes to nothing, or to much, without another one.
SWEPT = 3.0


def select_effects(
    problem: Problem,
    base: Fitted,
    screened: Sequence[ScreenedEffect] | None = None,
    watch: Watch | None = None,
    nominal: Model | None = None,
    searches: Searches | None = None,
    beginning: Beginning | None = None,
    leaves_structure: Callable[[Decision], bool] | None = None,
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
    beginning : Beginning, optional
        What the search begins with, such as an interrupted one, which goes on.
    leaves_structure : callable, optional
        Whether a decision's effects leave more than noise, for which others are begun with; none are without it.
    """
    watch, searches = watch or Watch(), searches or Searches()
    found = with_added_effects(problem, base, searches, watch, screened, nominal, beginning)
    if leaves_structure is not None:
        found = with_other_beginnings(problem, found, searches, watch, leaves_structure, nominal)
    if len(found.rivals) < 2:
        return replace(found, without=[base] * len(found.rivals))
    return replace(_swapped(problem, found, searches, watch), interrupted=found.interrupted)


def _swapped(problem: Problem, begun: Decision, searches: Searches, watch: Watch) -> Decision:
    """Put every effect to the test beside the others, until none is swapped or removed."""
    base, current = begun.base, begun.fitted
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
                or own.beyond(Hypothesis("", others)) > -STRONG_EVIDENCE
            ):
                current, changed = others, True
                break
            detailed = _detail_instead(problem, base, own, others)
            if detailed is not None:
                current, changed = detailed, True
                break
            found = searches.beside(others)
            if found is None:
                laws = screen(problem, others, signatures=searches.signatures)
                laws = [c for c in laws if c.effect.identifier != identifier]
                found = hypotheses(problem, others, laws, effort=RIVALS, watch=watch, incumbent=own)
                searches.keep(others, [*found, _last(own, index)])
            found = [*found, *_related_in_place(problem, current, index)]
            if _sweeps_along(current.model, others.model, index):
                found += _leading_in_place(problem, found, current, index)
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
    untested = range(first + len(rivals), len(current.model.effects))  # for lack of time, or the last swap itself
    # What was known before is held against each, unless all work is done.
    known = [] if watch.has_done(FORMULAS) else begun.rivals
    for index in untested:
        ranked = _known_in_place(problem, known, current, index)
        current = ranked[0].fitted
        rivals.append(ranked)
    without += side_by_side(partial(fit, problem, steps=ALL_STEPS), [current.model.without(i) for i in untested])
    return Decision(base, current, rivals, without)


def _known_in_place(
    problem: Problem, known: Sequence[Sequence[Hypothesis]], current: Fitted, index: int
) -> list[Hypothesis]:
    """An effect of a model and what was found in its place before, beside fewer effects, now beside all; best first.

    What led then, without another effect that is there, does so to the end unless it is held against the others again.
    """
    effect = current.model.effects[index]
    own = Hypothesis(effect.identifier, current, prior_penalty(problem, effect))
    earlier = next((ranked for ranked in known if any(h.identifier == effect.identifier for h in ranked)), [])
    related = [_from_last(h, index) for h in _related_in_place(problem, current, index)]
    found = [*_leading_in_place(problem, earlier, current, index), *related]
    best = in_order([own, *found])[0]
    if own.beyond(best) <= SWAP_MARGIN:
        return best_of_each([own, *found]) if best is own else [own, *found]
    return in_order([own, *found])


def _leading_in_place(problem: Problem, ranked: Sequence[Hypothesis], current: Fitted, index: int) -> list[Hypothesis]:
    """The effects that hypotheses hold last, in their order, in the place of one of a model's, fitted beside all."""
    present = {e.identifier for e in current.model.effects}
    leading = [h.fitted.model.effects[-1] for h in ranked if h.identifier not in present][:MOST_KNOWN]
    starts = [current.model.replaced(index, law) for law in leading]
    return [h for h in side_by_side(partial(fitted_in_place, problem, index), starts) if h is not None]


def _sweeps_along(whole: Model, others: Model, index: int) -> bool:
    """Whether one of a model's effects takes another with it: without it the other one has come to nothing, or to much.

    What is fitted beside the others then is fitted beside what they are not. Of each effect its first number counts.
    """
    kept = [effect for i, effect in enumerate(whole.effects) if i != index]
    pairs = [(e.vector[0], o.vector[0]) for e, o in zip(kept, others.effects, strict=True) if len(e.vector)]
    return any(not 1.0 / SWEPT <= abs(o) / max(abs(e), 1e-300) <= SWEPT for e, o in pairs)


def _related_in_place(problem: Problem, current: Fitted, index: int) -> list[Hypothesis]:
    """The special case of one of a model's effects, its law with less detail and what does nearly the same, fitted."""
    simpler = special_case_in_place(problem, current, index), plainer_law(problem, current, index)
    return [*(h for h in simpler if h is not None), *relatives_in_place(problem, current, index)]


def _detail_instead(problem: Problem, base: Fitted, own: Hypothesis, others: Fitted) -> Fitted | None:
    """The model without an effect that explains little and with more detail in another one's law, where it is likelier.

    A constant that sets in with the motion is a drift to a law of friction that is alike in both directions.
    """
    if others.cost - own.fitted.cost > LAW_ERROR * (base.cost - own.fitted.cost):
        return None
    best: Hypothesis | None = None
    for finer, law in finer_instead(problem, others, len(base.model.effects)):
        # What two common effects do together is not said to be one that is rare.
        if {own.identifier, law.identifier} <= set(known_effects()[finer.identifier].sum_of):
            continue
        plain = replace(own, penalty=own.penalty + prior_penalty(problem, law))
        if plain.beyond(finer) > SWAP_MARGIN and (best is None or best.beyond(finer) > 0.0):
            best = finer
    return None if best is None else best.fitted


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
    return _moved(hypothesis, index, len(hypothesis.fitted.model.effects) - 1)


def _from_last(hypothesis: Hypothesis, index: int) -> Hypothesis:
    """The same hypothesis with its last effect in the place of one that it was fitted instead of."""
    return _moved(hypothesis, len(hypothesis.fitted.model.effects) - 1, index)


def _moved(hypothesis: Hypothesis, start: int, end: int) -> Hypothesis:
    """The same hypothesis with one of its effects at another place of the list."""
    if start == end:
        return hypothesis
    effects = list(hypothesis.fitted.model.effects)
    effects.insert(end, effects.pop(start))
    fitted = evaluate(hypothesis.fitted.problem, replace(hypothesis.fitted.model, effects=tuple(effects)))
    return replace(hypothesis, fitted=fitted)
