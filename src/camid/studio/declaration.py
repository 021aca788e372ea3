"""The simulation as a form: fields that read and change single keys of its YAML text, whose comments stay."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import Any

Path = tuple[str, ...]

NO_INPUT = "none: a free decay"
HOLDS = {
    "zoh": "held until the next sample (zoh)",
    "foh": "straight lines between samples (foh)",
    "band-limited": "band-limited: it passed an analogue filter",
}
SENSORS = {"camera": "camera: the mean over an exposure", "instant": "instant: encoder, potentiometer, …"}
STARTS = {"zero": "zero: at rest before the first row", "estimate": "estimate: it may already be moving"}
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Field:
    """One field of the form.

    Attributes
    ----------
    path : tuple of str
        Keys that lead to the value.
    part : str
        ``recording``, ``input``, ``plant``, ``sensor`` or ``start``.
    label : str
    value : str
        As it stands in the file; empty if it does not.
    choices : dict of str to str or None
        What can be chosen, and how it reads; None for what is typed.
    hint : str
    """

    path: Path
    part: str
    label: str
    value: str
    choices: Mapping[str, str] | None = None
    hint: str = ""


def parsed(text: str) -> Any:
    """Content of a simulation's text, whose comments and quotes are kept; for text that was read without error."""
    from ruamel.yaml import YAML

    yaml = YAML(typ="rt", pure=True)
    yaml.preserve_quotes = True
    return yaml.load(text)


def changed(text: str, path: Path, value: str) -> str:
    """The text with another value at a path; an empty one removes the key.

    Parameters
    ----------
    text : str
        YAML that was read without error.
    path : tuple of str
    value : str
        A number where it reads as one, a list of numbers between commas for coefficients, words otherwise.
    """
    from ruamel.yaml import YAML

    content = parsed(text)
    if path == ("input", "column") and (value == NO_INPUT or not isinstance(content.get("input"), Mapping)):
        # Without an input there is no mapping, whose keys could be set.
        content["input"] = None if value == NO_INPUT else {"column": _quoted(value), "hold": "zoh"}
    else:
        part = content
        for key in path[:-1]:
            if not isinstance(part.get(key), Mapping):
                part[key] = {}
            part = part[key]
        if value.strip():
            part[path[-1]] = _typed(path[-1], value)
        else:
            part.pop(path[-1], None)
        if path == ("sensor", "kind") and value == "instant":
            part.pop("exposure", None)
    yaml = YAML(typ="rt", pure=True)
    yaml.preserve_quotes = True
    yaml.width = 4096
    stream = StringIO()
    yaml.dump(content, stream)
    return stream.getvalue()


def _typed(key: str, value: str) -> Any:
    if key in {"column", "unit"}:
        return _quoted(value)
    if key in {"numerator", "denominator"}:
        from ruamel.yaml.comments import CommentedSeq

        items = CommentedSeq(_number(v) for v in re.split(r"[,;\s]+", value.strip(" []")) if v)
        items.fa.set_flow_style()
        return items
    return _number(value)


def _number(text: str) -> float | str:
    """A number, or the text where it is none; what camid says of it then is shown."""
    try:
        return float(text.strip())
    except ValueError:
        return _quoted(text.strip())


def _quoted(text: str) -> str:
    """Text in quotes unless it is a plain word, so that it is read back as it is."""
    from ruamel.yaml.scalarstring import DoubleQuotedScalarString

    plain = re.fullmatch(r"[A-Za-z_][\w.\-]*", text) and text.lower() not in {
        *("y", "n", "yes", "no", "on", "off", "true", "false", "null", "nan", "inf")
    }
    return text if plain else DoubleQuotedScalarString(text)


def _at(content: Any, *path: str) -> Any:
    for key in path:
        content = content.get(key) if isinstance(content, Mapping) else None
    return content


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_text(v) for v in value)
    if isinstance(value, bool) or value is None:
        return "" if value is None else str(value).lower()
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def column_of(content: Any, part: str) -> str | None:
    """The column that ``time``, ``input`` or ``sensor`` names; None if it names none."""
    column = _at(content, part, "column")
    return None if column is None else str(column)


def fields_of(content: Any, columns: Sequence[str]) -> list[Field]:
    """The fields for a simulation's content; what the form does not know stays as it is in the text."""

    def offered(value: Any, *more: str) -> dict[str, str]:
        names = dict.fromkeys([*more, *columns, *([str(value)] if value else [])])
        return {name: name for name in names}

    def field(part: str, label: str, *path: str, choices: Mapping[str, str] | None = None, hint: str = "") -> Field:
        return Field(path, part, label, _text(_at(content, *path)), choices, hint)

    time, driven, sensor = (_at(content, part, "column") for part in ("time", "input", "sensor"))
    fields = [
        field("recording", "Time", "time", "column", choices=offered(time))
        if time is not None
        else field("recording", "Sampling period in s", "time", "period"),
        Field(("input", "column"), "input", "Input column", str(driven or NO_INPUT), offered(driven, NO_INPUT)),
    ]
    if driven is not None:
        fields += [
            field("input", "Between samples", "input", "hold", choices=HOLDS),
            field("input", "Unit", "input", "unit", hint="of the cells, if they are not in SI units"),
        ]
    fields += _plant_fields(content, field)
    if _at(content, "sensor", "columns") is None:
        fields.append(field("sensor", "Output column", "sensor", "column", choices=offered(sensor)))
    fields.append(field("sensor", "Sensor", "sensor", "kind", choices=SENSORS))
    if _at(content, "sensor", "kind") == "camera":
        fields.append(field("sensor", "Exposure in s", "sensor", "exposure", hint="empty: the whole period"))
    fields += [
        field("sensor", "Latency in s", "sensor", "latency", hint="0, a number, or estimate"),
        field("sensor", "Zero of the sensor", "sensor", "offset", hint="estimate, or the reading at rest"),
        field("sensor", "Unit", "sensor", "unit", hint="of the cells, e.g. px or mm"),
        field("start", "At the first row", "initial_state", choices=STARTS),
    ]
    return fields


def _plant_fields(content: Any, field: Any) -> list[Field]:
    """Fields for the numbers of a plant: coefficients, or constants with names."""
    plant = _at(content, "plant")
    if _at(plant, "transfer_function") is not None:
        powers = "descending powers of s, between commas"
        return [
            field("plant", "Numerator", "plant", "transfer_function", "numerator", hint=powers),
            field("plant", "Denominator", "plant", "transfer_function", "denominator", hint=powers),
        ]
    if (constants := _at(plant, "physical", "parameters")) is not None:
        units = _at(plant, "physical", "units") or {}
        return [
            field("plant", str(name), "plant", "physical", "parameters", str(name), hint=str(units.get(name, "")))
            for name in constants
        ]
    pendulum = _at(plant, "pendulum")
    return [
        field("plant", str(name).replace("_", " "), "plant", "pendulum", str(name))
        for name, value in (pendulum.items() if isinstance(pendulum, Mapping) else ())
        if isinstance(value, int | float)
    ]


@dataclass(frozen=True)
class Block:
    """A block of the chain: its name, and what is said in it."""

    name: str
    lines: tuple[str, ...]


def chain_of(content: Any) -> list[Block]:
    """The chain that a simulation's content declares, from the drive to the recording."""
    driven = _at(content, "input", "column")
    blocks = []
    if driven is not None:
        hold = str(_at(content, "input", "hold") or "zoh")
        blocks += [Block("input", (str(driven),)), Block("hold", (HOLDS.get(hold, hold).partition(" (")[0],))]
    blocks.append(Block("plant", _plant_lines(content)))
    sensor = _at(content, "sensor")
    if _at(sensor, "kind") == "camera":
        exposure = _at(sensor, "exposure")
        kind, said = "camera", "exposure: the period" if exposure is None else f"exposure {_text(exposure)} s"
    else:
        kind, said = "sensor", "no exposure"
    latency = _at(sensor, "latency")
    late = "no latency" if not latency else f"latency {_text(latency)}" + ("" if latency == "estimate" else " s")
    outputs = _at(sensor, "columns") or [_at(sensor, "column")]
    return [*blocks, Block(kind, (said, late)), Block("output", tuple(_text(o) for o in outputs))]


def _plant_lines(content: Any) -> tuple[str, ...]:
    fraction = _at(content, "plant", "transfer_function")
    if fraction is not None:
        parts = [polynomial(_at(fraction, part)) for part in ("numerator", "denominator")]
        return (parts[0], "―――", parts[1])
    constants = _at(content, "plant", "physical", "parameters")
    if constants is not None:
        return tuple(f"{name} {_text(value)}" for name, value in constants.items())
    return ("pendulum",) if _at(content, "plant", "pendulum") is not None else ("as in the text below",)


def polynomial(coefficients: Any) -> str:
    """A polynomial in s with numbers of four digits; expressions as they are."""
    if not isinstance(coefficients, list | tuple):
        return _text(coefficients)
    terms = []
    for k, c in enumerate(coefficients):
        power = len(coefficients) - 1 - k
        symbol = "" if power == 0 else "s" if power == 1 else "s" + str(power).translate(SUPERSCRIPTS)
        if isinstance(c, int | float) and c == 0.0 and len(coefficients) > 1:
            continue
        number = f"{c:.4g}" if isinstance(c, int | float) else str(c)
        terms.append(symbol if symbol and number == "1" else f"{number} {symbol}".strip())
    return " + ".join(terms).replace("+ -", "− ") or "0"
