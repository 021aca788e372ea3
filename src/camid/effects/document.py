"""The catalogue as a table for docs/effects.md; ``python -m camid.effects docs/effects.md`` puts it there."""

from __future__ import annotations

from pathlib import Path

from camid.effects import PLACES, known_effects
from camid.effects.base import Effect

BEGIN, END = "<!-- catalogue: begin -->", "<!-- catalogue: end -->"


def table() -> str:
    """Markdown table of all effects, in the order of the chain: identifier, parameters, equation, reference."""
    lines = ["| effect | place | parameters (unit) | equation | reference |", "|---|---|---|---|---|"]
    effects = sorted(known_effects().values(), key=lambda e: (PLACES.index(e.place), e.identifier))
    lines += [
        f"| `{e.identifier}` {e.title} | {e.place} | {_parameters(e)} | $`{_one_line(e.equation)}`$ | {e.reference} |"
        for e in effects
        if e.__module__.startswith("camid.")
    ]
    return "\n".join(lines)


def updated(document: str) -> str:
    """The document with the table of today between its two marks.

    Raises
    ------
    ValueError
        If a mark is missing.
    """
    if BEGIN not in document or END not in document:
        raise ValueError(f"the document lacks the mark {BEGIN} or {END}")
    before, rest = document.split(BEGIN, 1)
    return f"{before}{BEGIN}\n\n{table()}\n\n{END}{rest.split(END, 1)[1]}"


def write(path: Path) -> None:
    """Update a document in place."""
    path.write_text(updated(path.read_text(encoding="utf-8")), encoding="utf-8")


def _one_line(equation: str) -> str:
    # A bar would end the cell of the table.
    return equation.replace("\n", " ").replace("|", r"\vert ")


def _parameters(effect: type[Effect]) -> str:
    shown = []
    for parameter in effect.parameters:
        unit = " or ".join(parameter.choices) if parameter.choices else parameter.unit or "–"
        shown.append(f"`{parameter.name}` ({unit}): {parameter.meaning}")
    return "<br>".join(shown) or "–"
