"""Frequency response of a recording, without a model: cross-spectra by Welch's method.

H = S_uy/S_uu, in a closed loop S_ry/S_ru with the reference r, which the noise does not follow (Ljung 1999, System
Identification, 2nd ed., sections 6.4 and 13.5). What hold and, if asked, camera do to it is known and divided out;
content that aliases from beyond the Nyquist frequency stays in it. Standard deviations are those of Bendat and Piersol
(2010), Random Data, 4th ed., section 9.2: sqrt((1 − γ²)/(2 n γ²)) with the coherence γ² and n averages.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.camera_models import model_1_response
from camid.errors import InputError
from camid.identification.from_recordings import acquisition_of
from camid.identification.welch import cross_spectrum
from camid.number_text import plain
from camid.recording.recording import Recording
from camid.simulation.model import Simulation

Array = NDArray[np.float64]

# Length of a segment: this many time constants of the slowest pole, within these shares of the recording.
TIME_CONSTANTS = 8.0
SHORTEST_SHARE, LONGEST_SHARE = 0.125, 0.5
FEWEST_ROWS = 16
# Independent averages for each of the segments that overlap by half with a Hann window: 1/(1 + 2/36).
INDEPENDENT = 0.947
LEAST_COHERENCE = 1e-6
CHANCE = 1e-3


@dataclass(frozen=True)
class EmpiricalResponse:
    """Frequency response of a recording.

    Attributes
    ----------
    angular_frequency : ndarray, shape (F,)
        rad/s, between zero and the Nyquist frequency.
    response : ndarray of complex, shape (F,)
        Units of y over those of u.
    coherence : ndarray, shape (F,)
        γ², between zero and one.
    averages : float
        Number of independent ones.
    segment : float
        Seconds.
    nyquist : float
        rad/s.
    """

    angular_frequency: Array
    response: NDArray[np.complex128]
    coherence: Array
    averages: float
    segment: float
    nyquist: float

    @property
    def relative_deviation(self) -> Array:
        """Standard deviation of the magnitude over the magnitude, and of the phase in rad."""
        kept = np.clip(self.coherence, LEAST_COHERENCE, 1.0)
        return np.sqrt((1.0 - kept) / (2.0 * self.averages * kept))

    @property
    def is_seen(self) -> NDArray[np.bool_]:
        """Where the coherence is more than noise alone would show in one of a thousand frequencies.

        That is 1 − α^(1/(n − 1)) (Carter 1987, Proc. IEEE 75, 236–255).
        """
        degrees = max(self.averages - 1.0, 1e-3)
        return np.asarray(self.coherence > 1.0 - CHANCE ** (1.0 / degrees))


def hold_response(
    angular_frequency: Array, acquisition: Acquisition, *, logged: bool = False
) -> NDArray[np.complex128]:
    """What a hold makes of samples, below the Nyquist frequency: a mean over a period, or a triangle of two.

    Where the input was logged at times of its own (``logged``), the samples are means of a held input over the period
    that follows, or its values.
    """
    angle = angular_frequency * acquisition.period / (2.0 * pi)
    if acquisition.hold == "zoh":
        delay = np.exp(-1j * pi * angle)
        return np.asarray(delay / np.sinc(angle) if logged else np.sinc(angle) * delay)
    if logged:
        return np.ones(len(angle), dtype=complex)
    return np.asarray(np.sinc(angle) ** 2 if acquisition.hold == "foh" else np.ones(len(angle)), dtype=complex)


def sensor_response(angular_frequency: Array, acquisition: Acquisition) -> NDArray[np.complex128]:
    """What exposure and latency make of the motion."""
    if acquisition.sensor == "instant":
        return np.asarray(np.exp(-1j * angular_frequency * acquisition.latency))
    return model_1_response(angular_frequency, acquisition.period, acquisition.exposure, acquisition.latency)


def empirical_response(
    recordings: list[Recording],
    simulation: Simulation,
    *,
    seen_by_camera: bool,
    segment: float | None = None,
) -> EmpiricalResponse:
    """Frequency response from the input to the output of recordings.

    Parameters
    ----------
    recordings : list of Recording
        Of one rig, with one period.
    simulation : Simulation
        What is believed of hold, sensor and slowest pole.
    seen_by_camera : bool
        Whether exposure and latency stay in it.
    segment : float, optional
        Seconds over which a spectrum is taken; eight time constants of the slowest pole where they fit.

    Raises
    ------
    InputError
        If there is no input, or too little of it.
    """
    column = simulation.input_column
    if column is None:
        raise InputError(
            "without an input a recording has no frequency response", where=simulation.source, hint="leave it out"
        )
    acquisition = acquisition_of(recordings[0], simulation)
    logged = bool(recordings[0].logs)
    shortest = min(len(r) - int(np.argmin(r.missing)) for r in recordings)
    rows = _rows_of_segment(simulation, acquisition.period, shortest, segment, recordings[0].source)
    sums: dict[str, Any] = {}
    segments = 0
    for one in recordings:
        count = max((len(one) - int(np.argmin(one.missing)) - rows) // max(rows - rows // 2, 1) + 1, 1)
        segments += count
        # Where the log of an input begins before the frames, no output is known.
        rows_known = slice(int(np.argmin(one.missing)), None)
        names = [column, simulation.output_column]
        names += [] if simulation.controller is None else [simulation.controller.reference]
        u, y, *reference = (one.columns[name][rows_known] for name in names)
        drive = reference[0] if reference else u
        pairs = {"du": (drive, u), "dy": (drive, y), "dd": (drive, drive), "uu": (u, u), "yy": (y, y)}
        for name, (first, second) in pairs.items():
            frequency, spectrum = cross_spectrum(first, second, acquisition.period, rows)
            sums[name] = sums.get(name, np.zeros(len(frequency))) + count * spectrum
    inner = slice(1, -1)
    angular = 2.0 * pi * frequency[inner]
    driven = np.abs(sums["du"][inner])
    if not np.any(driven > 0.0):
        raise InputError(f"column '{column}' does not move", where=recordings[0].source, hint="excite the rig")
    with np.errstate(divide="ignore", invalid="ignore"):
        response = sums["dy"][inner] / sums["du"][inner] / hold_response(angular, acquisition, logged=logged)
        # Both spectra of a ratio vary; that of an input with itself does not.
        powers = {name: sums[name][inner].real for name in ("dd", "uu", "yy")}
        inverse = (powers["dd"] * powers["yy"]) / np.abs(sums["dy"][inner]) ** 2
        inverse += (powers["dd"] * powers["uu"]) / driven**2 - 1.0
        coherence = 1.0 / inverse
    if not seen_by_camera:
        response = response / sensor_response(angular, acquisition)
    known = np.isfinite(response) & np.isfinite(coherence)
    return EmpiricalResponse(
        angular[known],
        response[known],
        np.clip(coherence[known], 0.0, 1.0),
        max(INDEPENDENT * segments, 1.0),
        rows * acquisition.period,
        pi / acquisition.period,
    )


def _rows_of_segment(simulation: Simulation, period: float, available: int, segment: float | None, source: str) -> int:
    """Rows of a segment, an even number."""
    if available < FEWEST_ROWS:
        raise InputError(f"{available} rows have no spectrum", where=source, hint=f"it takes at least {FEWEST_ROWS}")
    if segment is not None:
        rows = round(segment / period)
        if not FEWEST_ROWS // 2 <= rows <= available:
            lasts = plain(available * period, 4, "s")
            raise InputError(
                f"a segment of {segment:g} s has {rows} of {available} rows",
                where=source,
                hint=f"choose between {plain(FEWEST_ROWS // 2 * period, 4, 's')} and {lasts}",
            )
        return rows - rows % 2
    slowest = float(np.min(np.abs(simulation.plant.poles().real), initial=np.inf))
    wanted = TIME_CONSTANTS / slowest / period if slowest > 0.0 else np.inf
    rows = int(np.clip(wanted, SHORTEST_SHARE * available, LONGEST_SHARE * available))
    return max(rows - rows % 2, FEWEST_ROWS // 2)
