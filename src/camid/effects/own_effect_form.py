"""Whether a class that a user wrote has the form of an effect: words, parameters, methods, and compiled code."""

from __future__ import annotations

import dis
import inspect
import linecache
import re
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from camid.effects.base import Effect
from camid.effects.compiled_part import ARGUMENTS, Compiled
from camid.effects.parameter import Parameter
from camid.errors import InputError

WORDS = {
    "identifier": 'identifier = "my-effect"',
    "title": 'title = "Name of the effect"',
    "equation": r'equation = r"f = c\,y^2\,u"',
    "reference": 'reference = "where the law is from"',
}
COMPILED = ("force", "friction_level", "memory_after", "switch", "actuated")
# Methods of which an effect that changes the motion overrides at least one.
HOOKS = (
    *("force", "friction_level", "impulses", "limited_state", "declare", "before_plant", "beside_plant"),
    *("after_plant", "transform", "carry", "windows", "measure", "observe", "picked_up"),
)
MOST_DECORATORS = 8
_IDENTIFIER = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*\Z")
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")


def refuse_wrong_form(kind: type[Effect]) -> None:
    """Refuse a class that the search could not use, and compile its code.

    Raises
    ------
    InputError
        With the file and the line of the class, or of the function that is wrong.
    """
    _refuse_words(kind)
    _refuse_parameters(kind)
    _refuse_methods(kind)
    for name in COMPILED:
        _compile(kind, name)


def line_of(kind: type, name: str | None = None) -> str:
    """File and line of a class, or of a function that it defines; only the name where nobody knows the file."""
    part = None if name is None else inspect.getattr_static(kind, name, None)
    code = next(_code_in(part), None)
    if code is not None:
        return f"{code.co_filename}, line {_line_of_definition(code)}"
    try:
        file, line = inspect.getsourcefile(kind), inspect.getsourcelines(kind)[1]
    except (OSError, TypeError):
        return f"class {kind.__name__}"
    return f"{file}, line {line}"


def _line_of_definition(code: CodeType) -> int:
    """Line of ``def``, below the decorators that count as the first line."""
    linecache.checkcache(code.co_filename)
    for line in range(code.co_firstlineno, code.co_firstlineno + MOST_DECORATORS):
        if linecache.getline(code.co_filename, line).lstrip().startswith("def "):
            return line
    return code.co_firstlineno


def code_of(kind: type) -> Iterator[CodeType]:
    """Code of everything that a class defines or inherits from others of a user."""
    for parent in kind.__mro__:
        if parent is Effect:
            return
        for value in vars(parent).values():
            yield from _code_in(value)


def _code_in(value: Any) -> Iterator[CodeType]:
    for attribute in ("function", "__func__", "fget", "__wrapped__"):
        value = getattr(value, attribute, value)
    if isinstance(value, FunctionType):
        yield value.__code__


def _refuse(kind: type[Effect], problem: str, hint: str, at: str | None = None) -> None:
    raise InputError(f"{kind.__name__}: {problem}", where=line_of(kind, at), hint=hint)


def _refuse_words(kind: type[Effect]) -> None:
    for name, example in WORDS.items():
        if not isinstance(getattr(kind, name, None), str):
            _refuse(kind, f"it has no {name}", f"add one, for instance {example}")
    if not _IDENTIFIER.match(kind.identifier):
        _refuse(kind, f"the identifier '{kind.identifier}' is not one", "small letters, digits and hyphens: my-effect")


def _refuse_parameters(kind: type[Effect]) -> None:
    parameters = getattr(kind, "parameters", None)
    if not isinstance(parameters, tuple | list) or not all(isinstance(p, Parameter) for p in parameters):
        example = 'parameters = (Parameter("coefficient", "1/y^2", "what it means"),)'
        _refuse(kind, "its parameters are no tuple of Parameter", f"write {example}, () where it has none")
    names = [p.name for p in kind.parameters]
    if len(set(names)) < len(names):
        _refuse(kind, "two parameters have the same name", "rename one")
    if kind.strength is not None and kind.strength not in [p.name for p in kind.numeric()]:
        _refuse(kind, f"strength '{kind.strength}' is none of its parameters", f"known: {', '.join(names) or 'none'}")


def _refuse_methods(kind: type[Effect]) -> None:
    wanted = "recognise" if kind.noise_like else "candidates"
    if not _overrides(kind, wanted):
        what = "whether the recording shows it" if kind.noise_like else "first guesses"
        _refuse(kind, f"the method '{wanted}' is missing", f"write a class method that gives {what}")
    if not isinstance(inspect.getattr_static(kind, wanted), classmethod | staticmethod):
        _refuse(kind, f"'{wanted}' is no class method", "write @classmethod above it", wanted)
    if not kind.noise_like and not any(_overrides(kind, name) for name in HOOKS):
        _refuse(kind, "it does nothing", "give it a force, or another hook of docs/adding_an_effect.md")


def _overrides(kind: type[Effect], name: str) -> bool:
    return inspect.getattr_static(kind, name) is not inspect.getattr_static(Effect, name)


def _compile(kind: type[Effect], name: str) -> None:
    """Compile one of the functions that the integrator calls."""
    part = inspect.getattr_static(kind, name)
    if part is None:
        return
    if not isinstance(part, Compiled):
        hint = f"write @compiled above it: def {name}({', '.join(ARGUMENTS)})"
        _refuse(kind, f"'{name}' is not compiled", hint, name)
    code = part.function.__code__
    if code.co_argcount != len(ARGUMENTS) or code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS):
        _refuse(kind, f"'{name}' takes other arguments", f"write def {name}({', '.join(ARGUMENTS)}), no self", name)
    swapped = [n for n, m in zip(code.co_varnames, ARGUMENTS, strict=False) if n != m and n in ARGUMENTS]
    if swapped:
        hint = f"they come by their place: def {name}({', '.join(ARGUMENTS)})"
        _refuse(kind, f"'{name}' has '{swapped[0]}' in the place of another argument", hint, name)
    raising = _line_that_raises(code)
    if raising is not None:
        raise InputError(
            f"{kind.__name__}: '{name}' raises an error, which compiled code cannot",
            where=f"{code.co_filename}, line {raising}",
            hint="return a number everywhere",
        )
    try:
        _ = part.address
    except Exception as error:  # the compiler's own, and TypeError for what its cache could not follow
        line = _line_blamed(error, code) or _line_of_definition(code)
        raise InputError(
            f"{kind.__name__}: '{name}' cannot be compiled: {_said(error)}",
            where=f"{code.co_filename}, line {line}",
            hint="it may use numbers, tuples of numbers, the module math, and functions with @njit of camid.compiled",
        ) from error


def _line_that_raises(code: CodeType) -> int | None:
    """First line that raises or asserts; None where none does."""
    line = code.co_firstlineno
    for instruction in dis.get_instructions(code):
        line = instruction.starts_line or line
        if instruction.opname == "RAISE_VARARGS":
            return line
    return None


def _line_blamed(error: Exception, code: CodeType) -> int | None:
    """Line that the compiler names first, which is that of the innermost function; None where it names none."""
    named = re.search(
        rf'File "[^"]*{re.escape(Path(code.co_filename).name)}", line (\d+)', _COLOURS.sub("", str(error))
    )
    return int(named[1]) if named else getattr(getattr(error, "loc", None), "line", None)


def _said(error: Exception) -> str:
    """First sentence of the compiler that says something."""
    lines = [_COLOURS.sub("", line).strip() for line in str(error).splitlines()]
    useful = [line for line in lines if line and not line.startswith("Failed in")]
    return re.sub(r" for '\$.*$", "", useful[0]).rstrip(":") if useful else type(error).__name__
