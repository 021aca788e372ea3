"""How the file of a recording is read: what a simulation declares of the file's layout, rows and units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from camid.recording.units import Conversion


@dataclass(frozen=True)
class Reading:
    """How the file of a recording is read.

    Attributes
    ----------
    separator, decimal : str or None
        Between the cells and in the numbers of a text file; None: found. A blank matches any number of blanks.
    header : bool
        Whether a text file has a line with the names of its columns.
    columns : tuple of str
        The names where there is no such line.
    group : str or None
        HDF5 group, MAT structure or sheet that holds the columns, or several groups or structures that do; ``/`` is the
        whole file.
    experiment : str or None
        Column that tells several experiments in one table apart.
    runs : tuple of dict
        Runs side by side in one table: for each, the columns of the file in place of those that the simulation names.
    start, end : float or None
        Seconds of the time column; rows before start and after end are not read.
    leave_out : float
        Seconds at the start of each experiment that are simulated but not compared.
    gaps : {"refuse", "hold"}
        Whether the input may be held where rows of a driven recording are missing.
    missing : {"refuse", "leave-out"}
        Whether rows without output are left out of the comparison.
    period : float or None
        Seconds, where the file has no time column.
    frame_time : str or None
        Column with the times at which frames were delivered, where these lie between the samples of the input; rows
        without a frame are blank there.
    time, input, output, reference : Conversion
        Units of the columns; the reference is that of a controller.
    added : dict of str to Conversion
        Columns that are added to the input, with their units.
    where : str
        The part ``recording`` of the simulation, for messages.
    """

    separator: str | None = None
    decimal: str | None = None
    header: bool = True
    columns: tuple[str, ...] = ()
    group: str | None = None
    experiment: str | None = None
    runs: tuple[dict[str, str], ...] = ()
    start: float | None = None
    end: float | None = None
    leave_out: float = 0.0
    gaps: str = "refuse"
    missing: str = "refuse"
    period: float | None = None
    frame_time: str | None = None
    time: Conversion = field(default_factory=Conversion)
    input: Conversion = field(default_factory=Conversion)
    output: Conversion = field(default_factory=Conversion)
    reference: Conversion = field(default_factory=Conversion)
    added: dict[str, Conversion] = field(default_factory=dict)
    where: str = field(default="simulation, recording", compare=False)

    def to_mapping(self) -> dict[str, Any]:
        """The part ``recording`` of the file: what differs from the default."""
        keys = ("separator", "decimal", "header", "columns", "group", "start", "end", "leave_out", "gaps", "missing")
        default = Reading()
        content = {key: getattr(self, key) for key in keys if getattr(self, key) != getattr(default, key)}
        if self.columns:
            content["columns"] = list(self.columns)
        if self.experiment is not None:
            content["experiment"] = {"column": self.experiment}
        if self.runs:
            content["runs"] = [dict(run) for run in self.runs]
        return content
