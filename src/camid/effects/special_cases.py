"""What effects are special cases and sums of: of other names, in the same detail where the catalogue has such laws."""

from __future__ import annotations

from camid.effects import known_effects
from camid.effects.base import Effect


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
