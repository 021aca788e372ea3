"""What a second amplitude in the excitation costs a linear model, and which nonlinear plants it gives away.

Signals of equal power: a plain pseudo-random binary sequence, the same with the second half higher, a multilevel
sequence and a multisine. Plants: the paper's, and the same with a cubic stiffness or a dead zone at its input. Behind a
dead zone of half-width d a sequence of levels ±A is one of ±(A − d): to a single-amplitude PRBS a dead zone is a
smaller gain and nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import (
    by_parameter,
    percent_bound,
    percent_errors,
    unit_noise,
    whole_experiment,
)
from camid.chain.acquisition import Acquisition
from camid.chain.excitation import multilevel, multisine, pseudo_random_binary_sequence, two_level_amplitudes
from camid.chain.plant import TransferFunction
from camid.compiled import njit
from camid.identification.estimate import Estimate, estimate
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, parameter_vector
from camid.paper.datasets import believed_plant, noise_level, with_closing_frame

Array = NDArray[np.float64]

SIGNALS = ("prbs", "two-amplitudes", "multilevel", "multisine")
STREAM = 6
# Two halves differ if chance does as much in one of a thousand cases.
SIGNIFICANT = 0.001
EXACTLY_LINEAR = 1e-6  # distortion that the integration leaves


@njit
def film(
    signal: Array, period: float, steps: int, b0: float, a1: float, a0: float, stiffness: float, half_width: float
) -> Array:
    """Camera output of ÿ + a1 ẏ + a0 y = b0 (dead zone(u) − c y³), held input, full exposure, at rest before.

    Runge–Kutta of fourth order with the integral of y as a third state, so that the camera's mean is as exact as the
    motion.

    Parameters
    ----------
    signal : ndarray, shape (N,)
        Input samples.
    period : float
        T in seconds.
    steps : int
        Integration steps in a period.
    b0, a1, a0 : float
        Coefficients of the linear plant.
    stiffness : float
        c, in units of the input over those of the output cubed.
    half_width : float
        Of the dead zone, in the units of the input.

    Returns
    -------
    ndarray, shape (N,)
    """
    output = np.zeros(len(signal))
    step = period / steps
    y, v = 0.0, 0.0
    for k in range(len(signal) - 1):
        u = signal[k]
        u = u - half_width if u > half_width else (u + half_width if u < -half_width else 0.0)
        integral = 0.0
        for _ in range(steps):
            k1y, k1v = v, b0 * (u - stiffness * y**3) - a1 * v - a0 * y
            y2, v2 = y + 0.5 * step * k1y, v + 0.5 * step * k1v
            k2y, k2v = v2, b0 * (u - stiffness * y2**3) - a1 * v2 - a0 * y2
            y3, v3 = y + 0.5 * step * k2y, v + 0.5 * step * k2v
            k3y, k3v = v3, b0 * (u - stiffness * y3**3) - a1 * v3 - a0 * y3
            y4, v4 = y + step * k3y, v + step * k3v
            k4y, k4v = v4, b0 * (u - stiffness * y4**3) - a1 * v4 - a0 * y4
            integral += step / 6.0 * (y + 2.0 * y2 + 2.0 * y3 + y4)
            y += step / 6.0 * (k1y + 2.0 * k2y + 2.0 * k3y + k4y)
            v += step / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v)
        output[k + 1] = integral / period
    return output


def signals_of_equal_power(settings: Mapping[str, Any], seed: int, period: float) -> dict[str, Array]:
    """The four excitations, two periods each, scaled to a root mean square of one, with a closing frame of zero."""
    order = int(settings["order"])
    length = 2**order - 1
    highest = int(settings["highest_frequency"] * period * length / (2.0 * np.pi))
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM, 0)))
    raw = {
        "prbs": pseudo_random_binary_sequence(order, 2),
        "two-amplitudes": two_level_amplitudes(order, 1.0, float(settings["ratio"])),
        "multilevel": multilevel(order, int(settings["levels"]), generator, 2),
        "multisine": multisine(length, range(1, highest + 1), 2),
    }
    return {name: with_closing_frame(s / np.sqrt(np.mean(s**2))) for name, s in raw.items()}


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Fit the linear model to every plant under every signal: whole record without noise, both halves with noise.

    Parameters
    ----------
    settings : mapping
        ``period`` in s, ``order`` of the sequences, ``ratio`` of the two amplitudes, ``levels``, ``highest_frequency``
        of the multisine in rad/s, ``stiffness`` and ``half_width`` (see :func:`film`; all signals have a root mean
        square of one), ``signal_to_noise_ratio`` (of powers, linear plant under the PRBS), ``noise_samples``,
        ``integration_steps`` in a period.
    shared : mapping
        Sections ``plant`` and ``seed``.

    Returns
    -------
    DataFrame
        One row per run: ``signal``, ``plant``, ``sample`` (-1: whole record, no noise), ``peak`` of the input,
        ``bound_<p>`` in percent (Cramér–Rao, linear plant); without noise ``distortion`` (residual over output, both
        rms) and ``error_<p>`` in percent; with noise ``standardised_<p>`` (difference of the halves over its standard
        deviation) and ``probability`` of a difference as large by chance (chi-square, three degrees of freedom).
    """
    plant = believed_plant(shared["plant"])
    period = float(settings["period"])
    acquisition = Acquisition(period)
    b0, a1, a0 = parameter_vector(plant.numerator, plant.denominator)
    stiffness, half_width = float(settings["stiffness"]), float(settings["half_width"])
    effects = {"linear": (0.0, 0.0), "cubic-stiffness": (stiffness, 0.0), "dead-zone": (0.0, half_width)}
    signals = signals_of_equal_power(settings, shared["seed"], period)
    linear = film(signals["prbs"], period, settings["integration_steps"], b0, a1, a0, 0.0, 0.0)
    deviation = noise_level(linear, settings["signal_to_noise_ratio"], "power")
    rows: list[dict[str, Any]] = []
    for number, (name, signal) in enumerate(signals.items()):
        bound = np.sqrt(np.diag(percent_bound(plant, signal, acquisition, deviation**2)))
        same = {"signal": name, "peak": float(np.max(np.abs(signal))), **by_parameter("bound", bound)}
        for kind, (c, d) in effects.items():
            clean = film(signal, period, settings["integration_steps"], b0, a1, a0, c, d)
            whole = estimate(Structure.of_order(2, 0), [whole_experiment(signal, clean, acquisition)], nominal=plant)
            rows.append(
                {
                    **same,
                    "plant": kind,
                    "sample": -1,
                    "distortion": float(np.std(whole.residuals[0]) / np.std(clean)),
                    **by_parameter("error", percent_errors(whole.plant, plant)),
                }
            )
            for s in range(settings["noise_samples"]):
                noise = deviation * unit_noise(len(clean), shared["seed"], STREAM, number + 1, s)
                differences = _compare_halves(signal, clean + noise, acquisition, plant)
                rows.append({**same, "plant": kind, "sample": s, **differences})
    return pd.DataFrame(rows)


def _compare_halves(
    signal: Array, output: Array, acquisition: Acquisition, nominal: TransferFunction
) -> dict[str, float]:
    """Standardised differences between the estimates of the two halves of a record, and their joint probability."""
    from scipy.special import chdtrc

    middle = (len(signal) - 1) // 2
    first = whole_experiment(signal[: middle + 1], output[: middle + 1], acquisition)
    used = np.ones(len(signal) - middle, bool)
    used[: acquisition.window()[0]] = False  # exposed while the first half's input acted
    second = Experiment(signal[middle:], output[middle:], acquisition, used, estimate_initial_state=True)
    halves: list[Estimate] = [estimate(Structure.of_order(2, 0), [half], nominal=nominal) for half in (first, second)]
    vectors = [parameter_vector(h.plant.numerator, h.plant.denominator) for h in halves]
    difference = vectors[1] - vectors[0]
    covariance = halves[0].covariance + halves[1].covariance
    squared = float(difference @ np.linalg.solve(covariance, difference))
    return {
        **by_parameter("standardised", difference / np.sqrt(np.diag(covariance))),
        "probability": float(chdtrc(len(PARAMETERS), squared)),
    }


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Price and gain of every signal.

    ``bound_<signal>``: largest bound over that of the PRBS at equal power, ``bound_<signal>_at_equal_peak`` the same at
    equal peak; ``peak_<signal>`` over the root mean square; ``distortion_<signal>_<plant>``: what the best linear model
    leaves without noise, over the output; ``detected_<signal>_<plant>``: share of noise samples in which the halves
    differ with a probability below 0.001; ``gain_error_prbs_dead-zone``: error of b0.
    """
    clean, noisy = table[table["sample"] < 0], table[table["sample"] >= 0]
    bounds = clean.drop_duplicates("signal").set_index("signal")
    found: dict[str, tuple[float, str]] = {}
    for signal in SIGNALS:
        ratio = max(float(bounds[f"bound_{p}"][signal] / bounds[f"bound_{p}"]["prbs"]) for p in PARAMETERS)
        peak = float(bounds["peak"][signal])
        found[f"bound_{signal}"] = (ratio, "")
        found[f"bound_{signal}_at_equal_peak"] = (ratio * peak / float(bounds["peak"]["prbs"]), "")
        found[f"peak_{signal}"] = (peak, "")
    for name, rows in clean.groupby(["signal", "plant"]):
        found[f"distortion_{name[0]}_{name[1]}"] = (float(rows["distortion"].iloc[0]), "")
    for name, rows in noisy.groupby(["signal", "plant"]):
        found[f"detected_{name[0]}_{name[1]}"] = (100.0 * float((rows["probability"] < SIGNIFICANT).mean()), "%")
    dead = clean[(clean["signal"] == "prbs") & (clean["plant"] == "dead-zone")]
    found["gain_error_prbs_dead-zone"] = (float(dead["error_b0"].iloc[0]), "%")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""

    def price(signal: str) -> str:
        change = 100.0 * (value[f"bound_{signal}"] - 1.0)
        return f"{abs(change):.2g} % {'larger' if change > 0.0 else 'smaller'}"

    def detected(signal: str) -> str:
        return ", ".join(f"{value[f'detected_{signal}_{p}']:.3g}" for p in ("dead-zone", "cubic-stiffness", "linear"))

    hidden = value["distortion_prbs_dead-zone"]
    gain = value["gain_error_prbs_dead-zone"]
    blind = (
        f"To a single-amplitude PRBS the dead zone is invisible (it leaves no residual and b0 is off by {gain:+.3g} %)"
        if hidden < EXACTLY_LINEAR
        else f"A single-amplitude PRBS shows the dead zone by a residual of {100 * hidden:.2g} % (b0 {gain:+.3g} %)"
    )
    return (
        f"At equal power a second half of another amplitude makes the bounds of the linear model at most "
        f"{price('two-amplitudes')} (multilevel {price('multilevel')}, low-frequency multisine {price('multisine')}; "
        f"peak {value['peak_two-amplitudes']:.2f}, {value['peak_multilevel']:.2f}, {value['peak_multisine']:.2f} times "
        f"the rms, PRBS {value['peak_prbs']:.2f}). Then the estimates of the two halves differ significantly in "
        f"{detected('two-amplitudes')} % of the runs (dead zone, cubic stiffness, linear plant), against "
        f"{detected('prbs')} % with a plain PRBS. {blind}."
    )
