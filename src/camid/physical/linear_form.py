"""Linear plants whose coefficients are expressions of named constants: transfer functions and state-space models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.physical.expressions import Compiled, parsed, symbols

if TYPE_CHECKING:
    import symengine

Array = NDArray[np.float64]

# Step of the differences that replace derivatives, as a share of a constant.
DIFFERENCE = 1e-6
# Share of a coefficient's size below which it does not depend on a constant.
NO_DEPENDENCE = 1e-9
# States of a model whose transfer function is found in symbols.
MOST_STATES = 8


@dataclass(frozen=True)
class RationalForm:
    """B(s)/A(s), whose coefficients are expressions.

    Attributes
    ----------
    names : tuple of str
        The constants.
    numerator, denominator : tuple of str
        In descending powers of s.
    """

    names: tuple[str, ...]
    numerator: tuple[str, ...]
    denominator: tuple[str, ...]

    def polynomials(self) -> tuple[list[symengine.Basic], list[symengine.Basic]]:
        """Numerator and denominator as expressions; ValueError names what is none."""
        return (
            [parsed(text, self.names) for text in self.numerator],
            [parsed(text, self.names) for text in self.denominator],
        )

    def to_mapping(self) -> dict[str, Any]:
        """Part of a simulation file."""
        return {"transfer_function": {"numerator": list(self.numerator), "denominator": list(self.denominator)}}


@dataclass(frozen=True)
class StateSpaceForm:
    """ẋ = A x + B u, y = C x, whose entries are expressions.

    Attributes
    ----------
    names : tuple of str
        The constants.
    state_matrix : tuple of tuple of str, shape (n, n)
    input_vector, output_row : tuple of str, shape (n,)
    """

    names: tuple[str, ...]
    state_matrix: tuple[tuple[str, ...], ...]
    input_vector: tuple[str, ...]
    output_row: tuple[str, ...]

    def polynomials(self) -> tuple[list[symengine.Basic], list[symengine.Basic]]:
        """Numerator and denominator as expressions, by the method of Faddeev and Le Verrier.

        N_1 = 1, a_i = -tr(A N_i)/i, N_{i+1} = A N_i + a_i 1; the numerator's coefficients are C N_i B (Gantmacher 1959,
        The Theory of Matrices I, chapter IV, section 5).

        Raises
        ------
        ValueError
            If the shapes do not agree or an entry is no expression.
        """
        import symengine

        count = len(self.state_matrix)
        if not 0 < count <= MOST_STATES:
            raise ValueError(f"{count} states: between 1 and {MOST_STATES} are read")
        for name, entries in (
            *((f"row {i + 1} of the state matrix", row) for i, row in enumerate(self.state_matrix)),
            ("the input vector", self.input_vector),
            ("the output row", self.output_row),
        ):
            if len(entries) != count:
                raise ValueError(f"{name} has {len(entries)} entries, and there are {count} states")
        matrix = [[parsed(text, self.names) for text in row] for row in self.state_matrix]
        entering = [parsed(text, self.names) for text in self.input_vector]
        leaving = [parsed(text, self.names) for text in self.output_row]
        adjugate = [[symengine.Integer(int(i == j)) for j in range(count)] for i in range(count)]
        numerator, denominator = [], [symengine.Integer(1)]
        for step in range(1, count + 1):
            driven = [_dot(row, entering) for row in adjugate]
            numerator.append(symengine.expand(_dot(leaving, driven)))
            columns = [*zip(*adjugate, strict=True)]
            adjugate = [[_dot(row, column) for column in columns] for row in matrix]
            trace = sum((adjugate[i][i] for i in range(count)), symengine.Integer(0))
            denominator.append(symengine.expand(-trace / step))
            for i, row in enumerate(adjugate):
                row[i] += denominator[-1]
                adjugate[i] = [symengine.expand(entry) for entry in row]
        return numerator, denominator

    def to_mapping(self) -> dict[str, Any]:
        """Part of a simulation file."""
        return {
            "state_space": {
                "state_matrix": [list(row) for row in self.state_matrix],
                "input_vector": list(self.input_vector),
                "output_row": list(self.output_row),
            }
        }


def _dot(one: Sequence[symengine.Basic], other: Sequence[symengine.Basic]) -> symengine.Basic:
    """Scalar product of expressions."""
    import symengine

    return sum((a * b for a, b in zip(one, other, strict=True)), symengine.Integer(0))


LinearForm = RationalForm | StateSpaceForm


class Coefficients:
    """Coefficients of the monic plant as a function of the constants; ``texts`` has them as expressions."""

    def __init__(self, form: LinearForm) -> None:
        numerator, denominator = form.polynomials()
        while len(numerator) > 1 and numerator[0] == 0:
            del numerator[0]
        if denominator[0] == 0:
            raise ValueError("the first coefficient of the denominator is zero: leave it out")
        if len(numerator) > len(denominator):
            raise ValueError(
                f"the plant is improper: numerator of degree {len(numerator) - 1}, denominator of degree "
                f"{len(denominator) - 1}"
            )
        if all(coefficient == 0 for coefficient in numerator):
            raise ValueError("the numerator is zero: no input moves the output")
        self.count = len(form.names)
        self.degree, self.order = len(numerator) - 1, len(denominator) - 1
        monic = [part / denominator[0] for part in (*numerator, *denominator[1:])]
        self.texts = [str(part).replace("**", "^") for part in monic]
        self._written = Compiled(symbols(form.names), [*numerator, *denominator])

    def written(self, values: Array) -> TransferFunction:
        """The plant as it is written, its leading coefficient included, for constants of shape (p,).

        Raises
        ------
        ValueError
            If a coefficient is not a number, or the first one of a polynomial is zero.
        """
        found = self._written(values)
        numerator, denominator = found[: self.degree + 1], found[self.degree + 1 :]
        if not np.all(np.isfinite(found)):
            raise ValueError("a coefficient is not a finite number with these constants")
        if denominator[0] == 0.0 or numerator[0] == 0.0:
            which = "denominator" if denominator[0] == 0.0 else "numerator"
            raise ValueError(f"the first coefficient of the {which} is zero with these constants")
        return TransferFunction(tuple(numerator), tuple(denominator))

    def monic(self, values: Array) -> Array:
        """[b_0 … b_m, a_1 … a_n] of the monic plant, shape (m + 1 + n,); NaN where they are no numbers."""
        found = self._written(values)
        split = self.degree + 1
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.concatenate([found[:split], found[split + 1 :]]) / found[split]

    def derivatives(self, values: Array) -> Array:
        """Derivatives of :meth:`monic`, shape (m + 1 + n, p), by central differences."""
        columns = []
        for i, value in enumerate(values):
            step = DIFFERENCE * (abs(value) or 1.0)
            ends = []
            for side in (1.0, -1.0):
                moved = values.copy()
                moved[i] += side * step
                ends.append(self.monic(moved))
            columns.append((ends[0] - ends[1]) / (2.0 * step))
        return np.column_stack(columns) if columns else np.zeros((self.degree + 1 + self.order, 0))

    def sensitive(self, values: Array) -> Array:
        """:meth:`derivatives` by the relative change of each constant, with rounding errors at zero."""
        table = self.derivatives(values) * np.where(values == 0.0, 1.0, np.abs(values))
        sizes = np.maximum(np.abs(self.monic(values)), np.max(np.abs(table), axis=1, initial=0.0))
        table[np.abs(table) <= NO_DEPENDENCE * sizes[:, None]] = 0.0
        return table


@lru_cache(maxsize=64)
def coefficients_of(form: LinearForm) -> Coefficients:
    """The coefficients of a form, compiled once.

    Raises
    ------
    ValueError
        If the form is not a proper plant.
    """
    return Coefficients(form)
