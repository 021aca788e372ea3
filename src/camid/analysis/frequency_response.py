"""Frequency responses of models with bands from the covariance, and that of a recording beside them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log, pi
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.analysis.empirical_response import EmpiricalResponse, sensor_response
from camid.analysis.linear_model import SMALL, LinearModel
from camid.analysis.view import ShortTable, View, common_mapping
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.number_text import plain, with_deviation
from camid.simulation.declared_units import DeclaredUnits
from camid.writing import without_infinities

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

RECORDED = "recorded"
DECIBELS = 20.0 / log(10.0)
POINTS = 500
# Points about a resonance, within so many half widths of it.
POINTS_OF_RESONANCE, HALF_WIDTHS = 61, 8.0
ROWS_SHOWN = 7


@dataclass(frozen=True)
class ResponseCurve:
    """Frequency response of a model.

    Attributes
    ----------
    name : str
    angular_frequency : ndarray, shape (F,)
        rad/s.
    magnitude : ndarray, shape (F,)
        Units of y over those of u.
    phase : ndarray, shape (F,)
        rad, unwrapped.
    relative_deviation, phase_deviation : ndarray, shape (F,), or None
        Standard deviation of the magnitude over the magnitude, and of the phase in rad; None without covariance.
    """

    name: str
    angular_frequency: Array
    magnitude: Array
    phase: Array
    relative_deviation: Array | None
    phase_deviation: Array | None

    @classmethod
    def of(cls, model: LinearModel, angular_frequency: Array, camera: Acquisition | None) -> ResponseCurve:
        """Of a linear model; seen by a camera where one is given."""
        response = _response(model.plant, angular_frequency)
        seen = np.ones(len(angular_frequency), complex)
        shift = np.zeros(len(angular_frequency))
        if camera is not None:
            seen = sensor_response(angular_frequency, camera)
            exposure = 0.0 if camera.sensor == "instant" else float(camera.exposure or 0.0)
            # Where the exposure holds whole cycles the mean is zero, and half a turn ahead beyond.
            turns = np.floor(angular_frequency * exposure / (2.0 * pi))
            shift = pi * turns - angular_frequency * (camera.latency + 0.5 * exposure)
        spreads = []
        for direction in () if model.factor is None else model.factor.T:
            there, back = (_response(model.moved(direction, s), angular_frequency) for s in (SMALL, -SMALL))
            with np.errstate(divide="ignore", invalid="ignore"):
                spreads.append(np.log(there / back) / (2.0 * SMALL))
        table = np.array(spreads)
        return cls(
            model.name,
            angular_frequency,
            np.abs(response * seen),
            np.unwrap(np.angle(response)) + shift,
            np.sqrt(np.sum(table.real**2, axis=0)) if spreads else None,
            np.sqrt(np.sum(table.imag**2, axis=0)) if spreads else None,
        )

    @property
    def decibels(self) -> Array:
        """Magnitude in dB."""
        with np.errstate(divide="ignore"):
            return DECIBELS * np.log(self.magnitude)

    @property
    def decibel_deviation(self) -> Array | None:
        """Standard deviation of the magnitude in dB."""
        return None if self.relative_deviation is None else DECIBELS * self.relative_deviation


def _response(plant: TransferFunction, angular_frequency: Array) -> ComplexArray:
    """B(jω)/A(jω); not finite at a pole."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(plant.frequency_response(angular_frequency), dtype=complex)


def frequencies_for(
    models: list[LinearModel], limits: tuple[float, float] | None, empirical: EmpiricalResponse | None
) -> Array:
    """Angular frequencies in rad/s: those that python-control chooses, or between limits, finer about resonances."""
    if limits is None:
        import control

        found = control.frequency_response([m.plant.to_control() for m in models])[0].omega
        limits = float(found[0]), float(found[-1])
        if empirical is not None and len(empirical.angular_frequency):
            limits = min(limits[0], 0.8 * float(empirical.angular_frequency[0])), max(limits[1], empirical.nyquist)
    grid = [np.geomspace(*limits, POINTS)]
    for model in models:
        for pole in model.plant.poles():
            if pole.imag > 0.0:
                half = max(abs(pole.real), 1e-6 * abs(pole))
                grid.append(abs(pole) + half * np.linspace(-HALF_WIDTHS, HALF_WIDTHS, POINTS_OF_RESONANCE))
    merged = np.unique(np.concatenate(grid))
    return merged[(merged >= limits[0]) & (merged <= limits[1])]


@dataclass(frozen=True, repr=False)
class FrequencyResponses(View):
    """What ``camid.bode`` returns.

    Attributes
    ----------
    curves : list of ResponseCurve
    empirical : EmpiricalResponse or None
        Of the recording.
    seen_by_camera : bool
        Whether exposure and latency are part of what is shown.
    units : DeclaredUnits
        What people read input and output in.
    remarks : tuple of str
    """

    curves: list[ResponseCurve]
    empirical: EmpiricalResponse | None
    seen_by_camera: bool
    units: DeclaredUnits
    remarks: tuple[str, ...] = ()

    columns: ClassVar[tuple[str, ...]] = ("model", "angular_frequency", "frequency", "magnitude")

    @property
    def shows(self) -> str:
        """What is shown, in words."""
        return "plant, exposure and latency of the sensor" if self.seen_by_camera else "plant alone"

    def in_declared_units(self) -> FrequencyResponses:
        """The same with magnitudes as people read them."""
        factor = self.units.factor("y/u")
        found = self.empirical
        return replace(
            self,
            curves=[replace(curve, magnitude=curve.magnitude / factor) for curve in self.curves],
            empirical=None if found is None else replace(found, response=found.response / factor),
        )

    @property
    def numbers(self) -> pd.DataFrame:
        """Rows of all models, then those of the recording.

        ``model``, ``angular_frequency`` (rad/s), ``frequency`` (Hz), ``magnitude`` (y/u in SI units), ``magnitude_db``
        and its standard deviation, ``phase`` and its standard deviation in degrees, ``coherence`` of the recording.
        """
        import pandas as pd

        parts = [_rows(c.name, c, None) for c in self.curves]
        if self.empirical is not None:
            recorded = self.recorded_curve()
            parts.append(_rows(recorded.name, recorded, self.empirical.coherence))
        return pd.concat([pd.DataFrame(part) for part in parts], ignore_index=True)

    def recorded_curve(self) -> ResponseCurve:
        """The response of the recording, its phase within half a turn of the first model's."""
        found = self.empirical
        assert found is not None
        first = self.curves[0]
        expected = np.interp(found.angular_frequency, first.angular_frequency, first.phase)
        phase = expected + np.angle(found.response * np.exp(-1j * expected))
        deviation = found.relative_deviation
        return ResponseCurve(RECORDED, found.angular_frequency, np.abs(found.response), phase, deviation, deviation)

    def short_table(self) -> ShortTable:
        """Magnitude and phase at a few frequencies."""
        rows = []
        for curve in self.in_declared_units().curves:
            omega, label = curve.angular_frequency, curve.name
            for at in np.geomspace(omega[0], omega[-1], ROWS_SHOWN):
                magnitude = _estimate(at, omega, curve.decibels, curve.decibel_deviation, 2)
                turned = None if curve.phase_deviation is None else np.degrees(curve.phase_deviation)
                phase = _estimate(at, omega, np.degrees(curve.phase), turned, 1)
                rows.append((label, plain(float(at), 3), plain(float(at / (2.0 * pi)), 3), magnitude, phase))
                label = ""
        headings = ("model", "rad/s", "Hz", f"magnitude, dB of {self.units.text('y/u')}", "phase, °")
        return ShortTable(f"Frequency response: {self.shows}", headings, rows)

    def said(self) -> tuple[str, ...]:
        """What is not in it."""
        found = [*self.remarks]
        if self.empirical is not None:
            hidden = int(np.count_nonzero(~self.empirical.is_seen))
            found.append(
                f"{RECORDED}: Welch's method, segments of {plain(self.empirical.segment, 3, 's')}, hold "
                + ("divided out" if self.seen_by_camera else "and sensor divided out")
                + (f"; {hidden} frequencies that the noise covers are not drawn" if hidden else "")
            )
        return tuple(found)

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        found = [
            {
                "name": c.name,
                "angular_frequency": c.angular_frequency.tolist(),
                "magnitude": c.magnitude.tolist(),
                "phase": c.phase.tolist(),
                "relative_deviation": None if c.relative_deviation is None else c.relative_deviation.tolist(),
                "phase_deviation": None if c.phase_deviation is None else c.phase_deviation.tolist(),
            }
            for c in (*self.curves, *([] if self.empirical is None else [self.recorded_curve()]))
        ]
        unit = {"angular_frequency": "rad/s", "magnitude": "y/u", "phase": "rad", **self.units.to_mapping()}
        curves = [without_infinities(c) for c in found]
        return common_mapping(self, shows=self.shows, units=unit, models=curves)

    def _draw(self) -> Figure:
        from camid.drawing.bode import draw

        return draw(self)


def _estimate(at: float, omega: Array, values: Array, deviations: Array | None, decimals: int) -> str:
    """A value at a frequency, with its standard deviation where that is known."""
    value = float(np.interp(at, omega, values))
    deviation = 0.0 if deviations is None else float(np.interp(at, omega, deviations))
    if not deviation > 0.0:
        return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")  # not minus zero
    return with_deviation(value, deviation)


def _rows(name: str, curve: ResponseCurve, coherence: Array | None) -> dict[str, Any]:
    nothing = np.full(len(curve.angular_frequency), np.nan)
    relative = nothing if curve.relative_deviation is None else curve.relative_deviation
    turned = nothing if curve.phase_deviation is None else curve.phase_deviation
    return {
        "model": name,
        "angular_frequency": curve.angular_frequency,
        "frequency": curve.angular_frequency / (2.0 * pi),
        "magnitude": curve.magnitude,
        "magnitude_db": curve.decibels,
        "magnitude_db_deviation": DECIBELS * relative,
        "phase": np.degrees(curve.phase),
        "phase_deviation": np.degrees(turned),
        "coherence": nothing if coherence is None else coherence,
    }
