"""What an undeclared latency of the camera does to the estimate, and a first-order formula for it.

With a latency ℓ the camera sees y(t − ℓ) ≈ y − ℓ ẏ. A model without latency takes up the part of −ℓ ẏ that changes of
its coefficients can imitate: to first order the bias is the projection −ℓ (JᵀJ)⁻¹ Jᵀ ẏ, with J the sensitivities of the
sampled output to the coefficients. For a white input and a second-order plant the projection has a closed form, and all
three relative biases are the same: −a1 ℓ = −2ξω0 ℓ. (In the inner product of white inputs s/A is orthogonal to 1/A and
to s/A²; with <s/A, 1/A²> = −1/(4 a1² a0) and the Gram matrix of 1/A, s/A², 1/A² the normal equations give it.)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import (
    NO_BIAS,
    by_parameter,
    excitation_signal,
    percent_errors,
    whole_experiment,
)
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.identification.estimate import estimate
from camid.identification.predictor import Predictor
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS
from camid.paper.datasets import believed_plant

Array = NDArray[np.float64]


def first_order_bias(plant: TransferFunction, signal: Array, acquisition: Acquisition) -> Array:
    """Relative bias of the coefficients per second of undeclared latency, to first order.

    Parameters
    ----------
    plant : TransferFunction
        True plant, numerator of degree zero, monic.
    signal : ndarray, shape (N,)
        Input samples.
    acquisition : Acquisition
        As declared.

    Returns
    -------
    ndarray, shape (1 + n,)
        [δb0/b0, δa_1/a_1, …, δa_n/a_n] in 1/s.
    """
    structure = Structure.of_order(plant.order, 0)
    velocity = sample(TransferFunction((*plant.numerator, 0.0), plant.denominator), signal, acquisition)
    predictor = Predictor.around(
        structure, [whole_experiment(signal, np.zeros(len(signal)), acquisition)], np.asarray(plant.denominator)
    )
    coefficients = np.array([*plant.numerator, *plant.denominator[1:]])
    sensitivities = predictor.linearise(predictor.from_physical(coefficients))[1]
    change: Array = np.asarray(np.linalg.lstsq(sensitivities, -velocity, rcond=None)[0], dtype=np.float64)
    return predictor.to_physical(change) / coefficients


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify the paper's plant seen by a camera with a latency that is declared, or declared zero; no noise.

    Parameters
    ----------
    settings : mapping
        ``periods`` in s, ``latencies`` in periods.
    shared : mapping
        Sections ``plant`` and ``excitation``.

    Returns
    -------
    DataFrame
        One row per fit: ``period`` (s), ``latency`` (periods), ``declared`` (whether the latency is), ``converged``,
        ``error_<p>`` in percent; ``first_order_<p>`` in percent (the projection, for this excitation) and
        ``white_input`` in percent (−2ξω0 ℓ), both of an undeclared latency.
    """
    plant = believed_plant(shared["plant"])
    signal = excitation_signal(shared["excitation"])
    rate = -100.0 * plant.monic.denominator[1]
    rows: list[dict[str, Any]] = []
    for period in settings["periods"]:
        slope = 100.0 * first_order_bias(plant, signal, Acquisition(period))
        for share in settings["latencies"]:
            latency = share * period
            true = Acquisition(period, latency=latency)
            output = sample(plant, signal, true)
            for declared in (True, False):
                experiment = whole_experiment(signal, output, true if declared else Acquisition(period))
                result = estimate(Structure.of_order(2, 0), [experiment], nominal=plant)
                rows.append(
                    {
                        "period": float(period),
                        "latency": float(share),
                        "declared": declared,
                        "converged": result.converged,
                        **by_parameter("error", percent_errors(result.plant, plant)),
                        **by_parameter("first_order", slope * latency),
                        "white_input": rate * latency,
                    }
                )
    return pd.DataFrame(rows)


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Bias per millisecond of undeclared latency, how far the formula carries, and what is left when it is declared.

    ``<p>_per_millisecond_at_<T>`` is measured at the smallest latency; ``first_order_off`` is the largest difference
    there from the projection, as a share of it, at the shortest period; ``formula_until_at_<T>`` is the largest latency
    in seconds up to which −2ξω0 ℓ gives the error of a0 within a tenth, ``tried_until_at_<T>`` the largest tried.
    """
    errors = [f"error_{p}" for p in PARAMETERS]
    declared, undeclared = table[table["declared"]], table[~table["declared"] & (table["latency"] > 0.0)]
    found: dict[str, tuple[float, str]] = {
        "largest_declared": (float(declared[errors].abs().max().max()), "%"),
        "not_converged_declared": (float((~declared["converged"]).sum()), "fits"),
    }
    for period, rows in undeclared.groupby("period"):
        ordered = rows.sort_values("latency").reset_index(drop=True)
        seconds = ordered["latency"] * float(str(period))
        first = ordered.iloc[0]
        for p in PARAMETERS:
            found[f"{p}_per_millisecond_at_{period:g}"] = (float(first[f"error_{p}"] / (1e3 * seconds[0])), "%/ms")
        holds = ((ordered["error_a0"] / ordered["white_input"] - 1.0).abs() <= 0.1).cummin()
        found[f"formula_until_at_{period:g}"] = (float(seconds[holds].max()) if holds.any() else 0.0, "s")
        found[f"tried_until_at_{period:g}"] = (float(seconds.max()), "s")
        if period == undeclared["period"].min():
            share = max(abs(float(first[f"error_{p}"] / first[f"first_order_{p}"]) - 1.0) for p in PARAMETERS)
            found["first_order_off"] = (share, "")
            found["formula_per_millisecond"] = (float(first["white_input"] / (1e3 * seconds[0])), "%/ms")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    periods = sorted(float(k.rsplit("_", 1)[1]) for k in value if k.startswith("a0_per_millisecond_at_"))
    formula = value["formula_per_millisecond"]

    def listed(parameter: str) -> str:
        return ", ".join(f"{value[f'{parameter}_per_millisecond_at_{p:g}']:+.2f}" for p in periods)

    worst = max(abs(value[f"a0_per_millisecond_at_{p:g}"] / formula - 1.0) for p in periods)
    rule = (
        f"follow the first-order rule −2ξω0 for white inputs ({formula:+.2f} % a millisecond)"
        if worst < 0.1
        else f"do not follow the first-order rule −2ξω0 for white inputs ({formula:+.2f} % a millisecond)"
    )
    left = value["largest_declared"]
    cure = "a declared latency costs nothing" if left < NO_BIAS else f"declared, it still costs up to {left:.2g} %"
    reach = ", ".join(
        f"{1e3 * value[f'formula_until_at_{p:g}']:g}"
        + (" (all tried)" if value[f"formula_until_at_{p:g}"] == value[f"tried_until_at_{p:g}"] else "")
        for p in periods
    )
    return (
        f"Each millisecond of undeclared latency shifts a0 by {listed('a0')} % and b0 by {listed('b0')} % at T = "
        f"{', '.join(f'{1e3 * p:g}' for p in periods)} ms: the shifts of a0 {rule}, right within a tenth up to a "
        f"latency of {reach} ms; a1 ({listed('a1')} %) depends on the excitation. The period has no part in the rule, "
        f"so an undeclared frame costs the more the longer it lasts; {cure}."
    )
