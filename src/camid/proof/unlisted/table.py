"""What is right in the answers on unlisted laws, and the table of it for people."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

import numpy as np
import pandas as pd

from camid.proof.rates import rate
from camid.proof.unlisted.campaign import without_numbers

# Forms of the documented dictionary, as the report writes them over x: what is exact for a law of that form.
FORMS = {
    "inverse square": [r"1/\(x0 − x\)²", r"1/\(x − x0\)²"],
    "dead zone": [r"a·dead_zone\(x, c\)$"],
    "square": [r"a·x²$"],
    "cube": [r"a·x³$", r"sign\(x\)·\|x\|\^p"],
    "fifth power": [r"a·x⁵$", r"sign\(x\)·\|x\|\^p"],
    "signed power": [r"sign\(x\)·\|x\|\^p"],
    "signed root": [r"sign\(x\)·√\|x\|", r"sign\(x\)·\|x\|\^p"],
    "modulus": [r"a·\|x\|$", r"a·\|x\|\^p", r"a·max\(−?x, 0\)"],
    "kink at zero": [r"a·\|x\|$", r"max\(", r"a·\|x\|\^p"],
    "kink": [r"max\("],
    "tanh": [r"tanh\(x/c\)"],
    "step": [r"tanh\(\(x − x0\)/c\)", r"sign\(x − x0\)", r"step"],
    "exponential": [r"a·exp\(−?x/c\)"],
    "bump": [r"a·exp\(−\(\(x − x0\)/c\)²\)"],
    "rational bump": [r"a/\(1 \+ \(\(x − x0\)/c\)²\)"],
    "pull": [r"\(x − x0\)/c·exp\(−\(\(x − x0\)/c\)²\)"],
    "two harmonics": [r"sin\(4π"],
}


def form_is_right(formula: str, form: str) -> bool:
    """Whether a formula has the law's form, whatever its numbers."""
    text = re.sub(r"(?<![a-zA-Z])[yvu](?![a-zA-Z])", "x", without_numbers(formula).rpartition(" = ")[2])
    # A power is written over the size of the motion.
    text = re.sub(r"\|x/[\d.]+\|", "|x|", text)
    return any(re.search(pattern, text) for pattern in FORMS.get(form, []))


def judged(answers: pd.DataFrame) -> pd.DataFrame:
    """The answers of :func:`camid.proof.unlisted.campaign.campaign` with ``variables_right`` and ``formula_right``.

    Both are false where nothing was found, and for rigs with nothing missing, where nothing can be recovered, either.
    """
    rows = answers.copy()
    rows["recovered"] = rows["recovered"].where(rows["missing"])
    rows["variables_right"] = rows["missing"] & (rows["carrier_variables"] == rows["variables"])
    rows["formula_right"] = [
        row["missing"] and row["formula_variables"] == row["variables"] and form_is_right(row["formula"], row["form"])
        for _, row in rows.iterrows()
    ]
    return rows


def quantities(rows: pd.DataFrame) -> pd.DataFrame:
    """What is held against the stored tolerances: ``target``, ``quantity``, ``value`` and ``unit``.

    Parameters
    ----------
    rows : DataFrame
        Of :func:`judged`.
    """
    under, without = rows[rows["missing"]], rows[~rows["missing"]]
    shares = under["recovered"].fillna(0.0)
    offered = under[under["formula"] != ""]
    values = [
        ("recovered_median", float(shares.median()), ""),
        ("recovered_lower_quartile", float(shares.quantile(0.25)), ""),
        ("variables_right", 100.0 * float(under["variables_right"].mean()), "%"),
        ("formulas_right_in_form", 100.0 * float(offered["formula_right"].mean()), "%"),
        ("learned_where_nothing_is_missing", 100.0 * float((without["learned"] > 0).mean()), "%"),
    ]
    return pd.DataFrame(
        [{"target": "unlisted", "quantity": name, "value": value, "unit": unit} for name, value, unit in values]
    )


def to_markdown(rows: pd.DataFrame, stamp: str, asked: Mapping[str, str]) -> str:
    """Numbers of all recordings, those of each law, and how they were made.

    Parameters
    ----------
    rows : DataFrame
        Of :func:`judged`.
    stamp : str
    asked : mapping
        What is allowed of the quantities of :func:`quantities`.
    """
    under = rows[rows["missing"]]
    return "\n".join(
        [
            "Rigs under laws outside the catalogue, and rigs with nothing missing:\n",
            _table(_whole(rows, asked), ["", "measured", "95 % interval", "asked for"]),
            _DEFINITIONS,
            _table(_laws(under), _LAW_COLUMNS),
            f"\n{stamp}\n",
        ]
    )


_DEFINITIONS = """
*Recovered* is 1 − (error of the improved simulation)/(error with re-estimated coefficients alone) on a second recording
of the rig: another input of the same amplitude (the largest position without the law, or velocity or input where the
law is of that). Both errors are root mean squares against that recording **without its noise**, so that no noise floor
is in them and a perfect model has a share of 1; a model worse than re-estimated coefficients has one below 0. Refused
recordings and simulations that diverge count as 0. *Variables right*: what removes the largest share of the refitted
error (or the formula that stands for it), named or learned, is a function of what the law is a function of, at its
place. A formula's *error* is its distance from the law over the middle 98 % of the recording, over the law's bend, less
what coefficients can do. A formula offered for a law that the dictionary does not hold counts as wrong.
"""
_LAW_COLUMNS = [
    "law",
    "over",
    "recordings",
    "recovered: lowest, median, highest",
    "variables right",
    "with a learned law",
    "formulas",
    "right in form",
    "error of the right ones, median",
    "what carries it instead, where the variables are wrong",
]


def _whole(rows: pd.DataFrame, asked: Mapping[str, str]) -> list[list[str]]:
    under, without = rows[rows["missing"]], rows[~rows["missing"]]
    shares = under["recovered"].fillna(0.0)
    offered = under[under["formula"] != ""]
    right = offered[offered["formula_right"]]
    expressible = offered[offered["form"] != ""]
    named = without["effects"].map(lambda text: len(json.loads(text)) > 0)
    return [
        ["recordings under a law", str(len(under)), "", "200"],
        ["recovered share, median", f"{shares.median():.3f}", "", asked.get("recovered_median", "")],
        [
            "recovered share, lower quartile",
            f"{shares.quantile(0.25):.3f}",
            "",
            asked.get("recovered_lower_quartile", ""),
        ],
        _share("variables right", int(under["variables_right"].sum()), len(under), _percent(asked, "variables_right")),
        _share("recordings with a learned law", int((under["learned"] > 0).sum()), len(under), ""),
        _share(
            "formulas right in form, of those offered",
            len(right),
            len(offered),
            _percent(asked, "formulas_right_in_form"),
        ),
        _share("… of those for laws in the dictionary", int(expressible["formula_right"].sum()), len(expressible), ""),
        ["error of formulas right in form: median, worst", _median_and_worst(right["curve_error"]), "", ""],
        ["recordings with nothing missing", str(len(without)), "", "200"],
        _share(
            "learned laws there",
            int((without["learned"] > 0).sum()),
            len(without),
            _percent(asked, "learned_where_nothing_is_missing"),
        ),
        _share("any effect named there", int(named.sum()), len(without), ""),
        ["refused, or diverged", str(int((rows["failure"] != "").sum())), "", ""],
    ]


def _percent(asked: Mapping[str, str], quantity: str) -> str:
    return f"{asked[quantity]} %" if quantity in asked else ""


def _share(words: str, successes: int, trials: int, asked: str) -> list[str]:
    share, low, high = rate(successes, trials)
    return [words, f"{successes} of {trials} ({100 * share:.1f} %)", f"{100 * low:.1f} % to {100 * high:.1f} %", asked]


def _median_and_worst(errors: pd.Series) -> str:
    known = errors.dropna()
    return f"{100 * known.median():.2f} %, {100 * known.max():.2g} %" if len(known) else "–"


def _laws(under: pd.DataFrame) -> list[list[str]]:
    lines = []
    for name, part in under.groupby("law", sort=False):
        shares = part["recovered"].fillna(0.0)
        offered = part[part["formula"] != ""]
        right = offered[offered["formula_right"]]
        wrong = part.loc[~part["variables_right"], "carrier"].replace("", "nothing").value_counts()
        error = right["curve_error"].median()
        lines.append(
            [
                str(name),
                str(part["variables"].iloc[0]),
                str(len(part)),
                f"{shares.min():.2f}, {shares.median():.2f}, {shares.max():.2f}",
                str(int(part["variables_right"].sum())),
                str(int((part["learned"] > 0).sum())),
                str(len(offered)),
                str(len(right)) if part["form"].iloc[0] else "not in the dictionary",
                "" if np.isnan(error) else f"{100 * error:.2g} %",
                ", ".join(f"{effect} ({count})" for effect, count in sorted(wrong.items())),
            ]
        )
    return lines


def _table(rows: list[list[str]], headers: list[str]) -> str:
    from tabulate import tabulate

    return tabulate(rows, headers, tablefmt="pipe", disable_numparse=True)
