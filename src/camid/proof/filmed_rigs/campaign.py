"""What the tool finds in filmed rigs by three commands, held against what was put into them."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from camid.proof.filmed_rigs.renderer import film
from camid.proof.filmed_rigs.rigs import CONCEALED, NOTHING, Rig, draw, drive_table, run, simulation
from camid.proof.scoring import FAILED, class_of, named_in, own_weight

COLUMNS = [
    "clip",
    "concealed",
    "size",
    "verdict",
    "named",
    "weight",
    "alternatives",
    "right",
    "offset_error",
    "skew_error",
    "seconds",
    "failure",
]


def write_rig(rig: Rig, seed: int, number: int, folder: Path) -> None:
    """Write ``frames``, ``drive.csv`` and ``rig.yaml`` into a folder."""
    from ruamel.yaml import YAML

    motion = run(rig, seed, number)
    film(rig, motion, folder / "frames", np.random.default_rng([seed, number, 2]))
    drive_table(rig, motion).to_csv(folder / "drive.csv", index=False)
    with (folder / "rig.yaml").open("w", encoding="utf-8") as file:
        YAML().dump(simulation(rig, motion), file)


def commands(rig: Rig, folder: Path) -> list[list[str]]:
    """Arguments of the three commands: track, join, diagnose."""
    clip, drive, recording, joined = (
        str(folder / name) for name in ("clip.csv", "drive.csv", "recording.csv", "joined.yaml")
    )
    marker = "--bright" if rig.bright else "--dark"
    given = ["--simulation", str(folder / "rig.yaml")]
    return [
        ["track", str(folder / "frames"), marker, "--output", clip],
        ["join", clip, drive, *given, "--output", recording, "--write-simulation", joined, "--json"],
        ["diagnose", recording, "--simulation", joined, "--no-report", "--output", str(folder / "diagnosis")],
    ]


def scored(rig: Rig, seed: int, number: int, folder: Path) -> dict[str, Any]:
    """One row of :func:`campaign`; its files go into a folder that exists."""
    write_rig(rig, seed, number, folder)
    row: dict[str, Any] = {"clip": number, "concealed": rig.concealed, "size": rig.size}
    started, clocks, diagnosis, failure = time.perf_counter(), None, None, ""
    for arguments in commands(rig, folder):
        done = subprocess.run([sys.executable, "-m", "camid", *arguments], check=False, capture_output=True, text=True)
        if done.returncode != 0:
            failure = f"{arguments[0]}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ''}"
            break
        if arguments[0] == "join":
            clocks = json.loads(done.stdout)
    if not failure:
        diagnosis = json.loads((folder / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    row |= {"seconds": time.perf_counter() - started, "failure": failure}
    return row | clock_errors(rig, clocks) | judged(rig.concealed, diagnosis)


def clock_errors(rig: Rig, clocks: Mapping[str, Any] | None) -> dict[str, float]:
    """Error of the offset in the middle of the clip, in frames, and of the skew; NaN where nothing was joined."""
    if clocks is None:
        return {"offset_error": np.nan, "skew_error": np.nan}
    middle = rig.first + 0.5 * rig.frames / rig.frame_rate
    stated = clocks["offset"] + (1.0 + clocks["skew"]) * middle
    frame = (1.0 + rig.skew) / rig.frame_rate
    error = float((stated - rig.to_drive(middle)) / frame)
    return {"offset_error": error, "skew_error": float(clocks["skew"] - rig.skew)}


def judged(concealed: str, diagnosis: Mapping[str, Any] | None) -> dict[str, Any]:
    """What a diagnosis names first, and whether that is right.

    Where nothing is concealed, it is right to find nothing, or noise; else the first entry has to be what was put in,
    or to list it among what it cannot be told apart from.
    """
    from camid.effects import known_effects

    if diagnosis is None:
        return {"verdict": FAILED, "named": "", "weight": np.nan, "alternatives": "", "right": False}
    effects = named_in(diagnosis)
    members = class_of(effects[0]) if effects else []
    catalogue = known_effects()
    if concealed == NOTHING:
        noise = all(effect["id"] in catalogue and catalogue[effect["id"]].noise_like for effect in effects)
        right = diagnosis["verdict"] == "adequate" or (noise and len(effects) > 0)
    else:
        right = concealed in members
    return {
        "verdict": str(diagnosis["verdict"]),
        "named": " + ".join(str(effect["id"]) for effect in effects),
        "weight": own_weight(effects[0]) if effects else np.nan,
        "alternatives": ", ".join(members[1:]),
        "right": bool(right),
    }


def campaign(seed: int, clips: int, shard: int, shards: int, folder: Path) -> pd.DataFrame:
    """Diagnoses of one of ``shards`` jobs that share the clips out.

    Parameters
    ----------
    seed, clips, shard, shards : int
    folder : Path
        Takes the clips, one after the other.

    Returns
    -------
    DataFrame
        One row per clip: ``clip``, ``concealed``, ``size``, ``verdict``, ``named`` (joined by " + "), ``weight`` and
        ``alternatives`` of the first, ``right``, ``offset_error`` (frames, in the middle of the clip), ``skew_error``,
        ``seconds`` (of the three commands) and ``failure`` (what a command said that failed).
    """
    import shutil

    rows = []
    for number in range(shard, clips, shards):
        place = folder / str(number)
        place.mkdir()
        rows.append(scored(draw(seed, number), seed, number, place))
        shutil.rmtree(place)
    return pd.DataFrame(rows, columns=COLUMNS)


def to_markdown(table: pd.DataFrame, stamp: str) -> str:
    """One line per clip, and how many are right of what."""
    from tabulate import tabulate

    headers = ["clip", "concealed", "size", "verdict", "named", "weight", "cannot be told from", "right"]
    headers += ["error of the offset, frames", "of the skew, 10⁻⁶", "seconds"]
    lines = [
        [
            str(row["clip"]),
            row["concealed"],
            f"{100.0 * row['size']:.0f} %" if row["size"] > 0.0 else "",
            row["verdict"],
            row["named"] or row["failure"],
            "" if np.isnan(row["weight"]) else f"{100.0 * row['weight']:.0f} %",
            row["alternatives"],
            "yes" if row["right"] else "no",
            f"{row['offset_error']:+.3f}",
            f"{1e6 * row['skew_error']:+.0f}",
            f"{row['seconds']:.0f}",
        ]
        for _, row in table.sort_values("clip").iterrows()
    ]
    counts = [
        f"{name}: {int(part['right'].sum())} of {len(part)}"
        for name in CONCEALED
        if len(part := table[table["concealed"] == name])
    ]
    return "\n".join(
        [
            "What `camid track`, `camid join` and `camid diagnose` say of rendered clips:\n",
            tabulate(lines, headers, tablefmt="pipe", disable_numparse=True),
            f"\nRight: {int(table['right'].sum())} of {len(table)} ({'; '.join(counts)}).\n",
            f"{stamp}\n",
        ]
    )
