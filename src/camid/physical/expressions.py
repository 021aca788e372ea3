"""Expressions of named constants: read by SymEngine's own parser and compiled by LLVM in some milliseconds.

Nothing of a user's text is ever evaluated as Python.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import symengine

Array = NDArray[np.float64]

# What an expression may consist of beside names, numbers, + - * / ^ and brackets, as it is written.
FUNCTIONS = (
    *("sqrt", "exp", "log", "abs", "sign", "min", "max"),
    *("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
)
# Classes of SymEngine that these become; a FunctionSymbol is a function that it does not know.
_KNOWN = frozenset(
    [
        *("Add", "Mul", "Pow", "Symbol", "Integer", "One", "Zero", "NegativeOne", "Half", "Rational", "RealDouble"),
        *("Pi", "Exp1", "Abs", "Max", "Min", *FUNCTIONS),
    ]
)
_NAME = re.compile(r"[^\W\d]\w*\Z")
# Names that mean a number to the parser.
RESERVED = {"E": "Euler's number", "I": "the imaginary unit", "pi": "the number pi", "oo": "infinity"}
_ALSO_RESERVED = ("nan", "inf", "zoo", "NaN", "Inf", "true", "false", "True", "False")
# Longer text is no expression; the parser recurses.
MOST_CHARACTERS = 2000
MOST_DEPTH = 60


def refuse_name(name: str) -> None:
    """Refuse what cannot be the name of a constant or a state.

    Raises
    ------
    ValueError
        If it is no identifier, or means a number or a function in expressions.
    """
    if not _NAME.match(name):
        raise ValueError(f"'{name}' is not a name: letters, digits and _ only, and no digit at its beginning")
    if name in RESERVED or name in _ALSO_RESERVED:
        raise ValueError(f"'{name}' means {RESERVED.get(name, 'a value')} in expressions: choose a longer name")
    if name in FUNCTIONS:
        raise ValueError(f"'{name}' is a function in expressions: choose another name")


def parsed(text: str | float, names: Iterable[str]) -> symengine.Basic:
    """An expression, checked.

    Parameters
    ----------
    text : str or float
    names : iterable of str
        What it may depend on.

    Raises
    ------
    ValueError
        If it is not an expression, holds a name or function that is not known, or is not a real number.
    """
    import symengine

    known = list(names)
    written = str(text)
    if len(written) > MOST_CHARACTERS or _depth(written) > MOST_DEPTH:
        raise ValueError(f"'{written[:40]}…' is too long for an expression")
    try:
        found = symengine.sympify(float(text) if isinstance(text, float | int) else written)
    except Exception as error:  # the parser raises RuntimeError, and others for what it does not know
        detail = " ".join(str(error).split())
        raise ValueError(f"'{written}' is not an expression" + (f" ({detail})" if detail else "")) from None
    # Numbers of more digits than a float holds, as programs write them, are of another class.
    long = [part for part in _parts(found) if type(part).__name__ == "RealMPFR"]
    found = found.xreplace({part: symengine.RealDouble(float(part)) for part in long}) if long else found
    for part in _parts(found):
        kind = type(part).__name__
        if kind == "Symbol" and str(part) not in known:
            raise ValueError(f"'{written}' holds the unknown name '{part}'{_nearest(str(part), known)}")
        if kind == "FunctionSymbol":
            name = part.get_name()
            raise ValueError(f"'{written}' holds the unknown function '{name}'{_nearest(name, FUNCTIONS)}")
        if kind not in _KNOWN or (kind == "RealDouble" and not np.isfinite(float(part))):
            raise ValueError(f"'{written}' is not a real expression of names, numbers and functions")
    return found


def _depth(text: str) -> int:
    """How deep its brackets go."""
    depth = deepest = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        deepest = max(deepest, depth)
    return deepest


def _parts(expression: Any) -> Iterator[Any]:
    """An expression and all that it consists of."""
    waiting = [expression]
    while waiting:
        part = waiting.pop()
        yield part
        waiting.extend(part.args)


def _nearest(name: str, known: Sequence[str]) -> str:
    found = get_close_matches(name, known, 1)
    if found:
        return f": did you mean '{found[0]}'?"
    return f"; it may hold {', '.join(known)}" if known else ""


def symbols(names: Iterable[str]) -> list[symengine.Symbol]:
    """The symbols of names."""
    import symengine

    return [symengine.Symbol(name) for name in names]


class Compiled:
    """Expressions as machine code: a function of the arguments' values, shape (n,), that gives theirs, shape (m,)."""

    def __init__(self, arguments: Sequence[Any], expressions: Sequence[Any]) -> None:
        import symengine

        self.count = len(expressions)
        # SymEngine calls common parts x0, x1, … without a look at what is called so already.
        renamed = {argument: symengine.Symbol(f"argument {i}") for i, argument in enumerate(arguments)}
        written = [symengine.sympify(expression).xreplace(renamed) for expression in expressions]
        self.function = symengine.Lambdify([*renamed.values()], written, backend="llvm", cse=True)

    def __call__(self, values: Array) -> Array:
        """Their values, shape (m,), for those of the arguments, shape (n,)."""
        return np.asarray(self.function(np.ascontiguousarray(values, dtype=float)), dtype=float).reshape(self.count)

    def addresses(self) -> tuple[int, int]:
        """Where (double* out, const double* in, void* data) lies in memory, and its ``data``; both live with this."""
        import ctypes

        function, data = self.function.as_ctypes()
        return int(ctypes.cast(function, ctypes.c_void_p).value or 0), int(data.value or 0)
