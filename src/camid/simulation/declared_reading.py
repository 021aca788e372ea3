"""How a simulation file declares the way a recording is read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from camid.errors import InputError, nearest_match
from camid.recording.options import Reading
from camid.recording.units import Conversion, si_factor
from camid.simulation.yaml_file import Where

if TYPE_CHECKING:
    from camid.simulation.schema import RecordingPart, SimulationFile, TimePart


def declared_reading(file: SimulationFile, where: Where) -> Reading:
    """What a simulation file says about the layout, rows and units of a recording.

    Parameters
    ----------
    file : SimulationFile
    where : callable
        Gives file, line and key of a path of keys.

    Raises
    ------
    InputError
        If keys contradict each other, or a unit is unknown or of the wrong kind.
    """
    from camid.simulation.schema import RecordingPart

    written = RecordingPart.model_construct() if file.recording is None else file.recording
    _check_time(file.time, where)
    _check_layout(written, where)
    _check_runs(file, where)
    return Reading(
        separator=written.separator,
        decimal=written.decimal,
        header=written.header,
        columns=tuple(written.columns or ()),
        group=written.group,
        experiment=None if written.experiment is None else written.experiment.column,
        runs=tuple(dict(run) for run in written.runs or ()),
        start=written.start,
        end=written.end,
        leave_out=written.leave_out,
        gaps=written.gaps,
        missing=written.missing,
        period=file.time.period,
        frame_time=_frame_time(file, where),
        time=_conversion(file.time, "time", where),
        input=_conversion(file.input, "input", where),
        output=_conversion(file.sensor, "sensor", where),
        reference=_conversion(file.controller, "controller", where),
        added=_added(file, where),
        where=where("recording"),
    )


def _added(file: SimulationFile, where: Where) -> dict[str, Conversion]:
    """Columns that are added to the input."""
    written = [] if file.input is None else file.input.added or []
    if written and file.controller is not None:
        raise InputError(
            "a controller makes the input, and a signal is added to it",
            where=where("input", "added"),
            hint="add signals to an input that is recorded, in open loop",
        )
    added: dict[str, Conversion] = {}
    for i, part in enumerate(written):
        if part.column in added or (file.input is not None and part.column == file.input.column):
            raise InputError(
                f"column '{part.column}' is named twice", where=where("input", "added", i), hint="scale it instead"
            )
        added[part.column] = _conversion(part, ("input", "added", i), where)
    return added


def _check_runs(file: SimulationFile, where: Where) -> None:
    """Refuse runs that rename what the simulation does not name."""
    written = [] if file.recording is None else file.recording.runs or []
    parts = [file.time, file.input, file.sensor]
    named = {getattr(p, "column", None) for p in parts} | set(_added(file, where))
    if file.controller is not None:
        named.add(file.controller.reference)
    for i, run in enumerate(written):
        for name in run:
            if name not in named:
                raise InputError(
                    f"the simulation names no column '{name}'",
                    where=where("recording", "runs", i),
                    hint=nearest_match(name, sorted(n for n in named if n is not None)),
                )


def _frame_time(file: SimulationFile, where: Where) -> str | None:
    """Column with the times of the frames; InputError where they cannot have any of their own."""
    column = file.sensor.time
    if column is None:
        return None
    if file.input is None or file.controller is not None:
        raise InputError(
            "without an input the times of the frames are the time column"
            if file.input is None
            else "a controller samples where its input changes, and frames have times of their own",
            where=where("sensor", "time"),
            hint="leave it out",
        )
    if file.time.period is not None:
        raise InputError(
            "frames have times of their own, and the input has none",
            where=where("time", "period"),
            hint="name the time column of the input",
        )
    return column


def _check_time(time: TimePart, where: Where) -> None:
    if time.period is not None and time.column is not None:
        raise InputError("period and column are both given", where=where("time"), hint="keep one of them")
    if time.period is None and time.column is None:
        raise InputError("the key 'column' is missing", where=where("time"), hint="add it")
    if time.period is not None and time.unit is not None:
        raise InputError("a period is in seconds", where=where("time", "unit"), hint="remove the unit")


def _check_layout(written: RecordingPart, where: Where) -> None:
    names = written.columns
    if written.header and names is not None:
        raise InputError(
            "columns are named for a file without a header line",
            where=where("recording", "columns"),
            hint="say header: false, or remove them",
        )
    if not written.header and names is None:
        raise InputError(
            "without a header line the columns have no names",
            where=where("recording", "header"),
            hint="name them: columns: [t, u, y]",
        )
    if names is not None and len(set(names)) < len(names):
        raise InputError(
            "a name appears twice", where=where("recording", "columns"), hint="name each column differently"
        )
    if written.start is not None and written.end is not None and not written.start < written.end:
        raise InputError("start is not before end", where=where("recording"), hint="swap them")


def _conversion(part: Any, keys: str | tuple[Any, ...], where: Where) -> Conversion:
    """Conversion of the column that a part of the file names; a part that is not there has the default one."""
    from camid.simulation.schema import Converted

    path = (keys,) if isinstance(keys, str) else keys
    unit, scale = getattr(part, "unit", None), getattr(part, "scale", 1.0)
    offset = part.offset if isinstance(part, Converted) else 0.0  # that of a sensor belongs to the model
    if scale == 0.0:
        raise InputError("a scale of zero makes every number zero", where=where(*path, "scale"), hint="give another")
    if unit is not None:
        si_factor(unit, where(*path, "unit"), "[time]" if keys == "time" else None)
    return Conversion(unit, scale, offset, where(*path))
