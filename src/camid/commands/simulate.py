"""``camid.simulate``: the output of a simulation for the input of a recording, row by row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.effects.declared import effects_of
from camid.effects.own_effects import EffectSource, own_effects, own_effects_in_use
from camid.errors import InputError
from camid.fitting.from_simulation import kind_of
from camid.fitting.simulated_output import simulated_output, simulated_readings
from camid.identification.from_recordings import (
    RecordingSource,
    SimulationSource,
    acquisition_of,
    load_recordings,
    warnings_of,
    with_units_of_headers,
)
from camid.recording.recording import Recording
from camid.recording.time_grid import spline
from camid.simulation.declared_units import DeclaredUnits
from camid.simulation.file import load_simulation
from camid.simulation.model import Simulation

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd


Array = NDArray[np.float64]


def simulate(
    recording: RecordingSource,
    simulation: SimulationSource,
    *,
    effects: Sequence[EffectSource] | EffectSource = (),
) -> pd.DataFrame:
    """Run a simulation on the input of a recording.

    Parameters
    ----------
    recording : path or DataFrame
    simulation : path, mapping or Simulation
        Effects included. Those that change the noise alone (quantisation, outliers, …) leave the expected output as
        it is.
    effects : sequence of path or subclass of Effect, optional
        Effects of your own that the simulation may name. A file is Python, and is run.

    Returns
    -------
    DataFrame
        One row a recorded row, in order and in SI units: the time column, ``simulated`` (``simulated_`` and a name for
        each of several columns) and, where it is recorded, the output column; ``experiment`` before them where a file
        holds several.
        ``attrs["warnings"]`` says what was done to the rows, if anything, and ``attrs["units"]`` what
        the file has input and output in.

    Raises
    ------
    InputError
        If recording and simulation do not fit together, the initial state, an offset or a bias is to be fitted and
        there is no output, the latency is not known yet, or an effect of your own is wrong.
    """
    with own_effects(effects):
        return simulated_table(recording, load_simulation(simulation))


def _what_to_check(believed: Simulation) -> str:
    """What may be wrong where a simulated output is no number."""
    own = [kind.identifier for kind in own_effects_in_use()]
    declared = [effect.identifier for effect in believed.effects if effect.identifier in own]
    if declared:
        return f"does your own effect {' or '.join(declared)} return a finite number everywhere, with these parameters?"
    if believed.physical is not None and believed.physical.equations is not None:
        return "do the equations give a number in every state? sqrt(max(level, 0)) does"
    return "check the transfer function and the units of the input"


def simulated_table(
    recording: RecordingSource, believed: Simulation, held_out: Sequence[tuple[float, float]] = ()
) -> pd.DataFrame:
    """Table of the simulated output for every experiment in a recording; see :func:`simulate`.

    An initial state that is to be estimated is not fitted to rows between the starts and ends, in seconds, of
    ``held_out``.
    """
    import pandas as pd

    recordings = load_recordings(recording, believed, output_needed=believed.is_fitted_to_output)
    columns = [f"simulated_{name}" for name in believed.output_columns]
    added = {
        *columns,
        *kind_of(believed, recordings).simulated_columns,
        *(["experiment"] if len(recordings) > 1 else []),
    }
    for name in (believed.time_column, *(believed.output_columns or (believed.output_column,))):
        if name in added:
            raise InputError(
                f"a recorded column is called '{name}' like the result",
                where=believed.source,
                hint="rename the column",
            )
    parts, compared_from = [], {}
    for one in recordings:
        control: Array | None = None
        rows = _rows_between(one, held_out) if held_out else None
        if believed.output_columns:
            readings = {f"simulated_{name}": v for name, v in simulated_readings(believed, one, rows).items()}
        else:
            output, control = simulated_output(believed, one, rows)
            readings = {"simulated": output}
        if not all(np.all(np.isfinite(values)) for values in readings.values()):
            raise InputError(
                "the simulated output exceeds every floating-point number",
                where=believed.source,
                hint=_what_to_check(believed),
            )
        table: dict[str, Any] = {"experiment": one.experiment} if len(recordings) > 1 else {}
        # Where the file's times are irregular, the simulation ran on a grid: back to the recorded times.
        on_grid = one.recorded_time is one.time
        table |= {
            believed.time_column: one.recorded_time,
            **{n: v if on_grid else spline(one.time, v, one.recorded_time) for n, v in readings.items()},
        }
        if control is not None:  # it is held between the samples of the controller
            held = np.clip(np.searchsorted(one.time, one.recorded_time + 0.5 * one.period) - 1, 0, len(control) - 1)
            table["simulated_input"] = control if on_grid else control[held]
            table[str(believed.input_column)] = one.recorded_columns.get(
                str(believed.input_column), one.columns[str(believed.input_column)]
            )
        for name in believed.output_columns or (believed.output_column,):
            if name in one.recorded_columns:
                table[name] = one.recorded_columns[name]
        parts.append(pd.DataFrame(table))
        compared_from[one.experiment or ""] = _compared_from(believed, one)
    result = parts[0] if len(parts) == 1 else pd.concat(parts, ignore_index=True)
    if said := [*warnings_of(recordings), *_left_out(believed)]:
        result.attrs["warnings"] = said
    reading = with_units_of_headers(believed, recordings).reading
    result.attrs["compared_from"] = compared_from
    result.attrs["units"] = {"input": reading.input.unit, "output": reading.output.unit}
    return result


def _left_out(believed: Simulation) -> list[str]:
    """What a simulated output does not show, in a sentence if there is something."""
    noise = [e.identifier for e in effects_of(believed) if e.noise_like]
    if not noise:
        return []
    change = "changes" if len(noise) == 1 else "change"
    names = " and ".join(noise)
    return [f"the simulated output is the expected one: {names} {change} only what is scattered around it"]


def _compared_from(believed: Simulation, recording: Recording) -> float:
    """Seconds from which on a recording says something of a simulation.

    Where the initial state is estimated, what the input did before the record is unknown, and so are frames exposed
    then.
    """
    hidden = 0
    if believed.estimates_initial_state and believed.input_column is not None:
        hidden = acquisition_of(recording, believed).window()[0]
    return float(recording.time[0] + (hidden - 0.5) * recording.period)


def rows_compared(simulation: Simulation, table: pd.DataFrame) -> NDArray[np.bool_]:
    """Rows of a table of :func:`simulated_table`, shape (N,), that say something of the simulation."""
    time = table[simulation.time_column].to_numpy(dtype=float)
    labels = table["experiment"] if "experiment" in table else [""] * len(table)
    return np.array(time >= np.array([table.attrs["compared_from"][label or ""] for label in labels]))


def units_of_table(simulation: Simulation, table: pd.DataFrame) -> DeclaredUnits:
    """What people read the values of a table of :func:`simulated_table` in; itself, it is in SI units."""
    found = table.attrs.get("units", {})
    reading = simulation.reading
    parts = {name: replace(getattr(reading, name), unit=unit) for name, unit in found.items()}
    return replace(simulation, reading=replace(reading, **parts)).units


def _rows_between(recording: Recording, spans: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    return np.any([(recording.time >= start) & (recording.time <= end) for start, end in spans], axis=0)
