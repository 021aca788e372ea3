"""``camid.compare``: recorded and simulated outputs of several models, with the fit in per cent."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.analysis.comparison import CONTROL, OUTPUT, ComparedSignal, Comparison, rows_between
from camid.analysis.models import ModelSource, named_models
from camid.commands.simulate import rows_compared, simulated_table, units_of_table
from camid.errors import InputError
from camid.identification.from_recordings import RecordingSource
from camid.simulation.declared_units import SignalUnit
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]
Span = tuple[float, float]


def compare(
    recording: RecordingSource,
    *models: ModelSource,
    held_out: Span | None = None,
    zoom: Span | None = None,
) -> Comparison:
    """Simulate a recording with models, and say how well each follows it.

    Parameters
    ----------
    recording : path or DataFrame
    *models : path, mapping, Simulation or result of ``camid.identify`` or ``camid.diagnose``
        Of any kind, effects included; in a closed loop the control is compared, too.
    held_out : tuple of float, optional
        Start and end in seconds of the rows that were not fitted; those that the models declare as ``validation``.
    zoom : tuple of float, optional
        Start and end in seconds of what the picture shows; the fits are those of all rows.

    Returns
    -------
    Comparison
        ``fits`` and ``numbers`` are tables, ``figure()`` draws, ``save(path)`` writes.

    Raises
    ------
    InputError
        If recording and models do not fit together, or models hold out other rows or read other columns.
    """
    simulations = named_models(models)
    spans = _held_out(simulations, held_out)
    tables = {name: simulated_table(recording, simulation, spans) for name, simulation in simulations.items()}
    source = Path(recording).name if isinstance(recording, str | os.PathLike) else "the recording"
    signals = _signals(simulations, tables, spans, source)
    _refuse_empty(signals, held_out, zoom, source)
    said = [sentence for table in tables.values() for sentence in table.attrs.get("warnings", [])]
    return Comparison(signals, tuple(simulations), source, zoom, tuple(dict.fromkeys(said)))


def _held_out(simulations: Mapping[str, Simulation], asked: Span | None) -> list[Span]:
    """Spans in seconds that no model was fitted to."""
    for span in () if asked is None else (asked,):
        if not span[0] < span[1]:
            raise InputError(
                f"the held-out part starts at {span[0]:g} s and ends at {span[1]:g} s",
                hint="give the earlier one first",
            )
    if asked is not None:
        return [asked]
    declared = {name: s.validation for name, s in simulations.items() if s.validation is not None}
    if len(set(declared.values())) > 1:
        parts = ", ".join(f"{name}: {start:g} to {end:g} s" for name, (start, end) in declared.items())
        raise InputError(f"the models hold out different rows ({parts})", hint="say which with --held-out START END")
    return [*dict.fromkeys(declared.values())]


def _signals(
    simulations: Mapping[str, Simulation], tables: Mapping[str, pd.DataFrame], spans: list[Span], source: str
) -> list[ComparedSignal]:
    """The output of each experiment, or each of its columns, and its control where a model is a closed loop."""
    table = next(iter(tables.values()))
    experiments = [None] if "experiment" not in table else [*dict.fromkeys(table["experiment"])]
    leave_out = max(s.reading.leave_out for s in simulations.values())
    found = []
    for experiment in experiments:
        parts = {
            name: t if experiment is None else t[t["experiment"] == experiment].reset_index(drop=True)
            for name, t in tables.items()
        }
        for quantity in _quantities(simulations, tables, source):
            time, recorded, simulated = _same_rows(parts, simulations, quantity, source)
            compared, held_out = time >= time[0] + leave_out, rows_between(time, spans)
            for name in simulated:
                compared &= rows_compared(simulations[name], parts[name])
            found.append(
                ComparedSignal(
                    quantity.kind,
                    str(quantity.unit.column),
                    experiment,
                    time,
                    recorded,
                    simulated,
                    compared,
                    held_out,
                    quantity.unit,
                )
            )
    return found


@dataclass(frozen=True)
class _Quantity:
    """What is compared: its kind and unit, and for each model its columns, recorded and simulated."""

    kind: str
    unit: SignalUnit
    columns: Mapping[str, tuple[str, str]]


def _quantities(
    simulations: Mapping[str, Simulation], tables: Mapping[str, pd.DataFrame], source: str
) -> list[_Quantity]:
    """Outputs and controls that models have."""
    first, believed = next(iter(simulations.items()))
    outputs: dict[str, dict[str, tuple[str, str]]] = {}
    several = any(s.output_columns for s in simulations.values())
    for name, simulation in simulations.items():
        single = {simulation.output_column: "simulated"}
        columns = {c: f"simulated_{c}" for c in simulation.output_columns} or single
        if outputs and several and not set(columns) & set(outputs):
            raise InputError(
                f"{first} and {name} read different columns", where=source, hint="compare models of the same columns"
            )
        for column, result in columns.items():
            outputs.setdefault(column if several else "", {})[name] = column, result
    output = units_of_table(believed, tables[first]).output
    found = [
        _Quantity(OUTPUT, replace(output, column=label or output.column), columns) for label, columns in outputs.items()
    ]
    loops = [name for name, table in tables.items() if "simulated_input" in table]
    if loops:
        controls = {name: (str(simulations[name].input_column), "simulated_input") for name in loops}
        found.append(_Quantity(CONTROL, units_of_table(simulations[loops[0]], tables[loops[0]]).input, controls))
    return found


def _same_rows(
    tables: Mapping[str, pd.DataFrame], simulations: Mapping[str, Simulation], quantity: _Quantity, source: str
) -> tuple[Array, Array, dict[str, Array]]:
    """Times, what was recorded, and what each model makes of it; InputError where models read something else."""
    simulated: dict[str, Array] = {}
    reference: tuple[str, Array, Array] | None = None
    for name, (column, result) in quantity.columns.items():
        table = tables[name]
        if column not in table:
            raise InputError(f"no column '{column}' to compare with", where=source, hint="record the output, too")
        time, recorded = (table[c].to_numpy(dtype=float) for c in (simulations[name].time_column, column))
        if reference is None:
            reference = name, time, recorded
        other, times, values = reference
        same = len(time) == len(times) and np.allclose(time, times, rtol=1e-9, atol=1e-12)
        if not (same and np.allclose(recorded, values, rtol=1e-9, atol=0.0, equal_nan=True)):
            frames = {simulations[each].reading.frame_time for each in (other, name)}
            raise InputError(
                f"{other} and {name} read different values as the {quantity.kind}",
                where=source,
                hint="compare models with the same sensor.time: one of them counts in frames, the other in rows"
                if len(frames) > 1
                else "compare models that name the same columns, units, start and end",
            )
        simulated[name] = table[result].to_numpy(dtype=float)
    assert reference is not None
    return reference[1], reference[2], simulated


def _refuse_empty(signals: list[ComparedSignal], held_out: Span | None, zoom: Span | None, source: str) -> None:
    """Refuse spans that hold no row, and a recording of which nothing is left to compare."""
    for name, span in (("held-out", held_out), ("zoomed", zoom)):
        if span is None:
            continue
        if not any(np.count_nonzero(rows_between(s.time, [span])) > 1 for s in signals):
            first, last = min(s.time[0] for s in signals), max(s.time[-1] for s in signals)
            raise InputError(
                f"no two rows lie in the {name} part from {span[0]:g} to {span[1]:g} s",
                where=source,
                hint=f"the recording lasts from {first:g} s to {last:g} s",
            )
    if not any((s.compared & np.isfinite(s.recorded)).any() for s in signals):
        raise InputError("no row with an output is left to compare", where=source, hint="choose a shorter leave_out")
