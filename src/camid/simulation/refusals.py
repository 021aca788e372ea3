"""Content of a simulation file as its model, or one line that says what is wrong, where, and what is expected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from camid.errors import InputError, nearest_match
from camid.simulation.schema import SimulationFile
from camid.simulation.schema_values import Part
from camid.simulation.yaml_file import place


def validated(content: Mapping[str, Any], source: str) -> SimulationFile:
    """Content of a simulation file as its model.

    Parameters
    ----------
    content : mapping
    source : str
        Name for messages.

    Raises
    ------
    InputError
        With file, line and key of the first error, and the nearest match of an unknown key.
    """
    try:
        return SimulationFile.model_validate(content)
    except ValidationError as invalid:
        errors = invalid.errors(include_url=False)
    # A misspelt key explains the missing one beside it, so it is named first.
    raise _refusal(next((e for e in errors if e["type"] in _UNKNOWN_KEY), errors[0]), content, source)


_TAGS = ("number", "text")
_UNKNOWN_KEY = ("extra_forbidden", "invalid_key")
# What is wrong, by pydantic's type of error; the message names the value first.
_PROBLEMS = {
    "model_type": "is not a mapping of keys to values",
    "dict_type": "is not a mapping of keys to values",
    "list_type": "is not a list",
    "string_type": "is not text",
    "bool_type": "is neither true nor false",
    "float_type": "is not a finite number",
    "finite_number": "is not a finite number",
    "greater_than": "is not greater than {gt:g}",
    "greater_than_equal": "is less than {ge:g}",
    "less_than_equal": "is greater than {le:g}",
    "too_short": "has {actual_length} of at least {min_length} entries",
    "string_too_short": "is empty",
    "string_too_long": "is more than one character",
}


def _refusal(error: ErrorDetails, content: Mapping[str, Any], source: str) -> InputError:
    """One line for an error of pydantic."""
    kind, value = error["type"], error["input"]
    path: list[Any] = list(error["loc"])
    if path[0] == "plant":
        del path[1:2]  # pydantic names the kind of plant there
    either = path[-1] in _TAGS and path[0] in ("plant", "sensor")
    if either:
        del path[-1]  # and which of the two a value is
    if kind in _UNKNOWN_KEY:
        key = path[-1]
        hint = nearest_match(key, _fields(path[:-1]))
        return InputError(f"unknown key '{key}'", where=place(source, content, path), hint=hint)
    if kind == "missing":
        hint = "add it, or a pendulum, or physical" if path == ["plant", "transfer_function"] else "add it"
        return InputError(f"the key '{path[-1]}' is missing", where=place(source, content, path[:-1]), hint=hint)
    where = place(source, content, path)
    if path == ["schema"]:
        return InputError(f"version {value!r} is not known", where=where, hint="this camid reads schema: 1")
    if kind == "literal_error":
        expected = error["ctx"]["expected"].replace("'", "") if path != ["recording", "decimal"] else "'.' or ','"
        expected = f"a number, or {expected}" if either else expected
        return InputError(f"'{value}' is not known here", where=where, hint=f"it must be {expected}")
    problem = "is empty" if not value and kind == "too_short" else _PROBLEMS.get(kind)
    described = _description(path)
    if path == ["sensor", "columns"] and kind == "too_short":
        described = "one column is column: name; columns are two or more, each with what it reads"
    if kind == "list_type" and described:
        described = f"a list in brackets, such as [1.0, 2.0]: {described}"
    return InputError(
        error["msg"] if problem is None else f"{value!r} {problem.format(**error.get('ctx', {}))}",
        where=where,
        hint=f"expected: {described}" if described else None,
    )


def _parts(annotation: Any) -> Iterator[type[Part]]:
    """Models in an annotation, such as those of a union or of a list."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        yield annotation
    for inside in get_args(annotation):
        yield from _parts(inside)


def _fields(path: Sequence[Any]) -> dict[str, Any]:
    """Fields of the models at a path of keys, by the keys of the file."""
    parts: list[type[Part]] = [SimulationFile]
    for key in path:
        if isinstance(key, str):
            fields = [part.model_fields[key] for part in parts if key in part.model_fields]
            parts = [inner for field in fields for inner in _parts(field.annotation)]
    return {field.alias or name: field for part in parts for name, field in part.model_fields.items()}


def _description(path: Sequence[Any]) -> str | None:
    """Description of the key at the end of a path, or of the list that holds its end."""
    names = [key for key in path if isinstance(key, str)]
    field = _fields(names[:-1]).get(names[-1]) if names else None
    return None if field is None else field.description
