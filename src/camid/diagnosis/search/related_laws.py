"""Laws that are related to one that a model holds, fitted from where that one is.

Its special case, what does nearly the same, and laws with more detail.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, FIRST_STEPS, fitted_hypothesis
from camid.diagnosis.search.screening import may_be_more_than_chance
from camid.effects.base import Effect
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import WORKERS, side_by_side

# Share of a bound within which a number lies on it.
AT_BOUND = 1e-3
# Effects whose laws with more detail are fitted, and the sum of squares of the second one of them over the least one.
MOST_REFINED, NEARLY_AS_GOOD = 2, 1.3


def special_case(problem: Problem, general: Fitted, index: int, known: set[str]) -> Hypothesis | None:
    """The special case of one of a model's effects in its place, fitted from there; None if there is none, or known."""
    model = general.model
    effect = model.effects[index].simplified()
    if effect is None or effect.identifier in known | {e.identifier for e in model.effects}:
        return None
    if problem.kind.unseen(type(effect)) is not None:
        return None
    return _in_place(problem, model, index, effect, FIRST_STEPS)


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
        return problem.kind.unseen(kind) is None and kind.invisible(views.of(kind)) is None

    return [each for each in relatives if each.identifier not in present and is_possible(type(each))]


def finer_in_place(problem: Problem, fitted: Fitted, first: int = 0, *, last: bool = False) -> Fitted:
    """The model with more detail in a law that others were found beside, where that is likelier; else the same.

    What a law lacks may show only when what hid it is found. In a search that of the ``last`` effect has been tried.
    """
    effects = fitted.model.effects[first:]
    for identifier in [e.identifier for e in (effects if last else effects[:-1])]:
        index = [e.identifier for e in fitted.model.effects].index(identifier)
        effect = fitted.model.effects[index]
        laws = [law for law in _finer(problem, fitted.model, effect) if law.identifier == identifier]
        starts = [_with_law(fitted.model, index, law) for law in laws]
        own = Hypothesis(identifier, fitted, prior_penalty(problem, effect))
        starts = _worth_a_fit(problem, fitted, starts)
        tried = side_by_side(partial(_fitted_in_place, problem, index), starts)
        fitted = in_order([own, *(h for h in tried if h is not None)])[0].fitted
    return fitted


def finer_instead(problem: Problem, others: Fitted, first: int) -> list[tuple[Hypothesis, Effect]]:
    """Laws with more detail in the place of the effects of a model, fitted, each with the law that it takes it of.

    They are those that may do what an effect beside them was found for.
    """
    found: list[tuple[Hypothesis, Effect]] = []
    present = {effect.identifier for effect in others.model.effects}
    for index, effect in enumerate(others.model.effects[first:], start=first):
        laws = [e for e in _finer(problem, others.model, effect) if e.identifier not in present - {effect.identifier}]
        starts = [_with_law(others.model, index, law) for law in laws]
        tried = side_by_side(partial(_fitted_in_place, problem, index), starts)
        found += [(hypothesis, effect) for hypothesis in tried if hypothesis is not None]
    return found


def settled_laws(problem: Problem, fitted: Fitted, first: int) -> Fitted:
    """The model with each of its effects' laws in the detail that the others call for now that all of them are found.

    Detail that went as far as it may is that of a plainer law, which is not reached so: a knee that is a corner.

    Parameters
    ----------
    problem : Problem
    fitted : Fitted
    first : int
        The first of the effects that a search has found.
    """
    for index in range(first, len(fitted.model.effects)):
        fitted = _under_its_name(problem, fitted, index)
    fitted = finer_in_place(problem, fitted, first, last=True)
    for identifier in [effect.identifier for effect in fitted.model.effects[first:]]:
        index = [effect.identifier for effect in fitted.model.effects].index(identifier)
        effect = fitted.model.effects[index]
        simple = effect.simplified()
        if simple is not None and _is_at_bound(problem, effect, simple):
            own = Hypothesis(identifier, fitted, prior_penalty(problem, effect))
            plainer = _fitted_in_place(problem, index, _with_law(fitted.model, index, simple))
            fitted = in_order([own, *([plainer] if plainer else [])])[0].fitted
    return fitted


def _under_its_name(problem: Problem, fitted: Fitted, index: int) -> Fitted:
    """The model with a law that a general one is a detour to in its place, where that is likelier: of fewer numbers.

    A loop that saturates at once is dry friction, which may turn round over a range of speeds.
    """
    effect = fitted.model.effects[index]
    special = effect.simplified()
    while special is not None and special.identifier == effect.identifier:
        special = special.simplified()
    if special is None or special.identifier in {e.identifier for e in fitted.model.effects}:
        return fitted
    plain = _fitted_in_place(problem, index, _with_law(fitted.model, index, special))
    if plain is None:
        return fitted
    law = plain.fitted.model.effects[index]
    laws = [each for each in _finer(problem, plain.fitted.model, law) if each.identifier == law.identifier]
    starts = [_with_law(plain.fitted.model, index, each) for each in laws]
    tried = side_by_side(partial(_fitted_in_place, problem, index), starts)
    own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
    return in_order([own, plain, *(h for h in tried if h is not None)])[0].fitted


def _is_at_bound(problem: Problem, effect: Effect, simple: Effect) -> bool:
    """Whether a number that a plainer law of the same name lacks lies at a bound."""
    if simple.identifier != effect.identifier:
        return False
    kept = {parameter.name for parameter in simple.parameters}
    numbers = zip(effect.numeric(), effect.vector, effect.bounds(problem.acquisition), strict=True)
    return any(
        abs(value - bound) <= AT_BOUND * abs(bound)
        for parameter, value, bounds in numbers
        for bound in bounds
        if parameter.name not in kept and np.isfinite(bound)
    )


def _in_place(problem: Problem, model: Model, index: int, effect: Effect, steps: int = ALL_STEPS) -> Hypothesis | None:
    """A law in the place of one of a model's effects, fitted from there; it stands last."""
    return fitted_hypothesis(problem, effect.identifier, _with_last(model, index, effect), steps)


def _with_law(model: Model, index: int, law: Effect) -> Model:
    """The model with another law of the same name: effects act in the order in which they stand."""
    return replace(model, effects=(*model.effects[:index], law, *model.effects[index + 1 :]))


def plausible_in_place(problem: Problem, fitted: Fitted, index: int) -> Hypothesis | None:
    """The likeliest of the special cases and relatives of one of a model's effects in its place, of possible values.

    A general law that a fit has stretched to values that are not possible may be its special case all the same.
    """
    model = fitted.model
    effect = model.effects[index]
    laws, special = [], effect.simplified()
    while special is not None:
        laws.append(special)
        special = special.simplified()
    present = {e.identifier for i, e in enumerate(model.effects) if i != index}
    laws = [e for e in laws if e.identifier not in present and problem.kind.unseen(type(e)) is None]
    laws += possible_relatives(problem, model, index)
    tried = side_by_side(partial(_fitted_in_place, problem, index), [_with_law(model, index, law) for law in laws])
    found = in_order([h for h in tried if h is not None])
    return found[0] if found else None


def _fitted_in_place(problem: Problem, index: int, model: Model) -> Hypothesis | None:
    return fitted_hypothesis(problem, model.effects[index].identifier, model, ALL_STEPS, index=index)


def _with_last(model: Model, index: int, effect: Effect) -> Model:
    """The model with a law in the place of one of its effects; it stands last."""
    return replace(model, effects=(*model.without(index).effects, effect))


def _worth_a_fit(problem: Problem, fitted: Fitted, starts: Sequence[Model]) -> list[Model]:
    """Models in which a law has more detail that are worth a fit: all where structure is left, else what shows."""
    if len(fitted.noise.whitening) > 1:
        return list(starts)
    shows = side_by_side(partial(may_be_more_than_chance, problem, fitted), starts)
    return [start for start, seen in zip(starts, shows, strict=True) if seen]


def finer_laws(problem: Problem, ranked: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Laws with more detail of the likeliest effects that have such, fitted, each from the one before it.

    They are called for where the likeliest of all leaves structure or what they would explain, or has another name, or
    may be a finer law of one; and those of a second effect where it leaves hardly more than the likeliest.
    """
    if problem.kind.phases_add_up:  # what bends there is not told from a law of the position that is learned
        return []
    found: list[Hypothesis] = []
    refined = 0
    for hypothesis in ranked:
        if refined and hypothesis.fitted.cost > NEARLY_AS_GOOD * min(h.fitted.cost for h in (ranked[0], *found)):
            continue
        starts = _finer_starts(problem, hypothesis)
        if hypothesis is ranked[0] and all(m.effects[-1].identifier == hypothesis.identifier for m in starts):
            starts = _worth_a_fit(problem, hypothesis.fitted, starts)
        if not starts:
            continue
        while starts:
            fitted = _until_white(problem, starts)
            found += fitted
            starts = _finer_starts(problem, fitted[0]) if fitted else []
        refined += 1
        if refined == MOST_REFINED:
            break
    return found


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
    """Models in which laws with more detail take the place of the effect that a hypothesis's model holds last."""
    model = hypothesis.fitted.model
    others = model.effects[:-1]
    present = {e.identifier for e in others}
    laws = _finer(problem, model, model.effects[-1])
    return [replace(model, effects=(*others, law)) for law in laws if law.identifier not in present]


def _finer(problem: Problem, model: Model, effect: Effect) -> tuple[Effect, ...]:
    """Laws with more detail than one of a model's effects, as they are started."""
    try:
        return effect.finer(problem.situations(model).of(type(effect)))
    except (ValueError, ArithmeticError):  # an effect that has run away leads to no other law
        return ()
