"""A design in words and in a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from camid.diagnosis.report.summary import title_of
from camid.experiment_design.columns import Column, Columns
from camid.experiment_design.result import Design, Determined, Expectation
from camid.experiment_design.sums import laws_that_are_sums
from camid.number_text import number, percentage, plain, printable, span, typeset, with_deviation
from camid.simulation.model import Simulation

# Weight of a name from which a sentence says what is expected if it is right.
LIKELY = 0.1
# Expected difference of the criterion below which an experiment tells next to nothing (Kass & Raftery 1995).
LEAST_EVIDENCE = 2.0
NOTHING_TELLS = "No experiment that was looked at tells these apart within the limits of the recording."
# Names of the numbers of families, and their units.
NUMBERS = {
    "hold": ("held for", "s"),
    "levels": ("levels", ""),
    "order": ("order", ""),
    "share": ("share of the range", ""),
    "lowest_frequency": ("from", "Hz"),
    "highest_frequency": ("to", "Hz"),
    "first_frequency": ("from", "Hz"),
    "last_frequency": ("to", "Hz"),
    "frequency": ("at", "Hz"),
    "push": ("pushed for", "s"),
    "free": ("released for", "s"),
    "lines": ("lines", ""),
    "position": ("from", "y"),
}


def described(kind: str, numbers: dict[str, Any], columns: Columns | None = None) -> str:
    """An input in words: ``steps (7 levels, held for 0.44 s)``; positions are those of the columns."""
    if "first_half" in numbers:
        halves = (numbers["first_half"], numbers["second_half"])
        return ", then ".join(
            described(h["kind"], {k: v for k, v in h.items() if k != "kind"}, columns) for h in halves
        )
    parts = []
    for key, value in numbers.items():
        if key not in NUMBERS or key == "share":
            continue
        words, unit = NUMBERS[key]
        shown = plain(value, 3, unit)
        if key == "position" and columns is not None:
            shown = plain(float(columns.outputs.cells(np.array(value))), 3, columns.output_unit)
        counted = words if value != 1 else words.removesuffix("s")
        parts.append(f"{shown} {counted}" if key in {"levels", "lines"} else f"{words} {shown}")
    return f"{kind} ({', '.join(parts)})" if parts else kind


def sentence(design: Design) -> str:
    """A design in a few sentences, for a report: what to play, what to expect of it, and what it leaves open."""
    columns = Columns.of(design.hypotheses[0].simulation)
    signal, unit = columns.inputs.cells(design.played.signal), columns.input_unit
    text = (
        f"Play {described(design.kind, design.described, columns)} for {plain(design.duration, 3, 's')} between "
        f"{plain(float(signal.min()))} and {plain(float(signal.max()), unit=unit)}"
    )
    if not design.expectations:
        return f"{text}: it determines the coefficients best."
    weights = {h.identifier: h.weight for h in design.hypotheses}
    likely = [e for e in design.expectations if weights[e.identifier] >= LIKELY] or design.expectations
    decides_none = all(e.seconds is None for e in likely)
    if decides_none:
        text = f"No experiment that was looked at decides within the limits of the recording. What tells most: {text}"
    left = [
        f" If it is {title_of(law.special)}, {title_of(law.identifier)} stays possible whatever is played."
        for law in laws_that_are_sums([h for h in design.hypotheses if weights[h.identifier] >= LIKELY])
    ]
    if decides_none and max(e.evidence for e in likely) < LEAST_EVIDENCE:
        return f"{NOTHING_TELLS}{''.join(left)}"
    return f"{text}. Expected {'; '.join(_expected(e, design.duration) for e in likely)}.{''.join(left)}"


def _expected(expectation: Expectation, duration: float) -> str:
    """What an experiment says if one name is right."""
    e = expectation
    text = f"if it is {title_of(e.identifier)}: ΔBIC {number(e.evidence, 2)} against {title_of(e.rival)}, "
    if e.seconds is None:
        return f"{text}its weight {percentage(e.weight, 2)} afterwards, and never 95 %"
    after = f"{text}95 % after about {number(e.seconds, 2)} s"
    return f"{after}, which is longer than this experiment" if e.seconds > duration else after


def print_design(design: Design, written: list[Path]) -> None:
    """Print what to play, what to expect of it and what it was chosen from, for a person."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False, emoji=False)
    limits, played = design.limits, design.played
    columns = Columns.of(design.hypotheses[0].simulation)
    unit, output = columns.input_unit, columns.output_unit

    def cells(column: Column, values: tuple[float, float]) -> tuple[float, float]:
        low, high = sorted(column.cells(np.array(values)).tolist())
        return low, high

    console.print(f"▶ {described(design.kind, design.described, columns)}", style="bold", soft_wrap=True)
    signal = columns.inputs.cells(played.signal)
    travel = cells(columns.outputs, design.travel)
    console.print(
        f"{len(signal)} rows, {plain(design.duration, 4, 's')} at {plain(1.0 / played.period, 4)} frames per second; "
        f"input {span((float(signal.min()), float(signal.max())), unit)}, "
        f"travel {span(travel, output)} under every hypothesis",
        soft_wrap=True,
    )
    if played.exposure is not None:
        console.print(f"exposure {plain(played.exposure, 4, 's')}", soft_wrap=True)
    if played.position is not None:
        start = plain(float(columns.outputs.cells(np.array(played.position))), 4, output)
        console.print(
            f"released at rest from {start}: diagnose with initial_state: estimate",
            soft_wrap=True,
        )
    if design.expectations:
        console.print(_table_of_names(design, Table(title="What to expect", title_justify="left")))
    else:
        table = Table(title="Standard deviations", title_justify="left")
        for heading in ("parameter", "known now", "after the experiment", "unit"):
            table.add_column(heading)
        for one in design.determined:
            table.add_row(one.name, *deviations_shown(one, design.hypotheses[0].simulation))
        console.print(table)
    rate = "" if limits.rate == float("inf") else f", {plain(limits.rate / abs(columns.inputs.factor), 4)} {unit}/s"
    allowed = "" if limits.travel is None else f", travel {span(cells(columns.outputs, limits.travel), output)}"
    console.print(
        f"limits: input {span(cells(columns.inputs, (limits.low, limits.high)), unit)}{rate}{allowed}, "
        f"{plain(limits.duration, 4, 's')}; {design.looked_at} experiments looked at",
        soft_wrap=True,
    )
    for path in written:
        console.print(f"written to {printable(str(path))}", soft_wrap=True)


def deviations_shown(one: Determined, simulation: Simulation) -> list[str]:
    """Value with its standard deviation before and after the experiment, and their unit, as people read them."""
    units, named = simulation.units, simulation.physical
    if named is not None and one.name in named.units:
        return [*(with_deviation(one.value, d) for d in (one.before, one.after)), typeset(one.unit)]
    value, before, after = (units.shown(v, one.unit) for v in (one.value, one.before, one.after))
    return [*(with_deviation(value, d) for d in (before, after)), units.text(one.unit)]


def _table_of_names(design: Design, table: Any) -> Any:
    for heading in ("if this is right", "nearest rival", "ΔBIC", "a second", "weight", "95 % after"):
        table.add_column(heading, overflow="fold")
    for e in design.expectations:
        seconds = "never" if e.seconds is None else f"{number(e.seconds, 2)} s"
        if e.seconds is not None and e.seconds > design.duration:
            seconds += " (longer)"
        table.add_row(
            title_of(e.identifier),
            title_of(e.rival),
            number(e.evidence, 2),
            number(e.evidence_per_second, 2),
            percentage(e.weight, 2),
            seconds,
        )
    return table
