"""Which constants a recording cannot tell apart, and which combinations of them it determines.

Constants that can change together without any change of the plant's coefficients make up the null space of the
coefficients' derivatives. Where it is the same everywhere in the logarithms of the constants, products of powers are
determined (stiffness/mass); where it is the same everywhere in the constants themselves, sums are. Elsewhere the
coefficients say what is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.physical.linear_form import Coefficients

Array = NDArray[np.float64]

# Points about the nominal one at which the null space is looked at, as factors of the constants.
POINTS = ((1.0, 1.0), (1.31, 0.83), (0.77, 1.19), (1.13, 1.47))
LARGEST_DENOMINATOR = 6


class Accuracy(NamedTuple):
    """How exactly changes are known.

    ``zero`` is the share of the largest singular value below which one is zero, and ``agreement`` that of null spaces
    at different points, and of their entries with fractions.
    """

    zero: float
    agreement: float


# Of coefficients, and of simulations.
EXACT = Accuracy(1e-7, 1e-4)
SIMULATED = Accuracy(1e-5, 1e-2)


@dataclass(frozen=True)
class Undetermined:
    """What a recording leaves open of the free constants.

    Attributes
    ----------
    held : tuple of str
        Constants that are kept at their believed values, so that the others follow.
    open : tuple of str
        Constants that are not determined each, those included.
    combinations : tuple of str
        What is determined of them, as expressions: ``stiffness/mass``.
    """

    held: tuple[str, ...] = ()
    open: tuple[str, ...] = ()
    combinations: tuple[str, ...] = ()

    def sentence(self, values: Mapping[str, float]) -> str | None:
        """What is not determined, and what is done about it; None where all is."""
        if not self.open:
            return None
        if len(self.open) == 1:
            name = self.open[0]
            return f"the recording says nothing of {name}, which stays {values[name]:g}; put what you know under fixed"
        kept = _listed([f"{name} at {values[name]:g}" for name in self.held])
        known = list(self.combinations)
        said = f"determines {_listed(known)}, but not each of" if known else "does not tell apart"
        return (
            f"the recording {said} {_listed(list(self.open))}: the others are given with {kept}; put what you know "
            "under fixed"
        )


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def undetermined(
    coefficients: Coefficients, names: Sequence[str], values: Array, free: Sequence[str], rows: NDArray[np.bool_]
) -> Undetermined:
    """What the coefficients leave open of the constants that are free.

    Parameters
    ----------
    coefficients : Coefficients
    names : sequence of str
        Of all constants, in the order of ``values``, shape (p,).
    free : sequence of str
        Which are to be estimated.
    rows : ndarray of bool, shape (m + 1 + n,)
        Which coefficients of the monic plant a recording determines.
    """
    columns = np.array([names.index(name) for name in free], dtype=int)
    tables, points = [], []
    for odd, even in POINTS:
        moved = values * np.where(np.arange(len(values)) % 2, even, odd)
        table = coefficients.sensitive(moved)[rows][:, columns]
        if np.all(np.isfinite(table)):
            # As relative changes, so that the unit of a coefficient does not count.
            sizes = np.max(np.abs(table), axis=1, keepdims=True, initial=0.0)
            tables.append(table / np.where(sizes == 0.0, 1.0, sizes))
            points.append(moved[columns])

    def of_coefficients(touched: NDArray[np.intp]) -> list[str]:
        sensitive = coefficients.sensitive(values)[:, columns]
        touching = [int(i) for i in np.flatnonzero(rows) if np.any(sensitive[i][touched])]
        # What they say beside the constants that are determined each.
        return [coefficients.texts[i] for i in _independent(sensitive[:, touched], touching)]

    return undetermined_by(free, tables, points, EXACT, of_coefficients)


def undetermined_by(
    free: Sequence[str],
    tables: Sequence[Array],
    points: Sequence[Array],
    accuracy: Accuracy,
    otherwise: Callable[[NDArray[np.intp]], list[str]] | None = None,
) -> Undetermined:
    """What is left open of constants by quantities whose changes are known.

    Parameters
    ----------
    free : sequence of str
        Names of the p constants.
    tables : sequence of ndarray, shapes (m, p)
        Changes of m quantities by relative changes of the constants, at several points.
    points : sequence of ndarray, shapes (p,)
        Values of the constants there.
    accuracy : Accuracy
        Of the tables.
    otherwise : callable, optional
        Expressions that are determined where neither products nor sums of the constants say it, for those constants
        (their indices) that are not determined each.
    """
    spaces = [(_null_space(table, accuracy), point) for table, point in zip(tables, points, strict=True) if table.size]
    smallest = min((len(space) for space, _ in spaces), default=0)
    spaces = [(space, point) for space, point in spaces if len(space) == smallest]
    if smallest == 0:
        return Undetermined()
    relative = [space for space, _ in spaces]
    # A constant of zero is measured by one; its logarithm is none.
    absolute = [_reduced(space * np.where(point == 0.0, 1.0, np.abs(point)), accuracy) for space, point in spaces]
    held = [int(np.flatnonzero(np.abs(row) > accuracy.agreement)[0]) for row in relative[0]]
    touched = np.flatnonzero(np.any(np.abs(relative[0]) > accuracy.agreement, axis=0))
    texts: list[str] = []
    followers = [int(i) for i in touched if i not in held]
    for space, kind in ((relative, "product"), (absolute, "sum")):
        exact = _fractions(space, accuracy)
        if exact is not None:
            texts = [_combination(free, held, exact[:, i], i, kind) for i in followers]
            break
    else:
        texts = [] if otherwise is None else otherwise(touched)
    return Undetermined(tuple(free[i] for i in held), tuple(free[int(i)] for i in touched), tuple(texts))


def _null_space(table: Array, accuracy: Accuracy) -> Array:
    """Basis of the null space in reduced echelon form, shape (k, p): each row has its first entry for itself."""
    _, sizes, vectors = np.linalg.svd(table)
    rank = int(np.count_nonzero(sizes > accuracy.zero * max(float(np.max(sizes, initial=0.0)), 1e-300)))
    return _reduced(vectors[rank:], accuracy)


def _independent(table: Array, candidates: Sequence[int]) -> list[int]:
    """Those rows, in their order, that are no combination of earlier ones."""
    kept: list[int] = []
    for i in candidates:
        rows = np.array([table[j] / np.linalg.norm(table[j]) for j in (*kept, i)])
        sizes = np.linalg.svd(rows, compute_uv=False)
        if sizes[-1] > EXACT.zero * sizes[0]:
            kept.append(i)
    return kept


def _reduced(rows: Array, accuracy: Accuracy) -> Array:
    """Reduced echelon form of independent rows."""
    result, done = rows.copy(), 0
    for column in range(result.shape[1]):
        if done == len(result):
            break
        pivot = done + int(np.argmax(np.abs(result[done:, column])))
        if abs(result[pivot, column]) <= accuracy.agreement * np.max(np.abs(result), initial=0.0):
            continue
        result[[done, pivot]] = result[[pivot, done]]
        result[done] /= result[done, column]
        for other in range(len(result)):
            if other != done:
                result[other] -= result[other, column] * result[done]
        done += 1
    return result


def _fractions(spaces: list[Array], accuracy: Accuracy) -> NDArray[np.object_] | None:
    """The entries as fractions, where all points agree and they are short ones; None elsewhere."""
    largest = max(1.0, *(float(np.max(np.abs(space))) for space in spaces))
    if any(np.max(np.abs(space - spaces[0])) > accuracy.agreement * largest for space in spaces):
        return None
    exact = np.empty(spaces[0].shape, object)
    for place, entry in np.ndenumerate(spaces[0]):
        exact[place] = Fraction(float(entry)).limit_denominator(LARGEST_DENOMINATOR)
        if abs(float(exact[place]) - entry) > accuracy.agreement * max(1.0, abs(entry)):
            return None
    return exact


def _combination(
    names: Sequence[str], held: Sequence[int], weights: NDArray[np.object_], follower: int, kind: str
) -> str:
    """What is determined of one constant and those that are held: it times, or less, a multiple of theirs."""
    parts = [(names[h], -weight) for h, weight in zip(held, weights, strict=True) if weight != 0]
    if kind == "product":
        above = [names[follower], *(_power(name, power) for name, power in parts if power > 0)]
        below = [_power(name, -power) for name, power in parts if power < 0]
        bottom = "*".join(below) if len(below) < 2 else f"({'*'.join(below)})"
        return "*".join(above) + (f"/{bottom}" if below else "")
    text = names[follower]
    for name, factor in parts:
        size = abs(factor)
        text += f" {'+' if factor > 0 else '-'} {name if size == 1 else f'{size}*{name}'}"
    return text


def _power(name: str, power: Fraction) -> str:
    if power == 1:
        return name
    return f"sqrt({name})" if power == Fraction(1, 2) else f"{name}^{power if power.denominator == 1 else f'({power})'}"
