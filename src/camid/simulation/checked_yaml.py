"""YAML files that are held against a JSON schema, with errors that name file, line and key."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from camid.errors import InputError, nearest_match


def read_yaml(path: Path) -> Any:
    """Content of a YAML 1.2 file, whose mappings remember their lines.

    Raises
    ------
    InputError
        If there is no such file or it is no YAML; a key that stands twice is no YAML.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError

    if path.is_dir():
        raise InputError("this is a folder", where=str(path), hint="name a YAML file")
    if not path.exists():
        raise InputError("no such file", where=str(path), hint="check the path")
    try:
        return YAML(typ="rt", pure=True).load(path.read_text(encoding="utf-8-sig"))
    except OSError:
        raise
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{path}, line {mark.line + 1}" if mark else str(path)
        problem = " ".join(str(error.problem or error.context).split())
        raise InputError(f"no YAML: {problem}", where=where, hint="correct the line") from None
    except Exception as error:  # the parser lets errors of its own making through, such as those of impossible dates
        problem = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError(f"no YAML: {problem}", where=str(path), hint="write it as text") from None


def _is_finite_number(_checker: Any, value: Any) -> bool:
    """Whether a schema's number stands here; YAML's truth values, .nan and .inf are none."""
    from ruamel.yaml.scalarbool import ScalarBoolean

    try:
        return (
            isinstance(value, Real) and not isinstance(value, bool | ScalarBoolean) and bool(np.isfinite(float(value)))
        )
    except OverflowError:
        return False


@cache
def _validator(schema: str) -> Any:
    from jsonschema import Draft202012Validator
    from jsonschema.validators import extend

    text = files("camid").joinpath(f"schemas/{schema}").read_text(encoding="utf-8")
    types = Draft202012Validator.TYPE_CHECKER.redefine("number", _is_finite_number)
    types = types.redefine("array", lambda _checker, value: isinstance(value, list | tuple))
    types = types.redefine("object", lambda _checker, value: isinstance(value, Mapping))
    return extend(Draft202012Validator, type_checker=types)(json.loads(text))


def _line(content: Any, path: list[Any]) -> int | None:
    """Line in the YAML file at which the value at ``path`` stands, as ruamel.yaml remembers it."""
    line = None
    for key in path:
        try:
            marks: Any = content.lc  # only what came out of a file has them
            line = (marks.item(key) if isinstance(content, list) else marks.key(key))[0] + 1
            content = content[key]
        except (AttributeError, KeyError, TypeError, IndexError):
            return line
    return line


def place(source: str, content: Any, path: list[Any]) -> str:
    """File, line and dotted key of a value, for messages."""
    line = _line(content, path)
    key = ".".join(str(p) for p in path)
    return ", ".join([source, *([f"line {line}"] if line else []), *([key] if key else [])])


def refuse_schema_errors(content: Any, schema: str, source: str) -> None:
    """Hold content against a schema of this package.

    Parameters
    ----------
    content : mapping
    schema : str
        File in ``camid/schemas``.
    source : str
        Name for messages.

    Raises
    ------
    InputError
        With file, line and key of the first error, and the nearest match of an unknown key.
    """
    from jsonschema.exceptions import best_match

    errors = list(_validator(schema).iter_errors(content))
    # A misspelt key explains the missing one beside it, so it is named first.
    unknown = [e for e in errors if e.validator == "additionalProperties"]
    error = unknown[0] if unknown else best_match(errors)
    if error is None:
        return
    path = list(error.absolute_path)
    if error.validator == "additionalProperties" and "properties" in error.schema:
        known = list(error.schema["properties"])
        key = next(k for k in error.instance if k not in known)
        raise InputError(
            f"unknown key '{key}'", where=place(source, content, [*path, key]), hint=nearest_match(key, known)
        )
    if error.validator == "required":
        missing = next(k for k in error.validator_value if k not in error.instance)
        raise InputError(f"the key '{missing}' is missing", where=place(source, content, path), hint="add it")
    if error.validator == "enum":
        known = [str(v) for v in error.validator_value]
        raise InputError(
            f"'{error.instance}' is not known here",
            where=place(source, content, path),
            hint=f"it must be one of {', '.join(known)}",
        )
    if error.validator == "const":
        raise InputError(
            f"version {error.instance!r} is not known",
            where=place(source, content, path),
            hint=f"this camid reads {path[-1]}: {error.validator_value}",
        )
    if error.validator == "type" and error.validator_value == "number":
        raise InputError(
            f"{error.instance!r} is no finite number",
            where=place(source, content, path),
            hint=f"here belongs: {error.schema.get('description', 'a number with a decimal point')}",
        )
    described = error.schema.get("description", "") if isinstance(error.schema, Mapping) else ""
    raise InputError(
        error.message, where=place(source, content, path), hint=f"here belongs: {described}" if described else None
    )
