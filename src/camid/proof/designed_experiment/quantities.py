"""What is asked of designed experiments, as quantities that tolerances guard."""

from __future__ import annotations

import numpy as np
import pandas as pd

from camid.proof.designed_experiment.campaign import DECIDED, summary

TARGET = "designed_experiment"
# Its general laws fit as well as it does: only their additional number counts against them.
NESTED = "dry friction"


def quantities(rows: pd.DataFrame) -> pd.DataFrame:
    """The figure's numbers, over the rigs with a law of the catalogue that the first recording leaves open.

    Parameters
    ----------
    rows : DataFrame
        Of :func:`camid.proof.designed_experiment.campaign.campaign`.

    Returns
    -------
    DataFrame
        Columns ``target``, ``quantity``, ``value``, ``unit``: ``rigs``; ``decided`` (one name above 95 % and right, in
        %), the same without dry friction, of those of which the design says that it decides, and of repetitions;
        ``right`` (the likeliest name, in %); ``wrong`` (a wrong name above 95 %); ``longest_design`` in s.
    """
    known = rows[rows["open"].astype("boolean").fillna(False) & (rows["failure"] == "") & (rows["truth"] != "")]
    found = {
        "rigs": (float(len(known)), ""),
        "decided": (_decided(known, "designed"), "%"),
        "decided_without_dry_friction": (_decided(known[known["law"] != NESTED], "designed"), "%"),
        "decided_where_promised": (
            _decided(known[known["predicted_weight"].astype(float) >= DECIDED], "designed"),
            "%",
        ),
        "decided_by_repetition": (_decided(known, "repeated"), "%"),
        "right": (_percent(known["designed_right"]), "%"),
        "wrong": (float(summary(rows).set_index(["law", "experiment"])["wrong"]["listed", "designed"]), ""),
        "longest_design": (float(rows["seconds"].astype(float).max()), "s"),
    }
    return pd.DataFrame(
        [{"target": TARGET, "quantity": name, "value": value, "unit": unit} for name, (value, unit) in found.items()]
    )


def _decided(rows: pd.DataFrame, experiment: str) -> float:
    decided, right = (rows[f"{experiment}_{what}"].astype("boolean").fillna(False) for what in ("decided", "right"))
    return _percent(decided & right)


def _percent(right: pd.Series) -> float:
    return 100.0 * float(right.astype("boolean").fillna(False).mean()) if len(right) else np.nan
