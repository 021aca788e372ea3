"""What the tool states of two clocks, held against how they were set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from camid.errors import InputError
from camid.proof.rates import rate
from camid.proof.two_clocks.pairs import METHODS, Pair, draw, tables

# Half the width of a 95 % interval in standard deviations.
HALF_WIDTH = 1.959963985
WORDS = {"match": "the encoder", "simulation": "the plant"}
COLUMNS = [
    "number",
    "method",
    "failure",
    "offset_error",
    "offset_deviation",
    "offset_inside",
    "frame",
    "skew_error",
    "skew_deviation",
    "skew_inside",
]


def joined(pair: Pair, folder: Path) -> Any:
    """What ``camid.join`` returns for a pair; its tables are written into a folder."""
    import camid

    files = folder / f"clip_{pair.number}.csv", folder / f"drive_{pair.number}.csv"
    for table, file in zip(tables(pair), files, strict=True):
        table.to_csv(file, index=False)
    if pair.method == "match":
        return camid.join(*files, match=("x", "encoder"), exposure=pair.exposure)
    return camid.join(*files, simulation=pair.simulation())


def scored(pair: Pair, folder: Path) -> dict[str, Any]:
    """One row of :func:`campaign`."""
    row: dict[str, Any] = {"number": pair.number, "method": pair.method, "failure": ""}
    try:
        clocks = joined(pair, folder).clocks
    except InputError as refusal:
        nothing = {"offset_inside": False, "skew_inside": False}
        return {**dict.fromkeys(COLUMNS, np.nan), **row, **nothing, "failure": str(refusal).splitlines()[0]}
    # Where the clip is, what is stated of the offset does not hang on what is stated of the skew.
    error = float(clocks.to_drive(pair.middle) - pair.to_drive(pair.middle))
    deviation = clocks.uncertainty(pair.middle)
    drift = clocks.skew - pair.skew
    return row | {
        "offset_error": error,
        "offset_deviation": deviation,
        "offset_inside": bool(abs(error) <= HALF_WIDTH * deviation),
        "frame": (1.0 + pair.skew) / pair.frames,
        "skew_error": drift,
        "skew_deviation": clocks.skew_deviation,
        "skew_inside": bool(abs(drift) <= HALF_WIDTH * clocks.skew_deviation),
    }


def campaign(seed: int, pairs: int, shard: int, shards: int, folder: Path) -> pd.DataFrame:
    """Errors of the clocks of one of ``shards`` jobs that share the pairs out.

    Parameters
    ----------
    seed, pairs, shard, shards : int
    folder : Path
        Takes the tables.

    Returns
    -------
    DataFrame
        One row per pair: ``number``, ``method``, ``failure`` (what the tool said where it refused), ``offset_error``
        and ``offset_deviation`` (s, in the middle of the clip), ``offset_inside`` (whether the 95 % interval holds the
        truth), ``frame`` (s from frame to frame), ``skew_error``, ``skew_deviation`` and ``skew_inside``.
    """
    rows = [scored(draw(seed, number), folder) for number in range(shard, pairs, shards)]
    return pd.DataFrame(rows, columns=COLUMNS)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Coverage of the 95 % intervals and errors, per method and of all pairs together.

    Returns
    -------
    DataFrame
        ``method``, ``pairs``, ``failures``; for ``offset`` (in the middle of the clip) and ``skew`` the ``_share`` of
        intervals that hold the truth with its 95 % interval (Wilson) ``_from`` and ``_to``, and ``_spread``, the root
        mean square of error / stated deviation; ``median`` and ``worst`` error and ``stated``, the median of the stated
        deviation, all of the offset in frames. Failures count in no share.
    """
    rows = []
    for method, part in [*((name, table[table["method"] == name]) for name in METHODS), ("all", table)]:
        known = part[part["failure"] == ""]
        row: dict[str, Any] = {"method": method, "pairs": len(part), "failures": len(part) - len(known)}
        for name in ("offset", "skew"):
            share, low, high = rate(int(known[f"{name}_inside"].sum()), len(known))
            ratios = (known[f"{name}_error"] / known[f"{name}_deviation"]).to_numpy(float)
            row |= {f"{name}_share": share, f"{name}_from": low, f"{name}_to": high}
            row[f"{name}_spread"] = float(np.sqrt(np.mean(ratios**2))) if len(ratios) else np.nan
        errors = (known["offset_error"] / known["frame"]).abs()
        stated = (known["offset_deviation"] / known["frame"]).median()
        rows.append(row | {"median": errors.median(), "worst": errors.max(), "stated": stated})
    return pd.DataFrame(rows)


def to_markdown(table: pd.DataFrame, stamp: str) -> str:
    """:func:`summary` as a table for people, and how it was made."""
    from tabulate import tabulate

    headers = ["joined by", "pairs", "failures", "offset: 95 % intervals that hold the truth", "95 % interval"]
    headers += ["errors / stated", "skew: 95 % intervals that hold the truth", "95 % interval", "errors / stated"]
    headers += ["error of the offset, median", "stated, median", "worst error"]
    lines = [
        [WORDS.get(row["method"], row["method"]), str(row["pairs"]), str(row["failures"])]
        + [cell for name in ("offset", "skew") for cell in _shown(row, name)]
        + [f"{100.0 * row[key]:.2f}" for key in ("median", "stated", "worst")]
        for _, row in table.iterrows()
    ]
    return "\n".join(
        [
            "Offset of the clocks in the middle of the clip, and their skew; errors in hundredths of a frame:\n",
            tabulate(lines, headers, tablefmt="pipe", disable_numparse=True),
            f"\n{stamp}\n",
        ]
    )


def _shown(row: pd.Series, name: str) -> list[str]:
    shares = [f"{100.0 * row[f'{name}_{key}']:.1f} %" for key in ("share", "from", "to")]
    return [shares[0], f"{shares[1]} to {shares[2]}", f"{row[f'{name}_spread']:.2f}"]
