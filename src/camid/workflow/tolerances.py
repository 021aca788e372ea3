"""Results against stored tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd


def compare(quantities: pd.DataFrame, tolerances: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Hold every tolerance against the quantity it guards.

    Parameters
    ----------
    quantities : DataFrame
        Columns ``target``, ``quantity``, ``value``, ``unit``.
    tolerances : sequence of mapping
        ``target``, ``quantity``, ``source`` and either ``reference`` with ``tolerance`` (absolute) or a one-sided
        ``at_most`` / ``at_least``.

    Returns
    -------
    DataFrame
        One row per tolerance: ``target``, ``quantity``, ``value``, ``allowed``, ``passed``, ``source``. A quantity that
        is missing or not a number fails.
    """
    values = quantities.set_index(["target", "quantity"])["value"].to_dict()
    rows = []
    for entry in tolerances:
        value = float(values.get((entry["target"], entry["quantity"]), np.nan))
        if "reference" in entry:
            allowed = f"{entry['reference']:g} ± {entry['tolerance']:g}"
            passed = abs(value - entry["reference"]) <= entry["tolerance"]
        else:
            low, high = entry.get("at_least", -np.inf), entry.get("at_most", np.inf)
            allowed = " and ".join(
                text for text, given in ((f"≥ {low:g}", np.isfinite(low)), (f"≤ {high:g}", np.isfinite(high))) if given
            )
            passed = low <= value <= high
        rows.append(
            {
                "target": entry["target"],
                "quantity": entry["quantity"],
                "value": value,
                "allowed": allowed,
                "passed": bool(passed),
                "source": entry["source"],
            }
        )
    return pd.DataFrame(rows)


def without_targets(
    tolerances: Sequence[Mapping[str, Any]], reasons: Mapping[str, str]
) -> tuple[list[Mapping[str, Any]], str]:
    """The tolerances without those of some targets, and one line that says what is not checked and why.

    Parameters
    ----------
    tolerances : sequence of mapping
    reasons : mapping
        Target → why it cannot be checked here.

    Returns
    -------
    list of mapping
        What remains to be checked.
    str
        Empty if nothing is left out.
    """
    kept = [entry for entry in tolerances if entry["target"] not in reasons]
    left_out = sorted({entry["target"] for entry in tolerances} & set(reasons))
    if not left_out:
        return kept, ""
    grouped: dict[str, list[str]] = {}
    for target in left_out:
        grouped.setdefault(reasons[target], []).append(target)
    said = "; ".join(f"{', '.join(targets)} ({reason})" for reason, targets in grouped.items())
    return kept, f"not checked: {said}"


def print_comparison(comparison: pd.DataFrame) -> None:
    """Print the comparison as a table and the number of failures."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=150, highlight=False)
    table = Table(title="Results against the stored tolerances", title_justify="left")
    for heading in ("", "target", "quantity", "value", "allowed", "source of the reference"):
        table.add_column(heading, justify="right" if heading == "value" else "left")
    for row in comparison.to_dict("records"):
        mark = "[green]pass[/]" if row["passed"] else "[bold red]FAIL[/]"
        table.add_row(mark, row["target"], row["quantity"], f"{row['value']:.6g}", row["allowed"], row["source"])
    console.print(table)
    failed = int((~comparison["passed"]).sum())
    console.print(f"{len(comparison) - failed} of {len(comparison)} within tolerance, {failed} failed")
