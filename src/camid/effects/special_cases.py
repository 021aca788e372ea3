"""What effects are special cases and sums of: of other names, in the same detail where the catalogue has such laws."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set

from camid.effects import known_effects
from camid.effects.base import Effect
from camid.effects.situation import Situation


def special_case(effect: Effect) -> Effect | None:
    """The nearest special case of another name; None if there is none.

    It has the detail that the effect has beyond the plain law of its name, where a law of the special case has such:
    friction that turns round gradually, and falls with the speed, is not dry friction that turns round at once.
    """
    special = effect.simplified()
    while special is not None and special.identifier == effect.identifier:
        special = special.simplified()
    if special is None:
        return None
    more = {name: effect.values[name] for name in detail_of(effect) if name not in special.values}
    law = type(special).with_keys([*special.values, *more])
    return law(**special.values, **more) if {*special.values, *more} <= {p.name for p in law.parameters} else special


def detail_of(effect: Effect) -> list[str]:
    """Names of the parameters that an effect has beyond those of the plain law of its name."""
    plain = {p.name for p in known_effects().get(effect.identifier, type(effect)).parameters}
    return [name for name in effect.values if name not in plain]


def in_the_same_detail(kind: type[Effect], effect: Effect) -> type[Effect]:
    """The law of a kind that has an effect's detail; the plain one where no law of it has."""
    return kind.with_keys([*(p.name for p in kind.parameters), *detail_of(effect)])


def sums_with(identifier: str, named: Set[str], effects: Sequence[Effect], *, constant: bool) -> list[type[Effect]]:
    """Laws that are exactly an effect together with what stands beside it, in the detail that it has.

    Parameters
    ----------
    identifier : str
        Of the effect.
    named : set of str
        All effects of a model, this one among them.
    effects : sequence of Effect
        As the model holds them.
    constant : bool
        Whether a constant at input or sensor is estimated, which stands for the other.
    """

    def holds(part: str) -> bool:
        return part in named or (constant and is_constant(part))

    found = []
    for kind in known_effects().values():
        laws = [in_the_same_detail(kind, effect) for effect in effects if effect.identifier in kind.sum_of]
        exact = bool(kind.sum_of) and all(law.sum_of for law in laws) and all(holds(part) for part in kind.sum_of)
        if exact and any(part == identifier or is_constant(part, identifier) for part in kind.sum_of):
            found.append(kind)
    return found


def same_in_place(effect: Effect, situation_of: Callable[[type[Effect]], Situation]) -> list[Effect]:
    """The laws of other names that do exactly what an effect does in a recording.

    Parameters
    ----------
    effect : Effect
    situation_of : callable
        The recording as a kind of effect sees it.
    """
    found = (kind.same_as(effect, situation_of(kind)) for kind in known_effects().values())
    return [each for each in found if each is not None]


def is_constant(*names: str) -> bool:
    """Whether effects of these names add a constant to a signal."""
    return all(name in known_effects() and known_effects()[name].is_constant for name in names)
