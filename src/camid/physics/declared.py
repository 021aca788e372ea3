"""Effects as simulation files declare them, and back."""

from __future__ import annotations

from collections.abc import Sequence

from camid.errors import InputError, nearest_match
from camid.physics import known_effects
from camid.physics.effect import Effect
from camid.simulation import DeclaredEffect, Simulation


def effects_of(simulation: Simulation) -> tuple[Effect, ...]:
    """Effects that a simulation declares.

    Raises
    ------
    InputError
        If an identifier or a parameter is not known, missing or out of range, or an effect stands twice.
    """
    found: list[Effect] = []
    for declared in simulation.effects:
        kind = known_effects().get(declared.identifier)
        if kind is None:
            raise InputError(
                f"no effect '{declared.identifier}'",
                where=declared.where,
                mend=nearest_match(declared.identifier, known_effects()),
            )
        if any(type(e) is kind for e in found):
            raise InputError(f"the effect '{declared.identifier}' stands twice", where=declared.where, mend="keep one")
        names = [p.name for p in kind.parameters]
        for name in declared.parameters:
            if name not in names:
                raise InputError(
                    f"{declared.identifier} has no parameter '{name}'",
                    where=declared.where,
                    mend=nearest_match(name, names) if names else "it has none",
                )
        try:
            found.append(kind(**declared.parameters))
        except (ValueError, TypeError) as error:
            raise InputError(str(error), where=declared.where, mend="see docs/effects.md") from None
    return tuple(found)


def declared(effects: Sequence[Effect], deviations: Sequence[dict[str, float | None]]) -> tuple[DeclaredEffect, ...]:
    """Effects as a file declares them, with the standard deviations that are known."""
    return tuple(
        DeclaredEffect(e.identifier, dict(e.values), {k: v for k, v in d.items() if v is not None} or None)
        for e, d in zip(effects, deviations, strict=True)
    )
