"""Poles and zeros of models with their uncertainty.

To first order a root r of Σ c_i s^(n−i) moves by dr = −Σ r^(n−i) dc_i / (Σ (n−i) c_i r^(n−i−1)); a repeated root has
no such derivative (Guillaume, Schoukens & Pintelon 1989, IEEE Trans. Instrum. Meas. 38, 1006–1011).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.analysis.linear_model import LinearModel
from camid.analysis.view import ShortTable, View, common_mapping
from camid.number_text import plain, with_deviation

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Half axis of the ellipse that holds a normal pair with a probability of 95 %, in standard deviations: √5.991.
ELLIPSE_95 = 2.447747
# A slope that is smaller than this, relative to its terms, is that of a repeated root.
REPEATED = 1e-6
# Share of a value below which its deviation is the rounding error of differences.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Root:
    """A pole or a zero.

    Attributes
    ----------
    model : str
    kind : {"pole", "zero"}
    value : complex
        rad/s.
    covariance : ndarray, shape (2, 2), or None
        Of real and imaginary part; None where the model states none, or the root is a repeated one.
    """

    model: str
    kind: str
    value: complex
    covariance: Array | None

    @property
    def is_real(self) -> bool:
        """Whether it lies on the real axis."""
        return self.value.imag == 0.0

    @property
    def natural_frequency(self) -> float:
        """|r| in rad/s."""
        return abs(self.value)

    @property
    def damping_ratio(self) -> float:
        """−Re r/|r|; NaN at the origin."""
        return -self.value.real / abs(self.value) if self.value != 0.0 else float("nan")

    def deviation_along(self, direction: complex) -> float | None:
        """Standard deviation along a direction of the plane, of length one."""
        if self.covariance is None:
            return None
        vector = np.array([direction.real, direction.imag])
        return float(np.sqrt(max(vector @ self.covariance @ vector, 0.0)))

    @property
    def frequency_deviation(self) -> float | None:
        """Standard deviation of |r|: along the radius."""
        return self.deviation_along(self.value / abs(self.value)) if self.value != 0.0 else None

    @property
    def damping_deviation(self) -> float | None:
        """Standard deviation of the damping ratio, to first order."""
        if self.covariance is None or self.value == 0.0:
            return None
        x, y, radius = self.value.real, self.value.imag, abs(self.value)
        slope = np.array([-(y**2), x * y]) / radius**3
        return float(np.sqrt(max(float(slope @ self.covariance @ slope), 0.0)))

    def ellipse(self, count: int = 181) -> NDArray[np.complex128] | None:
        """Points of the 95 % ellipse, shape (count,); of a real root an interval of the same probability.

        The interval has half the length of the ellipse's axis times 1.960/2.448, as it has one dimension.
        """
        if self.covariance is None:
            return None
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        if self.is_real:
            deviation = float(np.sqrt(self.covariance[0, 0]))
            return np.asarray(self.value + 1.959964 * deviation * np.cos(angle), dtype=complex)
        powers, axes = np.linalg.eigh(self.covariance)
        points = axes @ (np.sqrt(np.maximum(powers, 0.0))[:, None] * np.array([np.cos(angle), np.sin(angle)]))
        return np.asarray(self.value + ELLIPSE_95 * (points[0] + 1j * points[1]))


def roots_of(model: LinearModel) -> Iterator[Root]:
    """Poles and zeros of a model, from the origin outwards."""
    system = model.plant.to_control()
    split = len(model.plant.numerator)
    for kind, values, coefficients, rows in (
        ("pole", system.poles(), model.plant.denominator, slice(split, None)),
        ("zero", system.zeros(), model.plant.numerator, slice(0, split)),
    ):
        factor = None if model.factor is None else model.factor[rows]
        if factor is not None and kind == "pole":  # the leading coefficient is one
            factor = np.vstack([np.zeros(factor.shape[1]), factor])
        for value in sorted(map(complex, values), key=_from_the_origin):
            yield Root(model.name, kind, value, _covariance(value, np.array(coefficients), factor))


def _from_the_origin(root: complex) -> tuple[float, float]:
    return abs(root), root.imag


def _covariance(root: complex, coefficients: Array, factor: Array | None) -> Array | None:
    """Covariance of real and imaginary part from F, shape (n + 1, r), of the polynomial's coefficients."""
    if factor is None:
        return None
    degree = len(coefficients) - 1
    powers = root ** np.arange(degree, -1, -1)
    slopes = coefficients[:-1] * np.arange(degree, 0, -1) * root ** np.arange(degree - 1, -1, -1)
    slope = np.sum(slopes)
    if abs(slope) <= REPEATED * float(np.sum(np.abs(slopes))):
        return None
    moved = -(powers @ factor) / slope
    if root.imag == 0.0:
        moved = moved.real.astype(complex)
    pairs = np.array([moved.real, moved.imag])
    return np.asarray(pairs @ pairs.T)


@dataclass(frozen=True, repr=False)
class PolesAndZeros(View):
    """What ``camid.poles`` returns.

    Attributes
    ----------
    roots : list of Root
        Of all models.
    names : list of str
        The models.
    remarks : tuple of str
    """

    roots: list[Root]
    names: list[str]
    remarks: tuple[str, ...] = ()

    columns: ClassVar[tuple[str, ...]] = ("model", "kind", "real", "imaginary")

    @property
    def numbers(self) -> pd.DataFrame:
        """A row for each root.

        ``model``, ``kind``, ``real`` and ``imaginary`` in rad/s, their ``variance_…`` and ``covariance`` (rad²/s²),
        ``natural_frequency`` (rad/s) and ``damping_ratio`` with standard deviations; NaN where they are not known.
        """
        import pandas as pd

        unknown = np.full((2, 2), np.nan)
        rows = []
        for root in self.roots:
            table = unknown if root.covariance is None else root.covariance
            rows.append(
                {
                    "model": root.model,
                    "kind": root.kind,
                    "real": root.value.real,
                    "imaginary": root.value.imag,
                    "variance_real": table[0, 0],
                    "variance_imaginary": table[1, 1],
                    "covariance": table[0, 1],
                    "natural_frequency": root.natural_frequency,
                    "natural_frequency_deviation": _number(root.frequency_deviation),
                    "damping_ratio": root.damping_ratio,
                    "damping_ratio_deviation": _number(root.damping_deviation),
                }
            )
        return pd.DataFrame(rows)

    def short_table(self) -> ShortTable:
        """Roots with their standard deviations, one of each pair."""
        rows = []
        for root in self.roots:
            if root.value.imag < 0.0:
                continue
            position = [_estimate(root.value.real, root.deviation_along(1.0))]
            shape = [_estimate(root.natural_frequency, root.frequency_deviation)]
            if not root.is_real:
                position.append(f"± j({_estimate(root.value.imag, root.deviation_along(1j))})")
                shape.append(f"ζ = {_estimate(root.damping_ratio, root.damping_deviation)}")
            rows.append((root.model, root.kind, "\n".join(position), "\n".join(shape)))
        headings = ("model", "root", "position, rad/s", "natural frequency, rad/s")
        return ShortTable("Poles and zeros ± standard deviations", headings, rows, texts=2)

    def said(self) -> tuple[str, ...]:
        """What is not in it."""
        repeated = [r for r in self.roots if r.covariance is None and not any(r.model in s for s in self.remarks)]
        if not repeated:
            return self.remarks
        names = ", ".join(dict.fromkeys(r.model for r in repeated))
        return (*self.remarks, f"{names}: a repeated root has no standard deviation of first order")

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        rows = [
            {str(key): None if isinstance(v, float) and not np.isfinite(v) else v for key, v in row.items()}
            for row in self.numbers.to_dict("records")
        ]
        return common_mapping(self, unit="rad/s", roots=rows)

    def _draw(self) -> Figure:
        from camid.drawing.poles import draw

        return draw(self)


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def _estimate(value: float, deviation: float | None) -> str:
    """With its deviation; a value that is not uncertain alone."""
    if deviation is None or not deviation > ROUNDING * abs(value):
        return plain(value + 0.0, 6)  # not minus zero
    return with_deviation(value, deviation)
