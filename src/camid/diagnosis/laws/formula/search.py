"""Every form of the dictionary fitted to a learned law, weighted with what the recording says of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.laws.formula.bends import Range
from camid.diagnosis.laws.formula.dictionary import FORMS, Form
from camid.fitting.linearised_law import LinearisedLaw

Array = NDArray[np.float64]

# First guesses of the bends that are refined, and the evaluations that one may take.
BEST_STARTS = 2
MOST_EVALUATIONS = 30
# Forms with bends whose first guesses leave least, which are refined.
MOST_REFINED = 12
# Share of a column that is left beside what the coefficients absorb, below which nothing is.
LEAST_LEFT = 1e-6
# Change of the output by a column, as a share of the largest that one of its length may make, that is rounding.
ROUNDING = 1e-12
# Digits of the length that a free power counts x in.
DIGITS_OF_LENGTH = 2


@dataclass(frozen=True)
class FittedForm:
    """A form with its numbers.

    Attributes
    ----------
    form : Form
    amplitudes, bends : ndarray, shapes (a,) and (b,)
        In x/X.
    length : float
        X.
    left : float
        Sum of squares that it leaves, to first order.
    """

    form: Form
    amplitudes: Array
    bends: Array
    length: float
    left: float = np.inf

    def values(self, at: Array) -> Array:
        """Of the form at some points, shape (N,)."""
        return np.asarray(self.form.columns(at / self.length, self.bends) @ self.amplitudes)

    @property
    def vector(self) -> Array:
        """Amplitudes and bends, shape (a + b,)."""
        return np.concatenate([self.amplitudes, self.bends])

    def with_vector(self, vector: Array) -> FittedForm:
        """The same form with other numbers."""
        count = len(self.amplitudes)
        return FittedForm(self.form, vector[:count], vector[count:], self.length, self.left)

    def bounds(self, visited: Range) -> tuple[Array, Array]:
        """Least and largest numbers, shapes (a + b,), on a range of x/X."""
        low, high = self.form.bounds(visited)
        free = np.full(len(self.amplitudes), np.inf)
        return np.concatenate([-free, low]), np.concatenate([free, high])


def length_of(grid: Array) -> float:
    """What x is counted in: the largest |x|, with few digits."""
    return float(f"{np.max(np.abs(grid)):.{DIGITS_OF_LENGTH - 1}e}")


def fitted_forms(law: LinearisedLaw, forms: Sequence[Form] = FORMS) -> list[FittedForm]:
    """All forms with the numbers that leave least, the fewest squares first.

    Parameters
    ----------
    law : LinearisedLaw
    forms : sequence of Form
    """
    length = length_of(law.grid)
    x = law.grid / length
    visited = Range(float(x[0]), float(x[-1]))
    found, bent = [], []
    for form in forms:
        if form.symmetric and not visited.low < 0.0 < visited.high:
            continue
        if not form.curved and law.absorbed.line:
            continue
        if form.bends:
            guesses = list(form.starts(visited))
            lefts = _left(law, np.stack([form.columns(x, guess) for guess in guesses]))
            starts = [(float(left), tuple(guess.tolist())) for left, guess in zip(lefts, guesses, strict=True)]
            bent.append((min(starts)[0], form, starts))
            continue
        left, amplitudes = _amplitudes(law, form.columns(x, np.zeros(0)))
        found.append(FittedForm(form, amplitudes, np.zeros(0), length, left))
    for _, form, starts in sorted(bent, key=lambda entry: entry[0])[:MOST_REFINED]:
        found += [_bent(law, form, x, visited, length, start) for _, start in _apart(sorted(starts), form, visited)]
    best: dict[int, FittedForm] = {}
    for each in sorted((f for f in found if np.isfinite(f.left)), key=lambda f: f.left):
        best.setdefault(id(each.form), each)
    return list(best.values())


def _bent(
    law: LinearisedLaw, form: Form, x: Array, visited: Range, length: float, start: tuple[float, ...]
) -> FittedForm:
    """A form with the numbers near a first guess that leave least."""
    refined = _refined(law, form, x, visited, np.array(start))
    left, amplitudes = _amplitudes(law, form.columns(x, refined))
    return FittedForm(form, amplitudes, refined, length, left)


def _apart(
    starts: Sequence[tuple[float, tuple[float, ...]]], form: Form, visited: Range
) -> list[tuple[float, tuple[float, ...]]]:
    """The best of the first guesses that lie apart from one another."""
    low, high = form.bounds(visited)
    chosen: list[tuple[float, tuple[float, ...]]] = []
    for left, start in starts:
        near = any(np.max(np.abs(np.array(start) - np.array(other)) / (high - low)) < 0.05 for _, other in chosen)
        if not near:
            chosen.append((left, start))
        if len(chosen) == BEST_STARTS:
            break
    return [each for each in chosen if np.isfinite(each[0])]


def _refined(law: LinearisedLaw, form: Form, x: Array, visited: Range, start: Array) -> Array:
    """The bends near a first guess that leave least (variable projection: Golub & Pereyra 1973)."""
    from scipy.optimize import least_squares

    low, high = form.bounds(visited)

    def missed(bends: Array) -> Array:
        columns = law.factor_of_any @ form.columns(x, bends)
        lengths = np.linalg.norm(columns, axis=0)
        kept = columns[:, lengths > 0.0]
        basis = np.linalg.qr(kept)[0]
        return np.asarray(law.target - basis @ (basis.T @ law.target))

    inside = np.clip(start, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    found = least_squares(
        missed,
        inside,
        bounds=(low, high),
        x_scale=high - low,
        diff_step=np.full(len(start), 1e-4),
        max_nfev=MOST_EVALUATIONS,
    )
    return np.asarray(found.x)


def _amplitudes(law: LinearisedLaw, columns: Array) -> tuple[float, Array]:
    """Sum of squares that a form's columns leave, and their amplitudes; infinite where one of them does nothing."""
    table, lengths, works = _table(law, columns)
    if not works:
        return np.inf, np.zeros(columns.shape[1])
    amplitudes = np.linalg.lstsq(table / lengths, law.target, rcond=1e-10)[0] / lengths
    missed = law.target - table @ amplitudes
    return float(missed @ missed) + law.rest, amplitudes


def _left(law: LinearisedLaw, columns: Array) -> Array:
    """Sums of squares that several tables of columns leave, shape (s, G, a): shape (s,)."""
    table, lengths, works = _table(law, columns)
    left = np.full(len(columns), np.inf)
    basis = np.linalg.qr(table[works] / lengths[works, None])[0]
    missed = law.target - np.einsum("sna,sa->sn", basis, law.target @ basis)
    left[works] = np.einsum("sn,sn->s", missed, missed) + law.rest
    return left


def _table(law: LinearisedLaw, columns: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """What columns, shape (…, G, a), do to the output, shape (…, n, a).

    Beside it their lengths, shape (…, a), and whether each of a table's does anything, shape (…).
    """
    finite = np.asarray(np.isfinite(columns).all(axis=(-2, -1)))
    columns = np.where(finite[..., None, None], columns, 0.0)
    reduced = law.absorbed.without(columns)
    table = law.factor @ reduced
    sizes = np.linalg.norm(columns - columns.mean(axis=-2, keepdims=True), axis=-2)
    sizes_left, lengths = np.linalg.norm(reduced, axis=-2), np.linalg.norm(table, axis=-2)
    least = ROUNDING * np.linalg.norm(law.factor)
    works = (sizes_left > LEAST_LEFT * np.maximum(sizes, 1e-300)) & (lengths > least * sizes_left)
    return table, lengths, finite & works.all(axis=-1)
