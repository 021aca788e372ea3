"""What a wrong declaration of hold or sensor costs, and when the test of the residual warns of it.

Every run starts where the recording without noise leads under its declaration, and iterates to the optimum nearby; the
bias is counted in the standard deviations that the tool states, which know of noise only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.ablations.identification_runs import excitation_signal, whole_experiment
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.identification.accuracy import cramer_rao_bound
from camid.identification.declaration_search import alternative_declarations, refitted
from camid.identification.declarations import explanations
from camid.identification.estimate import estimate
from camid.identification.experiment import Experiment
from camid.identification.residual_analysis import ALARM, analyse_residual
from camid.identification.structure import Structure
from camid.paper.cases import PARAMETERS, parameter_vector
from camid.paper.datasets import believed_plant, noise_level

Array = NDArray[np.float64]

# A bias of this many stated standard deviations deceives; a test that warns so often (percent) is relied upon.
DECEIVING = 2.0
RELIABLE = 95.0


def compute(settings: Mapping[str, Any], shared: Mapping[str, Any]) -> pd.DataFrame:
    """Identify the paper's plant from noisy recordings under right and wrong declarations.

    Parameters
    ----------
    settings : mapping
        ``periods`` in s; ``decibels`` (ratio of powers); ``seeds`` at each of both; ``named``: the ``decibels`` at
        which the first ``seeds`` try other declarations; ``cases``: name to ``recorded`` (hold of the rig, whose camera
        exposes for the whole period), ``hold``, ``sensor`` and ``exposure`` (in periods) as declared.
    shared : mapping
        Sections ``plant``, ``excitation`` and ``seed``.

    Returns
    -------
    DataFrame
        One row per run: ``case``, ``right`` (whether the declaration is), ``period``, ``decibel``, ``seed``,
        ``standardised_<p>`` (error over stated standard deviation), ``independence_p``, ``alarm``, ``named`` (1 if the
        right declaration is among the explanations, 0 if not, NaN where none were sought), ``names`` (how many), and,
        the same for all runs of a case at a period and a ratio, ``bias`` (largest mean standardised error of a
        coefficient) and ``alarms`` (percent).
    """
    plant = believed_plant(shared["plant"])
    signal = excitation_signal(shared["excitation"])
    named = settings["named"]
    rows: list[dict[str, Any]] = []
    for i, period in enumerate(settings["periods"]):
        for j, (name, case) in enumerate(settings["cases"].items()):
            true = Acquisition(period, case["recorded"])
            declared = Acquisition(period, case["hold"], case["sensor"], case["exposure"] * period)
            clean = sample(plant, signal, true)
            start = estimate(Structure.of_order(2, 0), [whole_experiment(signal, clean, declared)]).plant
            unit = np.sqrt(np.diag(cramer_rao_bound(start, signal, declared, 1.0)))
            for k, decibel in enumerate(settings["decibels"]):
                level = noise_level(clean, 10.0 ** (decibel / 10.0), "power")
                for seed in range(settings["seeds"]):
                    stream = np.random.SeedSequence(shared["seed"], spawn_key=(i, j, k, seed))
                    output = clean + level * np.random.default_rng(stream).standard_normal(len(clean))
                    experiment = whole_experiment(signal, output, declared)
                    rows.append(
                        {
                            "case": name,
                            "right": declared == true,
                            "period": float(period),
                            "decibel": float(decibel),
                            "seed": seed,
                            **_run(
                                experiment,
                                start,
                                plant,
                                unit,
                                true,
                                decibel in named["decibels"] and seed < named["seeds"],
                            ),
                        }
                    )
    table = pd.DataFrame(rows)
    groups = table.groupby(["case", "period", "decibel"])
    means = groups[[f"standardised_{p}" for p in PARAMETERS]].transform("mean")
    return table.assign(bias=means.abs().max(axis=1), alarms=100.0 * groups["alarm"].transform("mean"))


def _run(
    experiment: Experiment,
    start: TransferFunction,
    truth: TransferFunction,
    unit: Array,
    true: Acquisition,
    names: bool,
) -> dict[str, Any]:
    """Standardised errors, test and explanations of one recording; ``unit``: standard deviations for unit noise."""
    structure = Structure.of_order(2, 0)
    cost, plant = refitted(structure, start, [experiment])
    analysis = analyse_residual(structure, plant, [experiment])
    p = 1.0 if analysis is None or analysis.independence_p is None else analysis.independence_p
    freedom = len(experiment.output) - len(PARAMETERS)
    found, expected = (parameter_vector(x.numerator, x.denominator) for x in (plant, truth.monic))
    standardised = (found - expected) / (unit * np.sqrt(cost / freedom))
    row: dict[str, Any] = {f"standardised_{n}": float(v) for n, v in zip(PARAMETERS, standardised, strict=True)}
    row |= {"independence_p": p, "alarm": p < ALARM, "named": np.nan, "names": np.nan}
    if names and row["alarm"]:
        named = explanations(alternative_declarations(structure, plant, [experiment]))
        row |= {"named": float(any(a.acquisition == true for a in named)), "names": float(len(named))}
    return row


def quantities(table: pd.DataFrame) -> dict[str, tuple[float, str]]:
    """Bias, power, false alarms and names.

    ``warns_from_at_<dB>`` is the shortest period from which on every wrong declaration is warned of in 95 % of the
    recordings (infinite if there is none); ``bias_unwarned_at_<dB>`` the largest bias of a wrong declaration that is
    warned of in fewer, ``fewest_alarms_at_<dB>`` the share of warnings of the one hardest to see, and
    ``bias_there_at_<dB>`` its bias.
    """
    wrong, right = table[~table["right"]], table[table["right"]]
    sought = wrong["named"].dropna()
    found: dict[str, tuple[float, str]] = {
        "largest_bias": (float(wrong["bias"].max()), "σ"),
        "smallest_bias": (float(wrong["bias"].min()), "σ"),
        "largest_bias_right": (float(right["bias"].max()), "σ"),
        "false_alarms": (100.0 * float(right["alarm"].mean()), "%"),
        "runs_right": (float(len(right)), ""),
        "right_name_given": (100.0 * float(sought.mean()) if len(sought) else float("nan"), "%"),
        "names_given": (float(wrong["names"].mean()), ""),
    }
    for decibel, rows in wrong.groupby("decibel"):
        least = rows.groupby("period")["alarms"].min().sort_index(ascending=False)
        reliable = least[(least >= RELIABLE).cummin()]
        found[f"warns_from_at_{decibel:g}"] = (float(reliable.index.min()) if len(reliable) else float("inf"), "s")
        rest = rows[rows["alarms"] < RELIABLE]
        found[f"bias_unwarned_at_{decibel:g}"] = (float(rest["bias"].max()) if len(rest) else 0.0, "σ")
        found[f"fewest_alarms_at_{decibel:g}"] = (float(rows["alarms"].min()), "%")
        found[f"bias_there_at_{decibel:g}"] = (float(rows.sort_values("alarms")["bias"].iloc[0]), "σ")
    return found


def conclusion(value: Mapping[str, float]) -> str:
    """The answer for an engineer."""
    ratios = sorted(float(k.rsplit("_", 1)[1]) for k in value if k.startswith("warns_from_at_"))
    parts, late = [], []
    for ratio in ratios:
        start, missed = value[f"warns_from_at_{ratio:g}"], value[f"bias_unwarned_at_{ratio:g}"]
        reach = "at no period tried" if np.isinf(start) else f"from T = {1e3 * start:g} ms on"
        blind = ""
        if missed > DECEIVING:
            late.append(f"{ratio:g}")
            blind = (
                f" (before, biases of up to {missed:.1f} can pass unnoticed, and one of "
                f"{value[f'bias_there_at_{ratio:g}']:.1f} is warned of in "
                f"{value[f'fewest_alarms_at_{ratio:g}']:.0f} % of the recordings only)"
            )
        parts.append(f"at {ratio:g} dB {reach}{blind}")
    verdict = (
        f"so at {', '.join(late)} dB with short periods it cannot be relied upon to warn before the bias exceeds "
        f"{DECEIVING:g} standard deviations"
        if late
        else f"so it warns before the bias exceeds {DECEIVING:g} standard deviations"
    )
    names = (
        "none was asked for another declaration"
        if np.isnan(value["right_name_given"])
        else f"the right declaration was among those named ({value['names_given']:.1f} on average) in "
        f"{value['right_name_given']:.0f} % of the warnings asked"
    )
    return (
        f"A wrong hold, exposure or sensor shifts a coefficient by {value['smallest_bias']:.1f} to "
        f"{value['largest_bias']:.0f} of its stated standard deviations. The residual test warns of all of them in "
        f"{RELIABLE:g} % of the recordings {', '.join(parts)}: {verdict}. Right declarations were warned of in "
        f"{value['false_alarms']:.2g} %, and {names}."
    )
