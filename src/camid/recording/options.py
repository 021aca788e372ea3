"""How a recording is to be read: the keys of a simulation file that describe the recording's file and its units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError, nearest_match

Array = NDArray[np.float64]

# What the nearest match of an unknown unit is looked for in: the whole registry of pint would offer barns and furlongs.
COMMON_UNITS = (
    "s ms us ns min h second millisecond m mm cm um km meter millimeter inch pixel rad mrad deg turn radian degree "
    "rad/s deg/s rpm Hz m/s mm/s m/s^2 N mN kN newton N*m V mV kV volt A mA ampere Pa kPa bar kg g percent"
)


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry()


@cache
def si_factor(unit: str, where: str, dimension: str | None = None) -> tuple[float, float]:
    """Factor and offset that bring a number in a unit to SI: value = factor · number + offset.

    Parameters
    ----------
    unit : str
        As pint reads it: ``mm``, ``deg``, ``N*m``, ``m/s^2``. A pixel stays a pixel.
    where : str
        Place for messages.
    dimension : str, optional
        ``[time]`` and the like; other kinds of units are refused.

    Raises
    ------
    InputError
        If there is no such unit or it is of another kind.
    """
    import pint

    registry = _registry()
    try:
        # For pint, px is the pixel of style sheets, 1/96 inch.
        parsed = registry.parse_units(re.sub(r"\bpx\b", "pixel", unit))
        begin, end = (float(registry.Quantity(v, parsed).to_base_units().magnitude) for v in (0.0, 1.0))
    except pint.UndefinedUnitError:
        raise InputError(
            f"unknown unit '{unit}'", where=where, hint=nearest_match(unit, COMMON_UNITS.split())
        ) from None
    except Exception as error:  # the parser lets errors of many kinds through, such as those of Python's tokenizer
        problem = " ".join(str(error).split())
        raise InputError(
            f"'{unit}' is no unit ({problem})", where=where, hint="write it like mm, deg or m/s^2"
        ) from None
    if dimension is not None and dict(parsed.dimensionality) != {dimension: 1}:
        kind = dimension.strip("[]")
        raise InputError(f"'{unit}' is no unit of {kind}", where=where, hint=f"give a unit of {kind}, such as ms")
    return end - begin, begin


@dataclass(frozen=True)
class Conversion:
    """From the cells of a column to numbers in SI units: value = scale · (cell in SI units) + offset.

    Attributes
    ----------
    unit : str or None
        Of the cells; None: they are in SI units.
    scale, offset : float
        In SI units.
    where : str
        Place in the simulation, for messages.
    """

    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    where: str = field(default="simulation", compare=False)

    def __call__(self, cells: Array) -> Array:
        """Values of cells.

        Raises
        ------
        InputError
            If the unit is unknown, or the values are zero or not finite because of the scale.
        """
        factor, base = (1.0, 0.0) if self.unit is None else si_factor(self.unit, f"{self.where}.unit")
        if (factor, base, self.scale, self.offset) == (1.0, 0.0, 1.0, 0.0):
            return cells
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            scaled = self.scale * (factor * cells + base)
            values = scaled + self.offset
        known = np.isfinite(cells)
        if not np.all(np.isfinite(values[known])):
            raise InputError(f"scale = {self.scale:g} makes numbers that are not finite", where=self.where)
        if np.any(cells[known]) and not np.any(scaled[known]):
            raise InputError(f"scale = {self.scale:g} makes every number zero", where=self.where)
        return values

    def to_mapping(self) -> dict[str, Any]:
        """Part of the file: what differs from the default."""
        given = {"unit": self.unit, "scale": self.scale, "offset": self.offset}
        return {key: value for key, value in given.items() if value != getattr(Conversion(), key)}


@dataclass(frozen=True)
class Reading:
    """How the file of a recording is to be read.

    Attributes
    ----------
    separator, decimal : str or None
        Between the cells and in the numbers of a text file; None: found. A blank stands for any number of blanks.
    header : bool
        Whether a text file has a line with the names of its columns.
    columns : tuple of str
        The names where there is no such line.
    group : str or None
        HDF5 group or MAT structure that holds the columns, or several groups or structures that do.
    experiment : str or None
        Column that tells several experiments in one table apart.
    start, end : float or None
        Seconds of the time column; rows before and behind are not read.
    leave_out : float
        Seconds at the begin of each experiment that are simulated but not compared.
    gaps : {"refuse", "hold"}
        Whether the input may be held where rows of a driven recording are missing.
    missing : {"refuse", "leave-out"}
        Whether rows without output are left out of the comparison.
    period : float or None
        Seconds, where the file has no time column.
    time, input, output, reference : Conversion
        Units of the columns; the reference is that of a controller.
    where : str
        The part ``recording`` of the simulation, for messages.
    """

    separator: str | None = None
    decimal: str | None = None
    header: bool = True
    columns: tuple[str, ...] = ()
    group: str | None = None
    experiment: str | None = None
    start: float | None = None
    end: float | None = None
    leave_out: float = 0.0
    gaps: str = "refuse"
    missing: str = "refuse"
    period: float | None = None
    time: Conversion = field(default_factory=Conversion)
    input: Conversion = field(default_factory=Conversion)
    output: Conversion = field(default_factory=Conversion)
    reference: Conversion = field(default_factory=Conversion)
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
        return content


def reading_of(content: Mapping[str, Any], where: Any) -> Reading:
    """Reading that the content of a simulation file describes.

    Parameters
    ----------
    content : mapping
        Of the whole file, held against its schema before.
    where : callable
        Gives file, line and key of a path of keys.

    Raises
    ------
    InputError
        If keys contradict each other, or a unit is unknown or of the wrong kind.
    """
    given, time = content.get("recording") or {}, content["time"]
    if ("period" in time) == ("column" in time):
        if "period" in time:
            raise InputError("period and column are both given", where=where("time"), hint="keep one of them")
        raise InputError("the key 'column' is missing", where=where("time"), hint="add it")
    if "period" in time and "unit" in time:
        raise InputError("a period is in seconds", where=where("time", "unit"), hint="remove the unit")
    if given.get("header", True) and "columns" in given:
        raise InputError(
            "columns are named for a file without a header line",
            where=where("recording", "columns"),
            hint="say header: false, or remove them",
        )
    if not given.get("header", True) and "columns" not in given:
        raise InputError(
            "without a header line the columns have no names",
            where=where("recording", "header"),
            hint="name them: columns: [t, u, y]",
        )
    names = [str(c) for c in given.get("columns", [])]
    if len(set(names)) < len(names):
        raise InputError(
            "a name stands twice", where=where("recording", "columns"), hint="name each column differently"
        )
    if "start" in given and "end" in given and not given["start"] < given["end"]:
        raise InputError("start is not before end", where=where("recording"), hint="exchange them")
    parts = {
        "time": time,
        "input": content["input"] or {},
        "sensor": content["sensor"],
        "controller": content.get("controller") or {},
    }
    conversions = {}
    for key, part in parts.items():
        place = where(key)
        if part.get("scale") == 0:
            raise InputError("a scale of zero makes every number zero", where=where(key, "scale"), hint="give another")
        conversions[key] = Conversion(
            None if "unit" not in part else str(part["unit"]),
            float(part.get("scale", 1.0)),
            float(part.get("offset", 0.0)),
            place,
        )
        if "unit" in part:
            si_factor(str(part["unit"]), where(key, "unit"), "[time]" if key == "time" else None)
    experiment = given.get("experiment")
    return Reading(
        separator=_text(given, "separator"),
        decimal=_text(given, "decimal"),
        header=bool(given.get("header", True)),
        columns=tuple(names),
        group=_text(given, "group"),
        experiment=None if experiment is None else str(experiment["column"]),
        start=_number(given, "start"),
        end=_number(given, "end"),
        leave_out=float(given.get("leave_out", 0.0)),
        gaps=str(given.get("gaps", "refuse")),
        missing=str(given.get("missing", "refuse")),
        period=_number(time, "period"),
        time=conversions["time"],
        input=conversions["input"],
        output=conversions["sensor"],
        reference=conversions["controller"],
        where=where("recording"),
    )


def _text(part: Mapping[str, Any], key: str) -> str | None:
    return None if key not in part else str(part[key])


def _number(part: Mapping[str, Any], key: str) -> float | None:
    return None if key not in part else float(part[key])
