"""How many poles: what the selections choose, and what too few and too many poles cost.

The models have n poles and no zeros, the family of the paper's (15) and (25). The bare criteria are those of Akaike
(1974) and Schwarz (1978), N ln σ² + 2k and N ln σ² + k ln N, with σ² the mean squared residual and k = n + 1
coefficients. :func:`camid.identification.order_selection.select_order` chooses zeros, too, and tests the residual.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import excitation_signal, unit_noise, whole_experiment
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.estimate import Estimate, estimate
from camid.identification.order_selection import select_order
from camid.identification.structure import Structure
from camid.paper.datasets import believed_plant, noise_level

Array = NDArray[np.float64]

TRUE_POLES = {"one mode": 2, "two modes": 4}
CRITERIA = ("akaike", "bayes")
STREAM = 8
# A relative standard deviation beyond this means that nothing is known but the order of magnitude, if that.
UNKNOWN = 10.0


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify plants of one and two modes from their camera data in white noise with models of several orders.

    Parameters
    ----------
    settings : mapping
        ``period`` in s, ``natural_frequency`` (rad/s) and ``damping`` of the second mode, ``orders`` (poles),
        ``signal_to_noise_ratio`` (of powers), ``noise_samples`` for every plant and order, ``selected_samples`` (how
        many of them ``select_order`` is given) and ``largest_selected`` (its largest number of poles).
    shared : mapping
        Sections ``plant``, ``excitation`` and ``seed``.

    Returns
    -------
    DataFrame
        One row per fit: ``plant`` (one mode | two modes), ``poles``, ``sample``, ``converged``, ``akaike``, ``bayes``,
        ``nrmse_fresh`` (simulated against a second noise sample) and ``nrmse_true`` (against the output without noise),
        both over the std of the data, ``largest_relative_deviation`` (standard deviation over coefficient, at most 10),
        ``frequency_error`` and ``damping_error`` of the first mode in percent; the same in all rows of a record:
        ``selected_poles`` and ``selected_zeros`` by ``select_order``, NaN where it was not called.
    """
    first = believed_plant(shared["plant"])
    mode = second_order(1.0, settings["natural_frequency"], settings["damping"])
    signal = excitation_signal(shared["excitation"])
    acquisition = Acquisition(settings["period"])
    rows: list[dict[str, Any]] = []
    for number, (name, plant) in enumerate({"one mode": first, "two modes": first * mode}.items()):
        clean = sample(plant, signal, acquisition)
        deviation = noise_level(clean, settings["signal_to_noise_ratio"], "power")
        for s in range(settings["noise_samples"]):
            record, fresh = (
                clean + deviation * unit_noise(len(clean), shared["seed"], STREAM, number, s, part) for part in (0, 1)
            )
            experiment = whole_experiment(signal, record, acquisition)
            selected = {"selected_poles": float("nan"), "selected_zeros": float("nan")}
            if s < settings["selected_samples"]:
                selection = select_order([experiment], settings["largest_selected"])
                selected = {"selected_poles": float(selection.poles), "selected_zeros": float(selection.zeros)}
            for poles in settings["orders"]:
                found = estimate(Structure.of_order(poles, 0), [experiment])
                simulated = sample(found.plant, signal, acquisition)
                rows.append(
                    {
                        "plant": name,
                        "poles": int(poles),
                        "sample": s,
                        "converged": found.converged,
                        **_criteria(found),
                        "nrmse_fresh": float(np.sqrt(np.mean((fresh - simulated) ** 2)) / np.std(fresh)),
                        "nrmse_true": float(np.sqrt(np.mean((clean - simulated) ** 2)) / np.std(clean)),
                        "largest_relative_deviation": _largest_relative_deviation(found),
                        **_first_mode(found.plant, first),
                        **selected,
                    }
                )
    return pd.DataFrame(rows)


def _criteria(found: Estimate) -> dict[str, float]:
    residual = np.concatenate(found.residuals)
    count, parameters = len(residual), int(found.free.sum())
    likelihood = count * np.log(np.mean(residual**2))
    return {
        "akaike": float(likelihood + 2.0 * parameters),
        "bayes": float(likelihood + parameters * np.log(count)),
    }


def _largest_relative_deviation(found: Estimate) -> float:
    coefficients = np.abs(np.array([found.plant.numerator[-1], *found.plant.denominator[1:]]))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = found.standard_deviations / coefficients
    return float(np.min([np.max(np.nan_to_num(relative, nan=np.inf, posinf=np.inf)), UNKNOWN]))


def _first_mode(found: TransferFunction, truth: TransferFunction) -> dict[str, float]:
    """Errors in percent of the pole pair that lies nearest to the true first mode; NaN without a pair."""
    true = truth.poles()[np.argmax(truth.poles().imag)]
    pairs = found.poles()[found.poles().imag > 0.0]
    if not pairs.size:
        return {"frequency_error": float("nan"), "damping_error": float("nan")}
    pole = pairs[np.argmin(np.abs(pairs - true))]
    damping = (-pole.real / abs(pole)) / (-true.real / abs(true))
    return {"frequency_error": 100.0 * (abs(pole) / abs(true) - 1.0), "damping_error": 100.0 * (damping - 1.0)}


def by_order(table: pd.DataFrame) -> pd.DataFrame:
    """One row per plant and number of poles: means over the noise samples, and how often each criterion chooses it.

    ``excess_<criterion>`` is the mean of the criterion less its smallest value among the orders of the same record;
    ``chosen_<criterion>`` the share of records; ``unknown`` the share in which the iteration does not converge or a
    coefficient's standard deviation exceeds the coefficient.
    """
    table = table.copy()
    for criterion in CRITERIA:
        smallest = table.groupby(["plant", "sample"])[criterion].transform("min")
        table[f"excess_{criterion}"] = table[criterion] - smallest
        table[f"chosen_{criterion}"] = table[criterion] == smallest
    table["unknown"] = (table["largest_relative_deviation"] > 1.0) | ~table["converged"]
    groups = table.groupby(["plant", "poles"])
    result = pd.DataFrame({"runs": groups.size(), "failed": groups["converged"].agg(lambda c: int((~c).sum()))})
    names = [f"{kind}_{criterion}" for kind in ("excess", "chosen") for criterion in CRITERIA]
    for name in (*names, "unknown", "nrmse_fresh", "nrmse_true"):
        result[name] = groups[name].mean()
    result["median_relative_deviation"] = groups["largest_relative_deviation"].median()
    for name in ("frequency_error", "damping_error"):
        result[f"rms_{name}"] = groups[name].agg(lambda e: np.sqrt(np.mean(e**2)))
    return result.reset_index()


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """How often the true order is chosen, and what the lowest, the true and the highest order cost.

    ``selected_2``: % of the ``selected_of_2`` records in which ``select_order`` finds the true poles and no zero.
    Names end with the number of the plant's true poles: ``chosen_bayes_4`` (% of the records in which the criterion
    chooses the true order), ``nrmse_fresh_lowest_4``, ``nrmse_true_highest_4``, ``unknown_true_4`` (% of the records
    without convergence or with a coefficient below its standard deviation), ``frequency_error_lowest_4`` (rms, %),
    and the like.
    """
    orders = by_order(table)
    found: dict[str, tuple[float, str]] = {}
    for plant, rows in orders.groupby("plant"):
        true = TRUE_POLES[str(plant)]
        at = rows.set_index("poles")
        records = table[(table["plant"] == plant) & table["selected_poles"].notna()]
        right = (records["selected_poles"] == true) & (records["selected_zeros"] == 0)
        found[f"selected_{true}"] = (100.0 * float(right.mean()), "%")
        found[f"selected_of_{true}"] = (float(records["sample"].nunique()), "records")
        found[f"records_{true}"] = (float(rows["runs"].max()), "records")
        for criterion in CRITERIA:
            found[f"chosen_{criterion}_{true}"] = (100.0 * float(at[f"chosen_{criterion}"][true]), "%")
            below = at[f"chosen_{criterion}"][at.index < true].sum()
            found[f"too_few_{criterion}_{true}"] = (100.0 * float(below), "%")
        for name, poles in (("lowest", at.index.min()), ("true", true), ("highest", at.index.max())):
            found[f"poles_{name}_{true}"] = (float(poles), "")
            found[f"nrmse_fresh_{name}_{true}"] = (float(at["nrmse_fresh"][poles]), "")
            found[f"nrmse_true_{name}_{true}"] = (float(at["nrmse_true"][poles]), "")
            found[f"unknown_{name}_{true}"] = (100.0 * float(at["unknown"][poles]), "%")
            for error in ("frequency_error", "damping_error"):
                found[f"{error}_{name}_{true}"] = (float(at[f"rms_{error}"][poles]), "%")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    few, many = min(TRUE_POLES.values()), max(TRUE_POLES.values())

    def chosen(criterion: str) -> str:
        return f"{value[f'chosen_{criterion}_{few}']:.0f} and {value[f'chosen_{criterion}_{many}']:.0f} %"

    bayes, akaike = (min(value[f"chosen_{c}_{t}"] for t in (few, many)) for c in ("bayes", "akaike"))
    better = "more" if bayes > akaike else "no more"
    low, right, high = (100.0 * value[f"nrmse_true_{name}_{many}"] for name in ("lowest", "true", "highest"))
    over, exact = 100.0 * value[f"nrmse_true_highest_{few}"], 100.0 * value[f"nrmse_true_true_{few}"]
    dearer = "Too few poles cost more than too many" if low > high else "Too many poles cost more than too few"
    return (
        f"camid's order selection finds the true order in {value[f'selected_{few}']:.0f} and "
        f"{value[f'selected_{many}']:.0f} % of the records of one and two modes ({value[f'selected_of_{few}']:.0f} "
        f"each); Bayes's criterion alone ({chosen('bayes')} of {value[f'records_{few}']:.0f}) is {better} reliable "
        f"than Akaike's ({chosen('akaike')}). {dearer}: the simulated output of two modes is off by {low:.2g} % with "
        f"{value[f'poles_lowest_{many}']:.0f} poles, {right:.2g} % with {many} and {high:.2g} % with "
        f"{value[f'poles_highest_{many}']:.0f}; that of one mode by {exact:.2g} % with {few} and {over:.2g} % with "
        f"{value[f'poles_highest_{few}']:.0f}, where {value[f'unknown_highest_{few}']:.0f} % of the records leave a "
        "coefficient undetermined."
    )
