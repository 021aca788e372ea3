"""A formula as people write it, a·(y − y0)/c·exp(−((y − y0)/c)²), as a function of a Python program."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POWERS = dict(zip("²³⁴⁵⁶⁷⁸⁹", "23456789", strict=True))
# Functions that a formula may hold: as the program imports or defines them, and for arrays.
IMPORTED: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("exp", "sin", "cos", "tan", "tanh", "sqrt", "log")},
    "atan": np.arctan,
}
BUILT_IN: dict[str, Callable[..., Any]] = {"abs": np.abs, "min": np.minimum, "max": np.maximum}
DEFINED: dict[str, tuple[str, Callable[..., Any]]] = {
    "sign": ("def sign(x):\n    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0", np.sign),
    "dead_zone": ("def dead_zone(x, c):\n    return x - min(max(x, -c), c)", lambda x, c: x - np.clip(x, -c, c)),
}
_OPERATIONS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.USub, ast.UAdd)
# A lower bound that means positive.
POSITIVE = "1e-300"
LINEAR = 1e-9


@dataclass(frozen=True)
class FormulaProgram:
    """A formula as code.

    Attributes
    ----------
    code : str
        Python expression of the variable and its numbers.
    variable : str
    numbers : dict of str to float
    amplitudes : tuple of str
        Numbers in which it is linear; it is zero where they are.
    lower : dict of str to str
        Lower bounds of others, as they are written.
    functions : frozenset of str
        That the code calls.
    equation : str
        LaTeX of the right side.
    """

    code: str
    variable: str
    numbers: dict[str, float]
    amplitudes: tuple[str, ...]
    lower: dict[str, str]
    functions: frozenset[str]
    equation: str
    _tree: ast.Expression = field(repr=False, compare=False)

    def values(self, at: Array, **numbers: float) -> Array:
        """Its values, in the shape of ``at``, with other numbers than its own if any are given."""
        known = {"__builtins__": {}, "pi": np.pi, **IMPORTED, **BUILT_IN, **{n: f for n, (_, f) in DEFINED.items()}}
        # The expression is made of the nodes alone that _is_arithmetic lets through.
        found = eval(compile(self._tree, "formula", "eval"), known, {self.variable: at, **self.numbers, **numbers})
        return np.asarray(found + np.zeros_like(at))


def program_of(formula: str, numbers: Mapping[str, float], points: Array) -> FormulaProgram | None:
    """A formula as code; None where it is not understood, or cannot be written with a free size.

    Parameters
    ----------
    formula : str
        ``f(y) = a·y²``, perhaps with ``, a = …`` behind it.
    numbers : mapping of str to float
        Its named numbers.
    points : ndarray, shape (N,)
        Where it has to be finite.
    """
    right = _right_side(formula, numbers)
    try:
        tree = ast.parse(_as_python(right), mode="eval")
    except (SyntaxError, ValueError):
        return None
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    functions = {
        node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    variables = names - set(numbers) - functions - {"pi"}
    known = {*IMPORTED, *BUILT_IN, *DEFINED}
    if len(variables) != 1 or not functions <= known or not set(numbers) <= names or not _is_arithmetic(tree):
        return None
    (variable,) = variables
    if not all(name.isidentifier() and name.isascii() for name in (variable, *numbers)):
        return None
    program = FormulaProgram(
        ast.unparse(tree),
        variable,
        dict(numbers),
        (),
        _bounds(tree, numbers),
        frozenset(functions),
        _latex(right),
        tree,
    )
    amplitudes = _amplitudes(program, points)
    return None if amplitudes is None else FormulaProgram(**{**vars(program), "amplitudes": amplitudes})


def _right_side(formula: str, numbers: Mapping[str, float]) -> str:
    """What stands behind the last sign of equality, without the numbers that follow it."""
    ends = [found.start() for name in numbers if (found := re.search(rf", {re.escape(name)} = ", formula))]
    right = formula[: min(ends, default=len(formula))].rpartition(" = ")[2]
    # A curve is what is added to the signal: u' = u + …
    added = re.match(r"(\w+) \+ ", right)
    return right[added.end() :] if added and re.match(rf"{added[1]}'? = |w = ", formula[:6]) else right


def _as_python(text: str) -> str:
    text = re.sub(r"√\|([^|]*)\|", r"sqrt(abs(\1))", text)
    text = re.sub(r"\|([^|]*)\|", r"abs(\1)", text)
    text = text.replace("√(", "sqrt(").replace("·", "*").replace("−", "-").replace("^", "**")
    for sign, power in POWERS.items():
        text = text.replace(sign, f"**{power}")
    return re.sub(r"(?<=[0-9])π", "*pi", text).replace("π", "pi").strip()


def _latex(text: str) -> str:
    text = re.sub(r"√\|([^|]*)\|", r"\\sqrt{|\1|}", text)
    text = re.sub(r"\b(exp|sin|cos|tan|tanh|max|min|log)\b", r"\\\1", text)
    text = re.sub(r"\b(sign|dead_zone|atan)\b", lambda m: rf"\mathrm{{{m[1].replace('_', ' ')}}}", text)
    text = re.sub(r"\b([A-Za-z])0\b", r"\1_0", text)
    for sign, power in POWERS.items():
        text = text.replace(sign, f"^{power}")
    return text.replace("·", r"\,").replace("−", "-").replace("π", r"\pi").replace("√", r"\sqrt")


def _is_arithmetic(tree: ast.Expression) -> bool:
    """Whether nothing but numbers, names, arithmetic and calls of functions stands in an expression."""
    allowed = (ast.Expression, ast.BinOp, ast.UnaryOp, ast.Name, ast.Load, *_OPERATIONS)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant):
            if isinstance(node.value, bool) or not isinstance(node.value, int | float):
                return False
        elif isinstance(node, ast.Call):
            if not isinstance(node.func, ast.Name) or node.keywords:
                return False
        elif not isinstance(node, allowed):
            return False
    return True


def _bounds(tree: ast.Expression, numbers: Mapping[str, float]) -> dict[str, str]:
    """Lower bounds of positive numbers that something is divided by, and of exponents and half widths."""
    found: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div) and isinstance(node.right, ast.Name):
            found[node.right.id] = POSITIVE
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Name):
            found[node.right.id] = "0.1"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "dead_zone":
            found |= {each.id: "0.0" for each in node.args[1:] if isinstance(each, ast.Name)}
    return {name: bound for name, bound in found.items() if numbers.get(name, 0.0) > float(bound)}


def _amplitudes(program: FormulaProgram, points: Array) -> tuple[str, ...] | None:
    """Numbers in which a formula is linear, where it is zero without them; None where it has none or is not finite."""
    with np.errstate(all="ignore"):
        own = program.values(points)
        size = float(np.max(np.abs(own), initial=0.0))
        if not np.isfinite(size) or size == 0.0:
            return None
        found = []
        for name, value in program.numbers.items():
            none, twice = program.values(points, **{name: 0.0}), program.values(points, **{name: 2.0 * value})
            if np.all(np.abs(twice - 2.0 * own + none) <= LINEAR * size) and np.any(np.abs(own - none) > LINEAR * size):
                found.append(name)
        without = program.values(points, **dict.fromkeys(found, 0.0))
    return tuple(found) if found and not np.any(without) else None
