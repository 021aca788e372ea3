"""Effects as simulation files declare them, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, isfinite

from camid.effects.base import Effect
from camid.effects.known import declarable_effects
from camid.effects.parameter import Parameter
from camid.errors import InputError, nearest_match
from camid.simulation.model import DeclaredEffect, Simulation


def effects_of(simulation: Simulation) -> tuple[Effect, ...]:
    """Effects that a simulation declares.

    Raises
    ------
    InputError
        If an identifier or a parameter is not known, missing or out of range, or an effect is declared twice.
    """
    found: list[Effect] = []
    for written in simulation.effects:
        kind = declarable_effects().get(written.identifier)
        if kind is None:
            raise InputError(
                f"no effect '{written.identifier}'",
                where=written.where,
                hint=_where_to_find_it(written.identifier),
            )
        declared = _without_nulls(written, kind)
        if kind.listed and any(e.identifier == kind.identifier for e in found):
            raise InputError(
                f"the effect '{declared.identifier}' is declared twice", where=declared.where, hint="keep one"
            )
        kind = kind.with_keys(declared.parameters)
        names = [p.name for p in kind.parameters]
        keys = list(dict.fromkeys([*names, *(p.name for law in kind.finer_laws for p in law.parameters)]))
        for name in declared.parameters:
            if name not in names:
                raise InputError(
                    f"{declared.identifier} has no parameter '{name}'",
                    where=declared.where,
                    hint=nearest_match(name, keys) if names else "it has none",
                )
        for parameter in kind.parameters:
            _refuse_value(declared, parameter)
        try:
            found.append(kind(**declared.parameters))
        except (ValueError, TypeError) as error:
            raise InputError(
                str(error), where=declared.where, hint="; ".join(f"{p.name}: {p.meaning}" for p in kind.parameters)
            ) from None
    return tuple(found)


def _without_nulls(declared: DeclaredEffect, kind: type[Effect]) -> DeclaredEffect:
    """Without parameters that are null where nothing has to be said: a learned law's formula that is not known."""
    optional = {p.name for p in kind.parameters if p.default is not None}
    said = {name: v for name, v in declared.parameters.items() if v is not None or name not in optional}
    return replace(declared, parameters=said)


def _where_to_find_it(identifier: str) -> str:
    """What may be meant by an identifier that is not known."""
    near = nearest_match(identifier, declarable_effects())
    own = "an effect of your own needs its file: --effects FILE.py"
    return f"{near} {own}" if near.endswith("?") else f"{own}; {near}"


def _refuse_value(declared: DeclaredEffect, parameter: Parameter) -> None:
    """Refuse a value that is missing, of another kind or out of range."""
    name = f"{declared.identifier}, {parameter.name}"
    unit = f" in {parameter.unit}" if parameter.unit else ""
    if parameter.name not in declared.parameters:
        if parameter.default is not None:
            return
        raise InputError(
            f"{declared.identifier} needs the parameter '{parameter.name}'",
            where=declared.where,
            hint=f"add it: {parameter.meaning}{unit}",
        )
    value = declared.parameters[parameter.name]
    if parameter.is_name:
        if not isinstance(value, str):
            raise InputError(f"{name}: {value!r} is not a name", where=declared.where, hint=parameter.meaning)
        return
    if parameter.choices:
        if value not in parameter.choices:
            raise InputError(
                f"{name}: '{value}' is not one of {', '.join(parameter.choices)}",
                where=declared.where,
                hint=nearest_match(str(value), parameter.choices),
            )
        return
    numbers = value if parameter.sequence and isinstance(value, list | tuple) else [value]
    for number in numbers:
        if isinstance(number, bool) or not isinstance(number, int | float) or not isfinite(number):
            raise InputError(
                f"{name}: {number!r} is not a finite number", where=declared.where, hint=f"{parameter.meaning}{unit}"
            )
        low, high = parameter.lower, parameter.upper
        if not low <= number <= high:
            # A tiny lower bound means "positive".
            least = "positive" if 0.0 < low < 1e-200 else f"at least {low:g}"
            bounds = least if high == inf else f"at most {high:g}" if low == -inf else f"from {low:g} to {high:g}"
            raise InputError(f"{name} = {number:g}", where=declared.where, hint=f"it must be {bounds}")


def declared(effects: Sequence[Effect], deviations: Sequence[dict[str, float | None]]) -> tuple[DeclaredEffect, ...]:
    """Effects as a file declares them, in the order in which they act, with the standard deviations that are known."""
    in_order = sorted(zip(effects, deviations, strict=True), key=lambda pair: not pair[0].leads)
    return tuple(
        DeclaredEffect(e.identifier, e.stated(), {k: v for k, v in d.items() if v is not None} or None)
        for e, d in in_order
    )
