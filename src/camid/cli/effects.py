"""``camid effects``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from camid.errors import InputError, nearest_match

if TYPE_CHECKING:
    from camid.effects.base import Effect
    from camid.effects.parameter import Parameter

# A bound that only keeps a divisor from being zero.
TINY = 1e-100
# What the letters of a law mean where it acts, and its sign.
AT = {
    "actuator": "u is the command, and u' what arrives at the plant",
    "plant": "a force f is in units of u and acts against the motion: what drives the plant is u - f",
    "disturbance": "a force d is in units of u and adds to what drives the plant: u + d",
    "sensor": "y is the motion, w what the sensor makes of it, and w_k the reading of row k, at t_k",
    "noise": "n_k adds to the reading of row k",
}


@click.command(short_help="What the catalogue holds: laws, parameters, units.")
@click.argument("identifier", metavar="[ID]...", nargs=-1)
def effects(*, identifier: tuple[str, ...]) -> None:
    """Say what the effects with these IDs are: law, sign, parameters with their units, source; without an ID, list all.

    They are what a simulation may hold under effects, and what camid diagnose searches for.
    """
    from camid.effects import PLACES, known_effects

    known = known_effects()
    for one in identifier:
        if one not in known:
            raise InputError(f"no effect '{one}'", hint=nearest_match(one, known))
    if not identifier:
        for place in PLACES:
            click.echo(f"{place}:")
            for name in sorted(name for name, kind in known.items() if kind.place == place):
                click.echo(f"  {name:28} {known[name].title}")
        click.echo("camid effects ID says what one of them is")
    for index, one in enumerate(identifier):
        if index:
            click.echo()
        _say(known[one])


def _say(kind: type[Effect]) -> None:
    from camid.effects.law_text import law_text

    summary = " ".join((kind.__doc__ or "").strip().splitlines()[0].split())
    click.echo(f"{kind.identifier}: {summary[0].lower()}{summary[1:]}")
    plant = "; G(s) is the plant without the effect" if "G(" in kind.equation else ""
    click.echo(f"  place:  {kind.place}; {AT[kind.place]}{plant}")
    click.echo(f"  law:    {law_text(kind.equation)}")
    _say_parameters(kind.parameters)
    click.echo(f"  source: {kind.reference}")
    _say_entry(kind, [])
    for law in kind.finer_laws:
        more = [p for p in law.parameters if p not in kind.parameters]
        # What belongs to a declared plant, as the sine of a pendulum's does, no file has as an effect.
        if more and kind.with_keys(p.name for p in law.parameters) is law:
            click.echo(f"  with {' and '.join(p.name for p in more)}: {law.title[0].lower()}{law.title[1:]}")
            click.echo(f"  law:    {law_text(law.equation)}")
            _say_parameters(more)
            click.echo(f"  source: {law.reference}")
            _say_entry(law, more)


def _say_entry(law: type[Effect], more: list[Parameter]) -> None:
    """How a simulation declares a law; the keys that say which law of a name it is stand there though they may not."""
    keys = [p for p in law.parameters if p.default is None or p in more]
    values = ", ".join(f"{p.name}: {p.default if p.choices and p.default is not None else '…'}" for p in keys)
    click.echo(f"  file:   - {{id: {law.identifier}, parameters: {{{values}}}}}")


def _say_parameters(parameters: tuple[Parameter, ...] | list[Parameter]) -> None:
    for p in parameters:
        unit = " or ".join(p.choices) if p.choices else p.unit or "a number"
        bounds = [
            *(
                [f"from {p.lower:g}" if abs(p.lower) > TINY or p.lower == 0.0 else "above 0"]
                if p.is_number and abs(p.lower) < float("inf")
                else []
            ),
            *([f"to {p.upper:g}"] if p.is_number and abs(p.upper) < float("inf") else []),
        ]
        default = "" if p.default is None else f"; {p.default} where nothing is said"
        click.echo(f"    {p.name} [{unit}]: {p.meaning}{', ' if bounds else ''}{' '.join(bounds)}{default}")
