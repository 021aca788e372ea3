"""What the tool states of rigs with named constants, held against what they are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.errors import InputError
from camid.proof.physical_rigs.rigs import AMBIGUOUS, RIGS, Rig
from camid.proof.physical_rigs.simulator import believed_constants, generator, record
from camid.proof.rates import rate

Array = NDArray[np.float64]

# Half the width of a 95 % interval in standard deviations.
HALF_WIDTH = 1.959963985
# Relative step of the differences by which two sets of expressions are compared, and what of them is rounding.
DIFFERENCE = 1e-6
ROUNDING = 1e-4
# Factors on true constants at which they are compared: expressions that agree at one point only are not the same.
ELSEWHERE = (1.0, 1.3, 0.8)

ESTIMATE_COLUMNS = ["rig", "seed", "constant", "truth", "believed", "estimate", "standard_deviation", "inside"]
AMBIGUOUS_COLUMNS = ["rig", "seed", "quantity", "truth", "estimate", "standard_deviation", "inside", "open", "named"]


def _identified(rig: Rig, seed: int) -> tuple[dict[str, float], Any]:
    """Believed constants, and what is identified of a recording; None where the tool refuses to."""
    from camid.commands.identify import identify

    rng = generator(rig, seed)
    believed = believed_constants(rig, rng)
    try:
        return believed, identify(record(rig, rng), rig.simulation(believed))
    except InputError:
        return believed, None


def _within(estimate: float, deviation: float, truth: float) -> bool:
    return bool(abs(estimate - truth) <= HALF_WIDTH * deviation)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def estimates(rig: Rig, seed: int) -> pd.DataFrame:
    """Estimates of a rig's constants from one recording.

    Returns
    -------
    DataFrame
        One row per constant that is not fixed: ``rig``, ``seed``, ``constant``, ``truth``, ``believed``, ``estimate``,
        ``standard_deviation`` (NaN where none is stated), ``inside`` (whether the 95 % interval holds the truth) and
        ``converged``.
    """
    believed, found = _identified(rig, seed)
    stated = {} if found is None else {row["name"]: row for row in found.parameters()}
    rows = []
    for name in rig.free:
        estimate, deviation = (_number(stated.get(name, {}).get(key)) for key in ("value", "standard_deviation"))
        truth = rig.truth[name]
        rows.append(
            {"rig": rig.name, "seed": seed, "constant": name, "truth": truth, "believed": believed[name]}
            | {"estimate": estimate, "standard_deviation": deviation, "inside": _within(estimate, deviation, truth)}
            | {"converged": found is not None and bool(found.converged)}
        )
    return pd.DataFrame(rows, columns=[*ESTIMATE_COLUMNS, "converged"])


def undetermined(rig: Rig, seed: int) -> pd.DataFrame:
    """What is stated of a rig with constants that no recording tells apart.

    Returns
    -------
    DataFrame
        One row per combination that is stated and per constant that is determined: ``rig``, ``seed``, ``quantity``,
        ``truth``, ``estimate``, ``standard_deviation``, ``inside``; and the same in each of them: ``open`` (whether
        exactly the expected constants are stated as undetermined), ``named`` (whether the combinations say what the
        expected ones do, and no more) and ``converged``.
    """
    _, found = _identified(rig, seed)
    stated = [] if found is None else found.parameters()
    combinations = [] if found is None else found.combinations()
    texts = [row["expression"] for row in combinations]
    shared = {
        "open": {row["name"] for row in stated if row["state"] == "undetermined"} == set(rig.open),
        "named": say_the_same(rig, texts),
        "converged": found is not None and bool(found.converged),
    }
    rows: list[dict[str, Any]] = []
    determined = [row for row in stated if row["name"] in rig.free and row["name"] not in rig.open]
    for row in (*combinations, *determined):
        quantity = row.get("expression", row.get("name"))
        estimate, deviation = _number(row["value"]), _number(row["standard_deviation"])
        truth = meaning(quantity)(rig.truth)
        rows.append(
            {"rig": rig.name, "seed": seed, "quantity": quantity, "truth": truth, "estimate": estimate}
            | {"standard_deviation": deviation, "inside": _within(estimate, deviation, truth), **shared}
        )
    if not rows:
        nothing = {"quantity": "", "truth": np.nan, "estimate": np.nan, "standard_deviation": np.nan, "inside": False}
        rows = [{"rig": rig.name, "seed": seed, **nothing, **shared}]
    return pd.DataFrame(rows, columns=[*AMBIGUOUS_COLUMNS, "converged"])


# -- what a combination says -------------------------------------------------------------------------------------------


def meaning(expression: str) -> Callable[[Mapping[str, float]], float]:
    """An expression that the tool states, as a function of the constants: read by Python, not by the tool's parser."""
    code = compile(expression.replace("^", "**"), "<combination>", "eval")
    return lambda constants: float(eval(code, {"__builtins__": {}, "sqrt": np.sqrt}, dict(constants)))


def say_the_same(rig: Rig, texts: Iterable[str]) -> bool:
    """Whether expressions determine what the rig's combinations do, no more and no less, however they are written."""
    stated = [meaning(text) for text in texts]
    expected = list(rig.combinations.values())
    if len(stated) != len(expected):
        return False
    for factor in ELSEWHERE:
        point = {name: value * (factor if i % 2 else 1.0) for i, (name, value) in enumerate(rig.truth.items())}
        ours, theirs = _slopes(expected, point), _slopes(stated, point)
        # Functions of the same combinations change by the same changes of the constants.
        if not _rank(ours) == _rank(theirs) == _rank(np.vstack([ours, theirs])) == len(expected):
            return False
    return True


def _slopes(functions: list[Callable[[Mapping[str, float]], float]], point: Mapping[str, float]) -> Array:
    """Relative changes of the functions by relative changes of the constants, shape (functions, p)."""
    table = np.empty((len(functions), len(point)))
    for column, name in enumerate(point):
        ends = [{**point, name: point[name] * (1.0 + side * DIFFERENCE)} for side in (1.0, -1.0)]
        table[:, column] = [(f(ends[0]) - f(ends[1])) / (2.0 * DIFFERENCE * f(point)) for f in functions]
    return table


def _rank(table: Array) -> int:
    return int(np.linalg.matrix_rank(table, tol=ROUNDING))


# -- tables ------------------------------------------------------------------------------------------------------------


def cases(rigs: tuple[Rig, ...], seed: int, seeds: int, shard: int, shards: int) -> list[tuple[Rig, int]]:
    """Rigs and seeds of one of ``shards`` jobs that share them out."""
    return [(rig, seed + i) for i in range(seeds) for rig in rigs][shard::shards]


def campaign(seed: int, seeds: int, shard: int, shards: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of :func:`estimates` and of :func:`undetermined`, of one shard."""
    found = (
        pd.concat([function(*case) for case in cases(rigs, seed, seeds, shard, shards)], ignore_index=True)
        for function, rigs in ((estimates, RIGS), (undetermined, AMBIGUOUS))
    )
    first, second = found
    return first, second


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Coverage of the 95 % intervals of estimates that converged, per rig and of all rigs together.

    The interval of the coverage (Wilson) takes the constants of a recording for independent.

    Parameters
    ----------
    table : DataFrame
        Of :func:`estimates` or :func:`undetermined`.

    Returns
    -------
    DataFrame
        ``rig``, ``recordings``, ``converged`` (number of recordings), ``intervals``, ``share``, ``from``, ``to``, and
        ``spread``: the root mean square error in standard deviations, one where they are true.
    """
    names = list(dict.fromkeys(rig.name for rig in (*RIGS, *AMBIGUOUS) if rig.name in set(table["rig"])))
    rows = []
    for name, part in [*((name, table[table["rig"] == name]) for name in names), ("all", table)]:
        used = part[part["converged"]]
        share, low, high = rate(int(used["inside"].sum()), len(used))
        errors = (used["estimate"] - used["truth"]) / used["standard_deviation"]
        rows.append(
            {"rig": name, "recordings": len(part.drop_duplicates(["rig", "seed"]))}
            | {"converged": len(used.drop_duplicates(["rig", "seed"])), "intervals": len(used)}
            | {"share": share, "from": low, "to": high, "spread": float(np.sqrt(np.mean(errors**2)))}
        )
    return pd.DataFrame(rows)


def summary_of_undetermined(table: pd.DataFrame) -> pd.DataFrame:
    """:func:`summary` of :func:`undetermined`, with the numbers of recordings in which the words were right."""
    recordings = table.drop_duplicates(["rig", "seed"])
    found = summary(table)
    for word in ("open", "named"):
        counts = recordings.groupby("rig")[word].sum().to_dict()
        found[word] = [int(sum(counts.values()) if rig == "all" else counts[rig]) for rig in found["rig"]]
    return found


def to_markdown(determined: pd.DataFrame, ambiguous: pd.DataFrame, stamp: str) -> str:
    """Both summaries as tables for people, and how they were made."""
    known = {rig.name: rig for rig in (*RIGS, *AMBIGUOUS)}
    first = [
        [row["rig"], ", ".join(known[row["rig"]].free) if row["rig"] in known else "", *_shown(row)]
        for _, row in determined.iterrows()
    ]
    second = [
        [
            row["rig"],
            ", ".join(f"`{text}`" for text in known[row["rig"]].combinations) if row["rig"] in known else "",
            *(f"{row[word]} of {row['recordings']}" for word in ("open", "named")),
            *_shown(row),
        ]
        for _, row in ambiguous.iterrows()
    ]
    measured = [
        "recordings",
        "converged",
        "95 % intervals that hold the truth",
        "95 % interval",
        "of",
        "errors / stated",
    ]
    return "\n".join(
        [
            "Coverage of 95 % intervals, of constants that a recording determines:\n",
            _table(first, ["rig", "estimated", *measured]),
            "\nConstants that no recording tells apart; coverage is that of combinations and of the other constants:\n",
            _table(second, ["rig", "determined instead", "constants right", "combinations right", *measured]),
            f"\n{stamp}\n",
        ]
    )


def _shown(row: pd.Series) -> list[str]:
    shares = [f"{100.0 * row[key]:.1f} %" for key in ("share", "from", "to")]
    counts = [str(row["recordings"]), str(row["converged"])]
    return [*counts, shares[0], f"{shares[1]} to {shares[2]}", str(row["intervals"]), f"{row['spread']:.2f}"]


def _table(rows: list[list[str]], headers: list[str]) -> str:
    from tabulate import tabulate

    return tabulate(rows, headers, tablefmt="pipe", disable_numparse=True)
