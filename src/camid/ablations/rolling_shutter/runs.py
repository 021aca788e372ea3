"""Rolling shutter: when the marker's row decides the time of its exposure.

Row i of frame k is exposed over [t_k − ℓ_i − τ, t_k − ℓ_i] with ℓ_i = λ (H − 1 − i): the last of H rows is the latest.

Images. Three models of the grey-level centroid of a rendered image: the time of the middle row for everything (a
latency), the time of the row in which the measurement lies, and that of the row in which the marker lies when the
exposure of its row begins and when it ends. The last is exact for a point; a disk of diameter d is sheared and
stretched, which at acceleration (a_x, a_y) moves its centre of mass by λ²d²/32 · (a_x, 3 a_y) to leading order.

Identification. The plant's motion moves the marker along the rows (the time of a sample then depends on the sample) or
at a fixed row (a latency); the camera is declared as one with a global shutter, without and with the latency of the
row about which the marker moves.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.held_motion import HeldMotion
from camid.ablations.identification_runs import (
    by_parameter,
    excitation_signal,
    percent_errors,
    whole_experiment,
)
from camid.ablations.rendered_images import Path, circles, root_mean_square
from camid.chain.acquisition import Acquisition
from camid.identification.estimate import estimate
from camid.identification.structure import Structure
from camid.images.centroids import grey_level_centroid
from camid.images.forming import Marker
from camid.images.rolling_shutter import expose_rolling, time_in_row
from camid.paper.cases import PARAMETERS
from camid.paper.datasets import believed_plant
from camid.paper.marker_images import frame_format, time_mean

Array = NDArray[np.float64]

MODELS = ("time of the middle row", "row of the measurement", "row at begin and end")
MOTIONS = ("along the rows", "at the middle row")
DECLARED = ("no latency", "mean latency")
ITERATIONS = 200


def measurement_row_model(path: Path, exposure: float, line_time: float, middle: float) -> Array:
    """Mean position over the exposure of the row in which this mean lies, shape (2,), px."""
    mean = time_mean(path, line_time * middle, exposure)
    for _ in range(ITERATIONS):
        following = time_mean(path, line_time * mean[1], exposure)
        if abs(following[1] - mean[1]) < 1e-9:
            return following
        mean = following
    raise ValueError("the marker moves too fast along the rows for its row to be found by iteration")


def image_errors(
    imaging: Mapping[str, Any], line_time: float, exposure: float, frequency: float, diameter: float, count: int
) -> dict[str, float]:
    """Root mean square distance of each model from the grey-level centroid, px."""
    frame = frame_format(imaging)
    middle = 0.5 * (frame.height - 1)
    errors: dict[str, list[Array]] = {name: [] for name in MODELS}
    for path in circles(imaging, frequency, count):
        image = expose_rolling(path, 0.0, exposure, line_time, Marker(diameter), frame)
        measured = np.array(grey_level_centroid(image.astype(np.float32), background=0.0))
        start, end = time_in_row(path, 0.0, line_time), time_in_row(path, exposure, line_time)
        models = (
            time_mean(path, line_time * middle, exposure),
            measurement_row_model(path, exposure, line_time, middle),
            time_mean(path, start, end - start),
        )
        for name, model in zip(MODELS, models, strict=True):
            errors[name].append(model - measured)
    return {name: root_mean_square(np.array(values)) for name, values in errors.items()}


def rolling_samples(motion: HeldMotion, frames: Array, readout: float, reach: float) -> Array:
    """Camera samples of a motion along the rows about the middle row.

    Parameters
    ----------
    motion : HeldMotion
    frames : ndarray, shape (N,)
        Times t_k at which the last row's exposure ends, s. The exposure is the motion's period.
    readout : float
        Time between the first and the last row, s.
    reach : float
        Largest excursion from the middle row as a share of the rows, up to ½.
    """
    largest = np.abs(motion.position(np.linspace(0.0, frames[-1], 40 * frames.size))).max()

    def in_row(time: Array) -> Array:
        solution = time
        for _ in range(ITERATIONS):
            following = time - readout * (0.5 - reach * motion.position(solution) / largest)
            if np.max(np.abs(following - solution)) < 1e-14:
                return following
            solution = following
        raise ValueError("the marker moves too fast along the rows for its row to be found by iteration")

    return motion.mean(in_row(frames - motion.period), in_row(frames))


def identification_errors(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Bias of b0, a1 and a0 for every period, readout time, motion and declaration."""
    signal, truth = excitation_signal(shared["excitation"]), believed_plant(shared["plant"])
    rows = []
    for period in settings["periods"]:
        motion = HeldMotion(shared["plant"], signal, period)
        frames = period * np.arange(signal.size)
        for share in settings["readouts"]:
            readout = share * period
            outputs = (
                rolling_samples(motion, frames, readout, settings["reach"]),
                motion.mean(frames - period - 0.5 * readout, frames - 0.5 * readout),
            )
            for name, output in zip(MOTIONS, outputs, strict=True):
                for declared, latency in zip(DECLARED, (0.0, 0.5 * readout), strict=True):
                    acquisition = Acquisition(period, latency=latency)
                    result = estimate(Structure.of_order(2, 0), [whole_experiment(signal, output, acquisition)])
                    rows.append(
                        {
                            "part": "identification",
                            "period": float(period),
                            "readout": float(share),
                            "motion": name,
                            "declared": declared,
                            **by_parameter("error", percent_errors(result.plant, truth)),
                            "residual": 100.0 * float(np.std(result.residuals[0]) / np.std(output)),
                            "converged": bool(result.converged),
                        }
                    )
    return rows


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Distances of the models from rendered images, and bias of an identification with the wrong shutter.

    Returns
    -------
    DataFrame
        ``part`` (speed | diameter | identification). The first two: ``exposure`` (s), ``frequency`` (Hz), ``diameter``
        (px), ``model`` and ``distance`` (px, root mean square over the starting angles). Identification: ``period``
        (s), ``readout`` (share of the period), ``motion``, ``declared``, ``error_<p>`` (percent), ``residual`` (percent
        of the output's standard deviation) and ``converged``.
    """
    imaging = shared["imaging"]
    line_time = settings["image_readout"] / imaging["height"]
    shortest, fixed, paper = min(settings["exposures"]), settings["frequency_of_diameters"], imaging["marker_diameter"]
    cases = [("speed", e, f, paper) for e in settings["exposures"] for f in settings["frequencies"]]
    cases += [("diameter", shortest, fixed, d) for d in settings["diameters"]]
    rows: list[dict[str, Any]] = []
    for part, exposure, frequency, diameter in cases:
        case = {"part": part, "exposure": float(exposure), "frequency": float(frequency), "diameter": float(diameter)}
        errors = image_errors(imaging, line_time, exposure, frequency, diameter, settings["starting_angles"])
        rows += [{**case, "model": name, "distance": distance} for name, distance in errors.items()]
    return pd.DataFrame(rows + identification_errors(settings, shared))


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Distances at 5 Hz and on the fastest circle, and the bias at the longest period with the slowest readout."""
    speed, sizes, runs = (table[table["part"] == part] for part in ("speed", "diameter", "identification"))
    fastest = float(speed["frequency"].max())
    result: dict[str, tuple[float, str]] = {"fastest": (fastest, "Hz")}
    for exposure, length in ((speed["exposure"].max(), "long"), (speed["exposure"].min(), "short")):
        for model, name in zip(MODELS, ("middle_row", "measurement_row", "begin_and_end"), strict=True):
            chosen = speed[(speed["exposure"] == exposure) & (speed["model"] == model)]
            distance = chosen.set_index("frequency")["distance"]
            result[f"{name}_{length}_exposure_at_5"] = (float(distance.get(5.0, np.nan)), "px")
            result[f"{name}_{length}_exposure_fastest"] = (float(distance[fastest]), "px")
    sizes = sizes[sizes["model"] == MODELS[-1]]
    diameter, distance = np.log(sizes[["diameter", "distance"]].to_numpy(dtype=float)).T
    result["power_of_diameter"] = (float(np.polyfit(diameter, distance, 1)[0]), "")
    slowest = runs[(runs["readout"] == runs["readout"].max()) & (runs["period"] == runs["period"].max())]
    result["longest_period"] = (float(runs["period"].max()), "s")
    result["slowest_readout"] = (float(runs["readout"].max()), "periods")
    for motion, where in zip(MOTIONS, ("along", "fixed"), strict=True):
        for declared, how in zip(DECLARED, ("global", "mean_latency"), strict=True):
            run = slowest[(slowest["motion"] == motion) & (slowest["declared"] == declared)].iloc[0]
            for parameter in PARAMETERS:
                result[f"{where}_{how}_{parameter}"] = (float(run[f"error_{parameter}"]), "%")
            result[f"{where}_{how}_residual"] = (float(run["residual"]), "%")
    none = runs.loc[runs["readout"] == 0.0, [f"error_{parameter}" for parameter in PARAMETERS]]
    result["largest_error_global_shutter"] = (float(none.abs().max().max()), "%")
    result["not_converged"] = (float((~runs["converged"].astype(bool)).sum()), "runs")
    return result


def conclusion(value: Mapping[str, float]) -> str:
    """The answer in words that follow the numbers."""

    def three(case: str) -> str:
        return ", ".join(f"{value[f'{case}_{p}']:+.1f}" for p in PARAMETERS) + " %"

    def largest(case: str) -> float:
        return max(abs(value[f"{case}_{p}"]) for p in PARAMETERS)

    undeclared, left = largest("along_global"), largest("along_mean_latency")
    verdict = (
        f"declaring the latency of the marker's mean row takes away most of it ({three('along_mean_latency')})"
        if left < 0.3 * undeclared
        else f"declaring the latency of the marker's mean row does not take it away ({three('along_mean_latency')})"
    )
    first = (
        f"A rolling shutter declared global biases b0, a1, a0 by {three('along_global')} (readout of the rows "
        f"{value['slowest_readout']:g} T, T = {value['longest_period']:g} s, marker along the rows); {verdict}, "
        f"and the dependence on position stays in the residual ({value['along_mean_latency_residual']:.1f} % of the "
        "output)."
    )
    row, ends = value["measurement_row_long_exposure_at_5"], value["begin_and_end_long_exposure_at_5"]
    second = (
        f"In rendered images, circle at 5 Hz, “the marker's row decides the time” holds to {row:.2f} px if the row is "
        f"that of the measurement, and to {ends:.2f} px if the exposure begins and ends in the row where the marker "
        "then is."
    )
    return f"{first} {second}"
