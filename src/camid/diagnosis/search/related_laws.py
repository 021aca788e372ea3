"""Laws that are related to one that a model holds, fitted from where that one is.

Its special case, what does nearly the same, and laws with more detail.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from functools import partial

from camid.diagnosis.search.hypothesis import Hypothesis, in_order, special_case_of
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, FIRST_STEPS, fitted_hypothesis
from camid.diagnosis.search.screening import may_be_more_than_chance
from camid.effects.base import Effect
from camid.effects.special_cases import special_case
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import WORKERS, side_by_side

# Effects whose laws with more detail are fitted, and the sum of squares of the second one of them over the least one.
MOST_REFINED, NEARLY_AS_GOOD = 2, 1.3
# Sum of squares, in noise variances, that a law has to gain for more detail to be looked for beyond it.
LEAST_GAINED = 2.0


def special_case_in_place(
    problem: Problem, general: Fitted, index: int, known: Set[str] = frozenset(), steps: int = FIRST_STEPS
) -> Hypothesis | None:
    """The special case of one of a model's effects in its place, fitted from there; None if there is none, or known."""
    model = general.model
    effect = special_case(model.effects[index])
    if effect is None or effect.identifier in known | {e.identifier for e in model.effects}:
        return None
    if problem.kind.unseen_beside(type(effect), model.without(index)) is not None:
        return None
    return _in_place(problem, model, index, effect, steps)


def plainer_law(problem: Problem, fitted: Fitted, index: int) -> Hypothesis | None:
    """The law of the same name with less detail in the place of one of a model's effects; None if there is none.

    A search may have come to the detail first, and another effect, found later, may account for it.
    """
    model = fitted.model
    effect = model.effects[index].simplified()
    if effect is None or effect.identifier != model.effects[index].identifier:
        return None
    return _in_place(problem, model, index, effect)


def relatives_in_place(problem: Problem, fitted: Fitted, index: int) -> list[Hypothesis]:
    """What does nearly the same as one of a model's effects in its place, fitted from there."""
    found = [_in_place(problem, fitted.model, index, each) for each in possible_relatives(problem, fitted.model, index)]
    return [h for h in found if h is not None]


def possible_relatives(problem: Problem, model: Model, index: int) -> list[Effect]:
    """What does nearly the same as one of a model's effects, of what the model lacks and the recordings can show."""
    effect = model.effects[index]
    if type(effect).relatives is Effect.relatives:  # none, without a simulation
        return []
    try:
        views = problem.situations(model)
        relatives = effect.relatives(views.of(type(effect)))
    except (ValueError, ArithmeticError):  # an effect that has run away leads to no other law
        return []
    present = {e.identifier for i, e in enumerate(model.effects) if i != index}

    def is_possible(kind: type[Effect]) -> bool:
        return problem.kind.unseen_beside(kind, model.without(index)) is None and kind.invisible(views.of(kind)) is None

    return [each for each in relatives if each.identifier not in present and is_possible(type(each))]


def _in_place(problem: Problem, model: Model, index: int, effect: Effect, steps: int = ALL_STEPS) -> Hypothesis | None:
    """A law in the place of one of a model's effects, fitted from there; it stands last."""
    return fitted_hypothesis(problem, effect.identifier, _with_last(model, index, effect), steps)


def _with_last(model: Model, index: int, effect: Effect) -> Model:
    """The model with a law in the place of one of its effects; it stands last."""
    return model.without(index).plus(effect.leading(model.effects[index].leads))


def worth_a_fit(problem: Problem, fitted: Fitted, starts: Sequence[Model]) -> list[Model]:
    """Models in which a law has more detail that are worth a fit: all where structure is left, else what shows."""
    if len(fitted.noise.whitening) > 1:
        return list(starts)
    shows = side_by_side(partial(may_be_more_than_chance, problem, fitted), starts)
    return [start for start, seen in zip(starts, shows, strict=True) if seen]


def finer_laws(problem: Problem, ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Laws with more detail of the likeliest effects that have such, fitted, each from the one before it.

    They are called for where the likeliest of all leaves structure or what they would explain, or has another name, or
    may be a finer law of one; and those of a second effect where it leaves hardly more than the likeliest, or is the
    special case of an effect before it: what bends that one may be detail of another kind.
    """
    if problem.kind.phases_add_up:  # what bends there is not told from a law of the position that is learned
        return []
    found: list[Hypothesis] = []
    refined, special = 0, set()
    for hypothesis in ranked:
        least = min(h.fitted.cost for h in (ranked[0], *found))
        if refined and hypothesis.fitted.cost > NEARLY_AS_GOOD * least and hypothesis.identifier not in special:
            continue
        special.add(special_case_of(hypothesis))
        starts = _finer_starts(problem, hypothesis)
        if hypothesis is ranked[0] and all(m.effects[-1].identifier == hypothesis.identifier for m in starts):
            starts = worth_a_fit(problem, hypothesis.fitted, starts)
        if not starts:
            continue
        lowest = hypothesis.fitted.cost
        while starts:
            fitted = _until_white(problem, starts)
            found += fitted
            # A law that begins with itself again, as a step at another time does, gains ever less.
            better = [h for h in fitted if h.fitted.cost < lowest * (1.0 - LEAST_GAINED / len(h.fitted.residual))]
            lowest = min((h.fitted.cost for h in better), default=lowest)
            # Where two laws do nearly the same, either may be the one that has more detail.
            near = _of_different_laws(better, NEARLY_AS_GOOD * lowest)
            starts = [start for h in near[:MOST_REFINED] for start in _finer_starts(problem, h)]
        refined += 1
        if refined == MOST_REFINED:
            break
    return found


def _of_different_laws(hypotheses: Sequence[Hypothesis], most: float) -> list[Hypothesis]:
    """The best hypothesis of each law among those that leave at most so much."""
    found: dict[type[Effect], Hypothesis] = {}
    for hypothesis in hypotheses:
        if hypothesis.fitted.cost <= most:
            found.setdefault(type(hypothesis.fitted.model.effects[-1]), hypothesis)
    return list(found.values())


def _until_white(problem: Problem, starts: Sequence[Model]) -> list[Hypothesis]:
    """Fits of the effect that models hold last, up to the first that leaves white noise, the best first."""
    found: list[Hypothesis] = []
    for first in range(0, len(starts), WORKERS):
        fitted = side_by_side(partial(_fitted_from, problem), starts[first : first + WORKERS])
        found += [h for h in fitted if h is not None]
        if any(len(h.fitted.noise.whitening) == 1 for h in found):
            break
    return in_order(found)


def _fitted_from(problem: Problem, model: Model) -> Hypothesis | None:
    return fitted_hypothesis(problem, model.effects[-1].identifier, model, ALL_STEPS)


def _finer_starts(problem: Problem, hypothesis: Hypothesis) -> list[Model]:
    """Models in which laws with more detail take the place of the effect that a hypothesis's model holds last.

    Or the same law, of values from where a fit may end in a better minimum.
    """
    model = hypothesis.fitted.model
    others = model.effects[:-1]
    present = {e.identifier for e in others}
    laws = [*finer_of(problem, model, model.effects[-1]), *restarts_of(problem, hypothesis.fitted, model.effects[-1])]
    last = len(others)
    return [model.replaced(last, law) for law in laws if law.identifier not in present]


def finer_of(problem: Problem, model: Model, effect: Effect) -> tuple[Effect, ...]:
    """Laws with more detail than one of a model's effects, as they are started."""
    try:
        return effect.finer(problem.situations(model).of(type(effect)))
    except (ValueError, ArithmeticError):  # an effect that has run away leads to no other law
        return ()


def restarts_of(problem: Problem, fitted: Fitted, effect: Effect) -> tuple[Effect, ...]:
    """Values of an effect of a model from which a fit may end in a better minimum."""
    if type(effect).restarts is Effect.restarts:  # none, without a simulation
        return ()
    try:
        return effect.restarts(problem.situations(fitted.model).of(type(effect)))
    except (ValueError, ArithmeticError):  # an effect that has run away leads nowhere
        return ()
