"""Where each estimation method works: error in units of the Cramér–Rao bound, and gross failures, against the period.

The methods, none of which gets a starting value:

- ``plain-srivc``: SRIVC as published, from the state-variable filter that fits best;
- ``srivc``: with symmetric instruments and step control, the default;
- ``output-error``: a general optimiser on the same model, from the same starts;
- ``state-variable-filter``: least squares on filtered derivatives (LSSVF), several cut-offs, best by output error;
- ``discrete-least-squares``: section 3.1's discrete-time model (five parameters), poles by logarithm, gain at zero
  frequency;
- ``discrete-output-error``: the same conversion of the discrete-time output-error model, started by the iteration of
  Steiglitz and McBride (1965, IEEE Transactions on Automatic Control 10(4), 461–464).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import (
    by_parameter,
    excitation_signal,
    percent_bound,
    percent_errors,
    unit_noise,
    whole_experiment,
)
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.identification.discrete_time import least_squares as discrete_least_squares
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.predictor import Predictor
from camid.identification.srivc import least_squares_state_variable_filter, reflect
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS
from camid.paper.datasets import believed_plant, noise_level

Array = NDArray[np.float64]

STREAM = 7
# A run is a gross failure if it does not converge or its natural frequency is off by more than a tenth.
GROSS_FREQUENCY_ERROR = 0.1
CUT_OFFS = np.geomspace(0.02, 1.0, 8)  # of the state-variable filters, in units of π/T
STEIGLITZ_MCBRIDE_ITERATIONS = 10


def by_estimate(method: str) -> Callable[[Experiment], TransferFunction | None]:
    """A method of :func:`camid.identification.estimate.estimate`."""

    def identify(experiment: Experiment) -> TransferFunction | None:
        result = estimate(Structure.of_order(2, 0), [experiment], method=method)
        return result.plant if result.converged else None

    return identify


def by_state_variable_filter(experiment: Experiment) -> TransferFunction | None:
    """LSSVF with the cut-off whose model simulates the record best."""
    structure = Structure.of_order(2, 0)
    best: tuple[float, TransferFunction | None] = (np.inf, None)
    for cut_off in CUT_OFFS * np.pi / experiment.acquisition.period:
        predictor = Predictor(structure, [experiment], 1.0 / cut_off)
        coefficients = predictor.to_physical(least_squares_state_variable_filter(predictor, cut_off))
        denominator = reflect(np.concatenate([[1.0], coefficients[1:]]))
        plant = TransferFunction((float(coefficients[0]),), tuple(denominator))
        cost = float(np.sum((experiment.output - sample(plant, experiment.signal, experiment.acquisition)) ** 2))
        if cost < best[0]:
            best = (cost, plant)
    return best[1]


def continuous_time(numerator: Array, denominator: Array, period: float) -> TransferFunction | None:
    """b0/(s² + a1 s + a0) with the logarithms of two discrete-time poles and the gain at zero frequency.

    None where no such plant is real and stable: a pole on the negative real axis, or outside of the unit circle.
    """
    poles = np.roots(denominator)
    if np.any(np.abs(poles) >= 1.0) or np.any((np.abs(poles.imag) < 1e-12) & (poles.real <= 0.0)):
        return None
    _, a1, a0 = np.real(np.poly(np.log(poles) / period))
    gain = float(np.sum(numerator) / np.sum(denominator))
    return TransferFunction((gain * a0,), (1.0, float(a1), float(a0)))


def by_discrete_least_squares(experiment: Experiment) -> TransferFunction | None:
    """Section 3.1: one delay, orders two above and below, least squares on the difference equation."""
    model = discrete_least_squares(experiment.signal, experiment.output, 2, 2, 1)
    return continuous_time(model.numerator, model.denominator, experiment.acquisition.period)


def by_discrete_output_error(experiment: Experiment) -> TransferFunction | None:
    """The same model by output error, from the iteration of Steiglitz and McBride."""
    from scipy.optimize import least_squares
    from scipy.signal import lfilter

    signal, output = experiment.signal, experiment.output
    denominator = np.array([1.0, 0.0, 0.0])
    for _ in range(STEIGLITZ_MCBRIDE_ITERATIONS):
        filtered = [lfilter([1.0], denominator, x) for x in (signal, output)]
        model = discrete_least_squares(filtered[0], filtered[1], 2, 2, 1)
        roots = np.roots(model.denominator)
        # The filter must be stable.
        denominator = np.real(np.poly(np.where(np.abs(roots) > 1.0, 1.0 / np.conj(roots), roots)))

    def simulated(parameters: Array) -> Array:
        return np.asarray(lfilter([0.0, *parameters[:3]], [1.0, *parameters[3:]], signal))

    def residual(parameters: Array) -> Array:
        return np.asarray(np.nan_to_num(output - simulated(parameters), nan=1e9, posinf=1e9, neginf=-1e9))

    def jacobian(parameters: Array) -> Array:
        below = [1.0, *parameters[3:]]
        columns = [lfilter([0.0] * lag + [1.0], below, signal) for lag in (1, 2, 3)]
        columns += [-lfilter([0.0] * lag + [1.0], below, simulated(parameters)) for lag in (1, 2)]
        return -np.nan_to_num(np.column_stack(columns))

    with np.errstate(over="ignore", invalid="ignore"):  # a trial outside of the unit circle overflows
        solution = least_squares(residual, np.concatenate([model.numerator, denominator[1:]]), jac=jacobian)
    if not solution.success:
        return None
    return continuous_time(solution.x[:3], np.concatenate([[1.0], solution.x[3:]]), experiment.acquisition.period)


METHODS: dict[str, Callable[[Experiment], TransferFunction | None]] = {
    "plain-srivc": by_estimate("plain-srivc"),
    "srivc": by_estimate("srivc"),
    "output-error": by_estimate("output-error"),
    "state-variable-filter": by_state_variable_filter,
    "discrete-least-squares": by_discrete_least_squares,
    "discrete-output-error": by_discrete_output_error,
}


NAMES = {
    "srivc": "safeguarded SRIVC",
    "output-error": "output error",
    "plain-srivc": "plain SRIVC",
    "state-variable-filter": "LSSVF",
    "discrete-least-squares": "discrete-time least squares",
    "discrete-output-error": "discrete-time output error",
}


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify the paper's plant from its camera data in white noise by every method, without a starting value.

    Parameters
    ----------
    settings : mapping
        ``periods`` in s, ``signal_to_noise_ratio`` (of powers), ``noise_samples`` at each period.
    shared : mapping
        Sections ``plant``, ``excitation`` and ``seed``.

    Returns
    -------
    DataFrame
        One row per run: ``period`` (s), ``method``, ``sample``, ``gross`` (no convergence, no real stable plant, or a
        natural frequency off by more than a tenth), ``error_<p>`` in percent (NaN without a plant) and ``bound_<p>``
        (Cramér–Rao standard deviation) in percent.
    """
    plant = believed_plant(shared["plant"])
    signal = excitation_signal(shared["excitation"])
    rows: list[dict[str, Any]] = []
    for number, period in enumerate(settings["periods"]):
        acquisition = Acquisition(period)
        clean = sample(plant, signal, acquisition)
        deviation = noise_level(clean, settings["signal_to_noise_ratio"], "power")
        bound = np.sqrt(np.diag(percent_bound(plant, signal, acquisition, deviation**2)))
        for s in range(settings["noise_samples"]):
            noise = deviation * unit_noise(len(clean), shared["seed"], STREAM, number, s)
            experiment = whole_experiment(signal, clean + noise, acquisition)
            for method, identify in METHODS.items():
                found = identify(experiment)
                error = np.full(3, np.nan) if found is None else percent_errors(found, plant)
                frequency = np.sqrt(max(1.0 + error[2] / 100.0, 0.0)) if found is not None else np.nan
                rows.append(
                    {
                        "period": float(period),
                        "method": method,
                        "sample": s,
                        "gross": not abs(frequency - 1.0) <= GROSS_FREQUENCY_ERROR,
                        **by_parameter("error", error),
                        **by_parameter("bound", bound),
                    }
                )
    return pd.DataFrame(rows)


def by_method(table: pd.DataFrame) -> pd.DataFrame:
    """One row per method and period: ``runs``, ``gross``, and of the other runs ``ratio_<p>`` and ``bias_<p>``.

    ``ratio_<p>`` is the rms error, ``bias_<p>`` the mean error, both over the Cramér–Rao bound; NaN where fewer than
    half of the runs are left.
    """
    groups = table.groupby(["method", "period"])
    result = pd.DataFrame({"runs": groups.size(), "gross": groups["gross"].sum().astype(int)})
    good = table[~table["gross"]]
    enough = result["gross"] * 2 <= result["runs"]
    for p in PARAMETERS:
        standardised = (good[f"error_{p}"] / good[f"bound_{p}"]).groupby([good["method"], good["period"]])
        result[f"ratio_{p}"] = standardised.agg(lambda e: np.sqrt(np.mean(e**2))).where(enough)
        result[f"bias_{p}"] = standardised.mean().where(enough)
    return result.reset_index()


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Share of gross failures and largest of the three rms errors (over the bound) of every method at every period.

    ``gross_<method>_at_<T>`` and ``ratio_<method>_at_<T>``, the second of the runs that are not failures and NaN where
    they are fewer than half; ``bias_<method>_at_<T>``: largest mean error over the bound.
    """
    found: dict[str, tuple[float, str]] = {}
    for row in by_method(table).to_dict("records"):
        name = f"{row['method']}_at_{row['period']:g}"
        found[f"gross_{name}"] = (100.0 * row["gross"] / row["runs"], "%")
        found[f"ratio_{name}"] = (max(row[f"ratio_{p}"] for p in PARAMETERS), "")
        found[f"bias_{name}"] = (max(abs(row[f"bias_{p}"]) for p in PARAMETERS), "")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    prefix = "gross_srivc_at_"
    periods = sorted(float(k.removeprefix(prefix)) for k in value if k.startswith(prefix))

    def described(name: str, method: str) -> str:
        shares = {p: value[f"gross_{method}_at_{p:g}"] for p in periods}
        failing = [p for p, share in shares.items() if share > 0.0]
        at = ", ".join(f"{1e3 * p:g}" for p in failing)
        failure = (
            f"fails in up to {max(shares.values()):.0f} % of the runs at T = {at} ms" if failing else "never fails"
        )
        known = [r for p in periods if np.isfinite(r := value[f"ratio_{method}_at_{p:g}"])]
        if not known:
            return f"{name} {failure}"
        spread = sorted({f"{min(known):.2g}", f"{max(known):.2g}"}, key=float)
        return f"{name} errs by {' to '.join(spread)} times the bound and {failure}"

    parts = [described(name, method) for method, name in NAMES.items()]
    return (
        f"Without a starting value, at T from {1e3 * periods[0]:g} to {1e3 * periods[-1]:g} ms (largest rms error of "
        "b0, a1, a0 where at most half of the runs fail): " + "; ".join(parts) + "."
    )
