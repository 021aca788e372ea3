"""Laws settled in their places: more detail, less of it, or another name, now that the other effects are found.

What a law lacks may show only when what hid it is found. Effects act in the order in which they stand, and keep it.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from camid.diagnosis.search.hypothesis import Hypothesis, in_order, prior_penalty
from camid.diagnosis.search.hypothesis_fit import ALL_STEPS, fitted_hypothesis
from camid.diagnosis.search.related_laws import finer_of, possible_relatives, restarts_of, worth_a_fit
from camid.effects.base import Effect
from camid.effects.plant_force import force_along
from camid.effects.special_cases import special_case
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.side_by_side import side_by_side

# Times that a model's laws are looked through for the detail that they lack.
PASSES = 2
# Share of a bound within which a number lies on it.
AT_BOUND = 1e-3


def finer_in_place(problem: Problem, fitted: Fitted, first: int = 0, *, last: bool = False) -> Fitted:
    """The model with more detail in a law that others were found beside, where that is likelier; else the same.

    What a law lacks may show only when what hid it is found. In a search that of the ``last`` effect has been tried.
    The detail of a later one hides that of an earlier one, too, which is looked for again.
    """
    effects = fitted.model.effects[first:]
    names = [e.identifier for e in (effects if last else effects[:-1])]
    later = changed = len(names)
    for _ in range(PASSES):
        found = fitted
        for position, identifier in enumerate(names[:later]):
            index = [e.identifier for e in fitted.model.effects].index(identifier)
            finer = _finer_at(problem, fitted, index)
            if finer is not fitted:
                fitted, changed = finer, position
        if fitted is found:
            break
        later = changed
    return fitted


def _finer_at(problem: Problem, fitted: Fitted, index: int) -> Fitted:
    """The model with more detail in one of its laws, where that is likelier; else the same."""
    effect = fitted.model.effects[index]
    laws = [law for law in finer_of(problem, fitted.model, effect) if law.identifier == effect.identifier]
    laws += restarts_of(problem, fitted, effect)
    starts = worth_a_fit(problem, fitted, [fitted.model.replaced(index, law) for law in laws])
    own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
    tried = side_by_side(partial(fitted_in_place, problem, index), starts)
    return in_order([own, *(h for h in tried if h is not None)])[0].fitted


def finer_instead(problem: Problem, others: Fitted, first: int) -> list[tuple[Hypothesis, Effect]]:
    """Laws with more detail in the place of the effects of a model, fitted, each with the law that it takes it of.

    They are those that may do what an effect beside them was found for.
    """
    found: list[tuple[Hypothesis, Effect]] = []
    present = {effect.identifier for effect in others.model.effects}
    for index, effect in enumerate(others.model.effects[first:], start=first):
        laws = [e for e in finer_of(problem, others.model, effect) if e.identifier not in present - {effect.identifier}]
        starts = [others.model.replaced(index, law) for law in laws]
        tried = side_by_side(partial(fitted_in_place, problem, index), starts)
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
    fitted = finer_in_place(problem, under_their_names(problem, fitted, first), first, last=True)
    for identifier in [effect.identifier for effect in fitted.model.effects[first:]]:
        index = [effect.identifier for effect in fitted.model.effects].index(identifier)
        effect = fitted.model.effects[index]
        simple = effect.simplified()
        if simple is not None and _is_at_bound(problem, effect, simple):
            own = Hypothesis(identifier, fitted, prior_penalty(problem, effect))
            plainer = fitted_in_place(problem, index, fitted.model.replaced(index, simple))
            fitted = in_order([own, *([plainer] if plainer else [])])[0].fitted
    return fitted


def in_least_minima(problem: Problem, fitted: Fitted, first: int) -> Fitted:
    """The model with its effects at the least of the minima that their laws know to have, where that is a lower one.

    That of a force which sets in half a period later, with the other sign, leaves hardly more than noise either.
    """
    for index in range(first, len(fitted.model.effects)):
        laws = restarts_of(problem, fitted, fitted.model.effects[index])
        starts = [fitted.model.replaced(index, law) for law in laws]
        own = Hypothesis("", fitted, prior_penalty(problem, fitted.model.effects[index]))
        tried = side_by_side(partial(fitted_in_place, problem, index), starts)
        fitted = in_order([own, *(h for h in tried if h is not None)])[0].fitted
    return fitted


def under_their_names(problem: Problem, fitted: Fitted, first: int) -> Fitted:
    """The model with laws that general ones were a detour to, where they say as much with fewer numbers."""
    for index in range(first, len(fitted.model.effects)):
        fitted = _under_its_name(problem, fitted, index)
    return fitted


def _under_its_name(problem: Problem, fitted: Fitted, index: int) -> Fitted:
    """The model with a law that a general one is a detour to in its place, where that is likelier: of fewer numbers.

    A loop that saturates at once is dry friction, which may turn round over a range of speeds; friction that falls at
    speeds that a free decay hardly has is as large as at usual ones.
    """
    effect = fitted.model.effects[index]
    special = special_case(effect)
    if special is None or special.identifier in {e.identifier for e in fitted.model.effects}:
        return fitted
    starts = [
        fitted.model.replaced(index, law) for law in (special, *_of_equal_work(problem, fitted.model, effect, special))
    ]
    plains = [h for h in side_by_side(partial(fitted_in_place, problem, index), starts) if h is not None]
    if not plains:
        return fitted
    plain = in_order(plains)[0]
    law = plain.fitted.model.effects[index]
    laws = [each for each in finer_of(problem, plain.fitted.model, law) if each.identifier == law.identifier]
    starts = [plain.fitted.model.replaced(index, each) for each in laws]
    tried = side_by_side(partial(fitted_in_place, problem, index), starts)
    own = Hypothesis(effect.identifier, fitted, prior_penalty(problem, effect))
    return in_order([own, plain, *(h for h in tried if h is not None)])[0].fitted


def _of_equal_work(problem: Problem, model: Model, effect: Effect, special: Effect) -> list[Effect]:
    """A special case scaled until it takes as much work from the motion as the effect does; none without a force."""
    seen = problem.situations(model).of(type(effect))
    motion = seen.time, seen.position, seen.velocity, seen.signal
    try:
        works = [float(force_along(law, seen.plant, motion) @ seen.velocity) for law in (effect, special)]
        ratio = works[0] / works[1] if works[1] != 0.0 else 0.0
        return [special.scaled(ratio)] if 0.0 < ratio < np.inf else []
    except (ValueError, ArithmeticError):  # an effect that has run away says nothing
        return []


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
    others = model.without(index)
    laws = [e for e in laws if e.identifier not in present and problem.kind.unseen_beside(type(e), others) is None]
    laws += possible_relatives(problem, model, index)
    tried = side_by_side(partial(fitted_in_place, problem, index), [model.replaced(index, law) for law in laws])
    found = in_order([h for h in tried if h is not None])
    return found[0] if found else None


def fitted_in_place(problem: Problem, index: int, model: Model) -> Hypothesis | None:
    """A fit of a model from where it is, as a hypothesis of one of its effects; None where it fails."""
    return fitted_hypothesis(problem, model.effects[index].identifier, model, ALL_STEPS, index=index)
