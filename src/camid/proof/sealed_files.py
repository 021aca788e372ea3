"""Concealed recordings on disk: written and sealed before the diagnoses, checked after."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from camid.proof.sealing import check_seal, seal
from camid.writing import write_whole

if TYPE_CHECKING:
    from camid.proof.concealed.generator import ConcealedRecording

RECORDING, SIMULATION = "recording.csv", "simulation.yaml"
HELD_OUT = ("same_kind", "double_amplitude")
DIAGNOSIS, IMPROVED, FAILURE = "diagnosis.json", "improved.yaml", "failure.txt"


def write_case(index: int, made: ConcealedRecording, recordings: Path, held_out: Path, truths: Path) -> None:
    """Write what the diagnosis may see, what is held out and what is concealed into three folders."""
    write_table(made.recording, recordings / str(index) / RECORDING)
    write_yaml(made.simulation, recordings / str(index) / SIMULATION)
    for name in HELD_OUT:
        write_table(getattr(made, name), held_out / str(index) / f"{name}.csv")
    truths.mkdir(parents=True, exist_ok=True)
    text = json.dumps(made.truth, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    write_whole(truths / f"{index}.json", lambda path: path.write_text(text + "\n", encoding="utf-8"))


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, lambda temporary: table.to_csv(temporary, index=False, lineterminator="\n"))


def write_yaml(content: Mapping[str, Any], path: Path) -> None:
    """Write a simulation file, whole or not at all."""
    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    write_whole(path, lambda temporary: yaml.dump(dict(content), temporary))


def sealed_files(index: int, recordings: Path, held_out: Path) -> list[Path]:
    """Files that a seal covers in addition to the truth, in its order."""
    return [
        recordings / str(index) / RECORDING,
        recordings / str(index) / SIMULATION,
        *(held_out / str(index) / f"{name}.csv" for name in HELD_OUT),
    ]


def read_truth(index: int, truths: Path) -> dict[str, Any]:
    """The truth of a recording."""
    return dict(json.loads((truths / f"{index}.json").read_text(encoding="utf-8")))


def seal_cases(indices: list[int], salt: str, recordings: Path, held_out: Path, truths: Path) -> pd.DataFrame:
    """Seals of written recordings: ``index``, ``sha256``."""
    seals = [seal(salt, read_truth(i, truths), sealed_files(i, recordings, held_out)) for i in indices]
    return pd.DataFrame({"index": indices, "sha256": seals})


def check_seals(seals: pd.DataFrame, salt: str, recordings: Path, held_out: Path, truths: Path) -> None:
    """Refuse recordings whose seals are broken.

    Raises
    ------
    BrokenSealError
        With the index of the first.
    """
    for index, published in zip(seals["index"], seals["sha256"], strict=True):
        check_seal(int(index), published, salt, read_truth(index, truths), sealed_files(index, recordings, held_out))
