"""The folder of a diagnosis: diagnosis.json, improved.yaml, residuals.csv, report.html, and what was learned."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Mapping
from io import StringIO
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Diagnosis, Signals
from camid.diagnosis.laws.learned_effect_file import NAME, effect_file
from camid.diagnosis.report.beside import PageDrawnBeside
from camid.errors import InputError, need
from camid.simulation.file import simulation_text
from camid.writing import check_folder, without_infinities, write_whole

Array = NDArray[np.float64]

FILES = ("diagnosis.json", "improved.yaml", "residuals.csv", "report.html")
# All that may be written, and by what each is known to be camid's.
RESULTS = {
    FILES[0]: '"verdict":',
    FILES[1]: "improved by camid diagnose",
    FILES[2]: "residual_improved,equivalent_input",
    FILES[3]: "Made by camid",
    NAME: "camid diagnose",
}
RESIDUALS = (
    "recorded",
    "nominal",
    "refitted",
    "improved",
    "residual_refitted",
    "residual_improved",
    "equivalent_input",
    "fitted",
)

RECORDING = "recording"
# Of a table that becomes text.
ROWS_AT_ONCE = 10_000


def write_diagnosis(
    diagnosis: Diagnosis,
    folder: str | os.PathLike[str],
    *,
    report: bool = True,
    drawn_beside: PageDrawnBeside | None = None,
) -> list[Path]:
    """Write the files of a diagnosis into a folder, which is made if its parent is there; each whole or not at all.

    Everything is made before the first file is written, so that what goes wrong leaves the folder as it was.

    Parameters
    ----------
    diagnosis : Diagnosis
    folder : path
    report : bool
        Whether to draw report.html, too; if not, one of an earlier diagnosis in the folder is removed. The same holds
        for learned_effect.py where nothing was learned.
    drawn_beside : PageDrawnBeside, optional
        What draws it; this process where it is left out.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be written to, which says which files were written before, or holds a file of one of these
        names that camid did not write.
    """
    folder = Path(folder)
    check_folder(folder, RESULTS)
    if report:
        need("report.html", "plots", hint="or leave it out with report=False")
        drawn_beside = drawn_beside or PageDrawnBeside()
        drawn_beside.begin(diagnosis)
    contents = {
        FILES[0]: json.dumps(without_infinities(diagnosis.to_mapping()), indent=2, ensure_ascii=False) + "\n",
        FILES[1]: simulation_text(
            diagnosis.improved,
            f"improved by camid diagnose from {', '.join(diagnosis.recordings)}: {diagnosis.verdict_in_words}"
            + "".join(f"\nwith effects of your own: --effects {name}" for name in diagnosis.own_files),
        ),
        FILES[2]: _as_csv(residuals(diagnosis)),
    }
    if drawn_beside is not None and report:
        contents[FILES[3]] = drawn_beside.text()
    if (learned := effect_file(diagnosis)) is not None:
        contents[NAME] = learned
    written: list[Path] = []
    try:
        folder.mkdir(exist_ok=True)
        if not report:
            (folder / FILES[3]).unlink(missing_ok=True)
        for name, content in contents.items():
            # A name from a file system may hold bytes that are not text.
            data = content.encode("utf-8", errors="replace")
            write_whole(folder / name, lambda path, data=data: path.write_bytes(data))  # type: ignore[misc]
            written.append(folder / name)
        if NAME not in contents:  # of an earlier diagnosis
            (folder / NAME).unlink(missing_ok=True)
    except (OSError, InputError) as error:
        done = f"; written before: {', '.join(p.name for p in written)}" if written else ""
        problem = error.problem if isinstance(error, InputError) else f"cannot write ({error.strerror or error})"
        raise InputError(f"{problem}{done}", where=str(folder), hint="make room, or write elsewhere") from None
    return written


def residuals(diagnosis: Diagnosis) -> dict[str, NDArray[Any]]:
    """Columns of residuals.csv, each of shape (n,): one row per row of every recording.

    Of several recordings the first column, ``recording``, is the number of the row's one in ``diagnosis.recordings``,
    from 1.
    """
    every = [diagnosis.signals, *diagnosis.further_signals]
    tables = [_residuals_of(signals, diagnosis.improved.time_column) for signals in every]
    if len(tables) == 1:
        return tables[0]
    numbered = [
        {RECORDING: np.full(len(s.time), n), **t} for n, (s, t) in enumerate(zip(every, tables, strict=True), 1)
    ]
    return {name: np.concatenate([table[name] for table in numbered]) for name in numbered[0]}


def _residuals_of(signals: Signals, time: str) -> dict[str, NDArray[Any]]:
    return {
        # A time column that is called like one of the others keeps its place under a name of its own.
        time if time not in {*RESIDUALS, RECORDING} else f"{time} (time)": signals.time,
        "recorded": signals.recorded,
        "nominal": signals.nominal,
        "refitted": signals.refitted,
        "improved": signals.improved,
        "residual_refitted": signals.recorded - signals.refitted,
        "residual_improved": signals.recorded - signals.improved,
        "equivalent_input": signals.equivalent_input,
        "fitted": _kinds_of_rows(signals),
    }


def _kinds_of_rows(signals: Signals) -> NDArray[Any]:
    """1 where a row was fitted, 0 where it judges, and -1 where it is left out of both."""
    return np.where(signals.validates, 0, np.where(signals.fitted, 1, -1))


def _as_csv(columns: Mapping[str, NDArray[Any]]) -> str:
    """Text of a table; an unknown number is an empty cell, and the others have all of their digits."""
    text = StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    count = min((len(values) for values in columns.values()), default=0)
    for first in range(0, count, ROWS_AT_ONCE):  # every number becomes an object
        part = [values[first : first + ROWS_AT_ONCE] for values in columns.values()]
        writer.writerows(zip(*(_cells(values) for values in part), strict=True))
    return text.getvalue()


def _cells(values: NDArray[Any]) -> list[Any]:
    cells = values.tolist()
    return [None if isnan(cell) else cell for cell in cells] if np.isnan(values).any() else cells
