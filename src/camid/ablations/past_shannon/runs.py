"""What the data still know past the Shannon limit π/T, where the paper stops, and how the alias is told apart.

A held input has corners to which the alias responds differently from the true mode, the three coefficients of the plant
leave no room to make up for it, and the camera's averaging weighs the two differently (docs/past_the_shannon_limit.md).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import excitation_signal, unit_noise, whole_experiment
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction, second_order
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.estimate import Estimate, estimate
from camid.identification.records import Records
from camid.identification.starts import output_errors_of
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, parameter_vector
from camid.paper.datasets import believed_plant, noise_level

Array = NDArray[np.float64]

STREAM = 32
WRONG = 0.05  # relative error of the frequency beyond which it is another mode
CONFIDENT = 3.0  # standard deviations
NORMAL_95 = 1.959964
NORMAL_MEDIAN = 0.674490  # median of the absolute value of a normal variable
DAMPINGS = np.geomspace(0.01, 1.0, 25)
FREQUENCIES = np.linspace(0.1, 1.5, 281)  # of the likelihood, over the true one


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Bounds, fits and one likelihood.

    Returns
    -------
    DataFrame
        ``kind`` is ``bound`` or ``curve`` (``product`` = Tω0, ``value`` = standard deviation of ω0 in %),
        ``likelihood`` (``frequency`` over the true one, ``value`` = deviance above the best) or ``fit``: ``product``,
        ``nominal`` (whether a model was given), ``seed``, ``error_<p>`` and ``deviation_<p>`` (stated standard
        deviation, infinite where undetermined) in units of the bound, ``frequency``, ``rivals``, ``true_listed``,
        ``confidently_wrong``.
    """
    plant = believed_plant(shared["plant"])
    signal = excitation_signal(shared["excitation"])
    ratio = settings["signal_to_noise_ratio"]
    rows = [
        {"kind": "bound", "product": product, "value": _frequency_bound(plant, signal, product, ratio)}
        for product in settings["bounds"]
    ]
    curve = settings["curve"]
    rows += [
        {"kind": "curve", "product": product, "value": _frequency_bound(plant, signal, float(product), ratio)}
        for product in np.linspace(curve["start"], curve["stop"], curve["points"])
    ]
    rows += _likelihood(plant, signal, settings, shared)
    for number, product in enumerate(settings["products"]):
        rows += _fits(plant, signal, number, product, settings, shared)
    return pd.DataFrame(rows)


def _acquisition(plant: TransferFunction, product: float) -> Acquisition:
    return Acquisition(product / float(np.sqrt(plant.denominator[-1])))


def _frequency_bound(plant: TransferFunction, signal: Array, product: float, ratio: float) -> float:
    acquisition = _acquisition(plant, product)
    level = noise_level(sample(plant, signal, acquisition), ratio, "power")
    bound = cramer_rao_bound(plant, signal, acquisition, level**2)
    return 50.0 * float(np.sqrt(bound[-1, -1])) / plant.denominator[-1]  # ω0² has twice the relative error of ω0


def _likelihood(
    plant: TransferFunction, signal: Array, settings: Mapping[str, Any], shared: Mapping[str, Any]
) -> Iterator[dict[str, Any]]:
    """Deviance against frequency, gain and damping fitted at each."""
    acquisition = _acquisition(plant, settings["likelihood_product"])
    clean = sample(plant, signal, acquisition)
    level = noise_level(clean, settings["signal_to_noise_ratio"], "power")
    output = clean + level * unit_noise(len(clean), shared["seed"], STREAM, 0)
    records = Records.of([whole_experiment(signal, output, acquisition)])
    omega = float(np.sqrt(plant.denominator[-1]))
    costs = np.array(
        [
            min(
                candidate.cost
                for candidate in output_errors_of(
                    Structure.of_order(2, 0),
                    records,
                    [np.array([1.0, 2.0 * d * f * omega, (f * omega) ** 2]) for d in DAMPINGS],
                )
            )
            for f in FREQUENCIES
        ]
    )
    deviances = len(output) * np.log(costs / costs.min())
    for frequency, deviance in zip(FREQUENCIES, deviances, strict=True):
        yield {
            "kind": "likelihood",
            "product": settings["likelihood_product"],
            "frequency": frequency,
            "value": deviance,
        }


def _fits(
    plant: TransferFunction,
    signal: Array,
    number: int,
    product: float,
    settings: Mapping[str, Any],
    shared: Mapping[str, Any],
) -> Iterator[dict[str, Any]]:
    acquisition = _acquisition(plant, product)
    clean = sample(plant, signal, acquisition)
    level = noise_level(clean, settings["signal_to_noise_ratio"], "power")
    bound = np.sqrt(np.diag(cramer_rao_bound(plant, signal, acquisition, level**2)))
    belief = shared["plant"]
    for nominal, seeds in ((True, settings["seeds"]), (False, settings["seeds_without_nominal"])):
        for s in range(seeds):
            generator = np.random.default_rng(np.random.SeedSequence(shared["seed"], spawn_key=(STREAM, number + 1, s)))
            output = clean + level * generator.standard_normal(len(clean))
            # Drawn after the noise, so that both cases see the same.
            off = 1.0 + settings["nominal_error"] * generator.uniform(-1.0, 1.0, 3)
            model = second_order(
                belief["static_gain"] * off[0], belief["natural_frequency"] * off[1], belief["damping"] * off[2]
            )
            experiment = whole_experiment(signal, output, acquisition)
            result = estimate(Structure.of_order(2, 0), [experiment], nominal=model if nominal else None)
            yield {"kind": "fit", "product": product, "nominal": nominal, "seed": s, **_judged(result, plant, bound)}


def _judged(result: Estimate, plant: TransferFunction, bound: Array) -> dict[str, Any]:
    truth = parameter_vector(plant.numerator, plant.denominator)
    error = parameter_vector(result.plant.numerator, result.plant.denominator) - truth
    omega = np.sqrt(truth[-1])
    frequency = float(np.sqrt(result.plant.denominator[-1]))
    deviation = result.standard_deviations[-1] / (2.0 * frequency) if frequency > 0.0 else np.inf
    listed = any(abs(r.natural_frequencies[-1] / omega - 1.0) <= WRONG for r in result.rivals)
    wrong = abs(frequency / omega - 1.0) > WRONG
    confident = bool(result.converged and abs(frequency - omega) > CONFIDENT * deviation)
    return {
        **{f"error_{p}": error[i] / bound[i] for i, p in enumerate(PARAMETERS)},
        **{f"deviation_{p}": result.standard_deviations[i] / bound[i] for i, p in enumerate(PARAMETERS)},
        "frequency": frequency / omega,
        "rivals": len(result.rivals),
        "true_listed": listed,
        "converged": result.converged,
        "confidently_wrong": wrong and confident and not listed,
    }


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Bounds, errors over bounds, shares of flagged and of confidently wrong fits."""
    found: dict[str, tuple[float, str]] = {}
    for row in table[table["kind"] == "bound"].to_dict("records"):
        found[f"bound_frequency_at_{row['product']:.3g}"] = (row["value"], "%")
    curve = table[table["kind"] == "likelihood"]
    product = float(curve["product"].iloc[0])
    alias = 2.0 * np.pi / product - 1.0
    near = curve[(curve["frequency"] / alias - 1.0).abs() < 0.1]
    found["likelihood_product"] = (product, "")
    found["deviance_of_alias"] = (float(near["value"].min()), "")
    fits = table[table["kind"] == "fit"]
    for (at, nominal), group in fits.groupby(["product", "nominal"]):
        name = f"{'nominal' if nominal else 'nothing'}_at_{at:g}"
        errors = group[[f"error_{p}" for p in PARAMETERS]].abs().to_numpy()
        deviations = group[[f"deviation_{p}" for p in PARAMETERS]].to_numpy()
        # A fit whose coefficients are said to be undetermined states no number, hence no error.
        stated = np.all(np.isfinite(deviations), axis=1)
        found[f"{name}_seeds"] = (len(group), "")
        found[f"{name}_ratio"] = (float(np.sqrt(np.mean(errors**2, axis=0)).max()), "of the bound")
        found[f"{name}_median"] = (float(np.median(errors, axis=0).max()) / NORMAL_MEDIAN, "of the bound's")
        found[f"{name}_undetermined"] = (100.0 * float(np.mean(~stated)), "%")
        # Damping far from the truth (three bounds), a stated deviation that does not admit it, and no rival named.
        far = (errors[:, 1] > 3.0) & (errors[:, 1] > CONFIDENT * deviations[:, 1]) & (group["rivals"] == 0).to_numpy()
        found[f"{name}_wrong_damping_not_flagged"] = (100.0 * float(np.mean(far)), "%")
        found[f"{name}_coverage"] = (100.0 * float(np.mean(errors <= NORMAL_95 * deviations, axis=0).min()), "%")
        wrong = (group["frequency"] - 1.0).abs() > WRONG
        found[f"{name}_wrong_frequency"] = (100.0 * float(wrong.mean()), "%")
        found[f"{name}_with_rivals"] = (100.0 * float((group["rivals"] > 0).mean()), "%")
        found[f"{name}_confidently_wrong"] = (100.0 * float(group["confidently_wrong"].astype(bool).mean()), "%")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """In words."""
    products = sorted(float(k.removeprefix("nominal_at_").removesuffix("_ratio")) for k in value if _is_ratio(k))
    good = [p for p in products if value[f"nominal_at_{p:g}_ratio"] <= 1.1 + _scatter(value[f"nominal_at_{p:g}_seeds"])]
    parts = [
        f"At Tω0 = {value['likelihood_product']:g} the alias lies {value['deviance_of_alias']:.0f} in deviance above "
        "the true mode"
    ]
    if good:
        largest = max(value[f"nominal_at_{p:g}_ratio"] for p in good)
        parts.append(
            "With a nominal model the errors stay on the Cramér–Rao bound at "
            f"Tω0 = {', '.join(f'{p:g}' for p in good)} (ratio at most {largest:.2f})"
        )
    for p in products:
        if p not in good:
            median, unknown = value[f"nominal_at_{p:g}_median"], value[f"nominal_at_{p:g}_undetermined"]
            parts.append(
                f"At {p:g} the median error is {median:.2f} times its Gaussian value at the bound, and {unknown:.0f} % "
                "of the fits are said to be undetermined"
            )
    worst = max(value[f"nothing_at_{p:g}_confidently_wrong"] for p in products)
    share = "no" if worst == 0.0 else f"up to {worst:.1f} % of the"
    parts.append(
        f"Without any model {share} fits state a wrong frequency with a small standard deviation and leave the true "
        "one unnamed"
    )
    return ". ".join(parts) + "."


def _is_ratio(key: str) -> bool:
    return key.startswith("nominal_at_") and key.endswith("_ratio")


def _scatter(seeds: float) -> float:
    """Three standard errors of a ratio over that many seeds."""
    return 3.0 / float(np.sqrt(2.0 * seeds))
