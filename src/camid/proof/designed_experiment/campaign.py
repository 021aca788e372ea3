"""Designed experiments held against plain repetitions: how often one name is left, and the right one."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from camid.errors import InputError
from camid.proof.designed_experiment.rigs import Rig, draw, first_input, readings, recording
from camid.proof.rates import rate

# What the laws of the generator are called in the catalogue.
IDENTIFIERS = {
    "dry friction": "coulomb-friction",
    "quadratic drag": "quadratic-drag",
    "damping that grows with the position": "amplitude-dependent-damping",
    "cubic spring": "cubic-stiffness",
    "quadratic spring": "quadratic-stiffness",
    "dead zone": "dead-zone",
    "saturation": "saturation",
    "play": "backlash",
    "uneven gain": "gain-asymmetry",
    "lens": "lens-distortion",
    "perspective": "perspective",
}
UNLISTED = "unlisted"
# Weight of two names from which a first recording is ambiguous, and that of one from which it is decided.
OPEN, DECIDED = 0.10, 0.95
EXPERIMENTS = ("designed", "repeated")
WORDS = {"designed": "designed", "repeated": "the first one repeated"}
LAWS = {
    "listed": "in the catalogue",
    "promised": "… and the design promises to decide",
    "outside": "outside of the catalogue",
}
# Travel that the rig allows, as a multiple of the largest reading of the first recording.
TRAVEL = 2.0
COLUMNS = ["number", "law", "truth", "first_names", "open", "failure"]
COLUMNS += ["kind", "seconds", "first_truth_weight", "predicted_evidence", "predicted_weight"]
COLUMNS += [
    f"{e}_{c}"
    for e in EXPERIMENTS
    for c in ("name", "weight", "among_names", "gap", "right", "decided", "truth_weight")
]


def names_of(diagnosis: Any) -> dict[str, float]:
    """Weights of the names of the strongest effect, and of what is outside the catalogue."""
    if not diagnosis.findings:
        return {}
    finding = diagnosis.findings[0]
    return {finding.identifier: finding.weight, **dict(finding.alternatives)}


def is_open(names: dict[str, float]) -> bool:
    """Whether two names or more are left."""
    return sum(weight >= OPEN for name, weight in names.items() if name != UNLISTED) > 1


def judged(names: dict[str, float], truth: str | None, prefix: str, gap: float) -> dict[str, Any]:
    """What a diagnosis states, beside the truth (None: outside of the catalogue)."""
    listed = {n: w for n, w in names.items() if n != UNLISTED}
    if not listed:
        row: dict[str, Any] = {"name": "", "weight": 0.0, "among_names": 0.0, "gap": np.nan}
    else:
        name = max(listed, key=lambda n: listed[n])
        among = listed[name] / sum(listed.values())
        row = {"name": name, "weight": listed[name], "among_names": among, "gap": gap}
    row["right"] = row["name"] == truth
    row["decided"] = row["weight"] >= DECIDED
    row["truth_weight"] = names.get(truth or UNLISTED, 0.0)
    return {f"{prefix}_{key}": value for key, value in row.items()}


def scored(rig: Rig, folder: Path) -> dict[str, Any]:
    """One row of :func:`campaign`."""
    import camid

    truth = IDENTIFIERS.get(rig.law)
    row: dict[str, Any] = {"number": rig.number, "law": rig.law, "truth": truth or "", "failure": ""}
    files = {name: folder / f"{rig.number}_{name}.csv" for name in ("first", *EXPERIMENTS)}
    signal = first_input(rig)
    recording(rig, signal, 0).to_csv(files["first"], index=False)
    try:
        first = camid.diagnose(files["first"], rig.simulation(), time_limit=None)
        names = names_of(first)
        row |= {"first_names": ", ".join(f"{n} {w:.2f}" for n, w in names.items()), "open": is_open(names)}
        if not row["open"]:
            return row
        largest = TRAVEL * float(np.max(np.abs(readings(rig, signal, rig.law))))
        started = perf_counter()
        design = camid.design(first, travel=(-largest, largest), rate=float("inf"), time_limit=None)
        row |= {"kind": design.kind, "seconds": perf_counter() - started, "first_truth_weight": names.get(truth or "")}
        expected = next((e for e in design.expectations if e.identifier == truth), None)
        if expected is not None:
            row |= {"predicted_evidence": expected.evidence, "predicted_weight": expected.weight}
        inputs = {"designed": design.played.signal, "repeated": signal}
        for run, name in enumerate(EXPERIMENTS, 1):
            recording(rig, inputs[name], run).to_csv(files[name], index=False)
            both = camid.diagnose([files["first"], files[name]], rig.simulation(), time_limit=None)
            gap = both.findings[0].evidence.get("delta_bic_to_next_best") if both.findings else None
            row |= judged(names_of(both), truth, name, np.nan if gap is None else float(gap))
    except InputError as refusal:
        row["failure"] = str(refusal).splitlines()[0]
    return row


def campaign(seed: int, rigs: int, shard: int, shards: int, folder: Path) -> pd.DataFrame:
    """Outcome of the rigs of one of ``shards`` jobs that share them out.

    Parameters
    ----------
    seed, rigs, shard, shards : int
    folder : Path
        Takes the recordings.

    Returns
    -------
    DataFrame
        One row per rig: ``number``, ``law``, ``truth`` (identifier; empty for a law outside of the catalogue),
        ``first_names``, ``open`` (whether two names or more are left), ``failure``; of those that are open the ``kind``
        of the designed input, ``seconds`` that the design took, ``first_truth_weight`` (of the truth, before),
        ``predicted_evidence`` and ``predicted_weight`` (of the truth, after), and for ``designed`` and ``repeated``
        second recordings what the diagnosis of both states: ``_name``, ``_weight``, ``_among_names`` (without what is
        outside of the catalogue), ``_gap`` (ΔBIC to the next best), ``_right``, ``_decided``, ``_truth_weight``.
    """
    rows = [scored(draw(seed, number), folder) for number in range(shard, rigs, shards)]
    return pd.DataFrame(rows).reindex(columns=COLUMNS)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """How often one name is left, per second experiment, of rigs with a listed law and of those with another.

    Returns
    -------
    DataFrame
        ``law`` (listed; promised: those of them of which the design says that it decides; outside), ``experiment``,
        ``rigs``; ``decided`` (one name above 95 % and right; for laws outside of the catalogue: any name above 95 %,
        which is wrong), its ``share`` with the 95 % interval (Wilson) ``from`` and ``to``; ``wrong`` (a wrong name
        above 95 %), ``right`` (the likeliest name is the right one), ``among_names`` (as ``decided``, by the weights
        among the names alone).
    """
    rows = []
    known = table[(table["open"].astype("boolean").fillna(False)) & (table["failure"] == "")]
    listed = known[known["truth"] != ""]
    promised = listed[listed["predicted_weight"].astype(float) >= DECIDED]
    for law, part in (("listed", listed), ("promised", promised), ("outside", known[known["truth"] == ""])):
        for experiment in EXPERIMENTS:
            decided = part[f"{experiment}_decided"].astype("boolean").fillna(False)
            right = part[f"{experiment}_right"].astype("boolean").fillna(False)
            good = decided if law == "outside" else decided & right
            share, low, high = rate(int(good.sum()), len(part))
            among = part[f"{experiment}_among_names"].astype(float) >= DECIDED
            rows.append(
                {
                    "law": law,
                    "experiment": experiment,
                    "rigs": len(part),
                    "decided": int(good.sum()),
                    "share": share,
                    "from": low,
                    "to": high,
                    "wrong": int((decided & ~right).sum()),
                    "right": int(right.sum()),
                    "among_names": int(among.sum()) if law == "outside" else int((among & right).sum()),
                }
            )
    return pd.DataFrame(rows)


def to_markdown(table: pd.DataFrame, rows: pd.DataFrame, stamp: str) -> str:
    """:func:`summary` as a table for people, and how it was made."""
    from tabulate import tabulate

    headers = ["law of the rig", "second experiment", "rigs", "one name above 95 % and right", "95 % interval"]
    headers += ["a wrong name above 95 %", "the likeliest name is right", "above 95 % and right among the names"]
    lines = [
        [
            LAWS[str(row["law"])],
            WORDS[row["experiment"]],
            str(row["rigs"]),
            f"{row['decided']} ({100.0 * row['share']:.0f} %)",
            f"{100.0 * row['from']:.0f} to {100.0 * row['to']:.0f} %",
            str(row["wrong"]),
            str(row["right"]),
            str(row["among_names"]),
        ]
        for _, row in table[table["law"] != "outside"].iterrows()
    ]
    outside = table[table["law"] == "outside"]
    lines += [
        [LAWS["outside"], WORDS[row["experiment"]], str(row["rigs"]), "–", "–", str(row["decided"]), "–", "–"]
        for _, row in outside.iterrows()
    ]
    seconds = rows["seconds"].astype(float)
    taken = f"A design took {seconds.median():.0f} s in the median and {seconds.max():.0f} s at most."
    return "\n".join(
        [
            "Rigs whose first diagnosis keeps two names or more above 10 %, and what the diagnosis of both recordings "
            "states:\n",
            tabulate(lines, headers, tablefmt="pipe", disable_numparse=True),
            f"\n{taken}\n\n{stamp}\n",
        ]
    )
