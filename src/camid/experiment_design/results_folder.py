"""The folder of a design: input.csv, design.json and design.png."""

from __future__ import annotations

import csv
import json
import os
from io import StringIO
from pathlib import Path

import numpy as np

from camid.errors import InputError
from camid.experiment_design.columns import Columns
from camid.experiment_design.drawing import draw_design
from camid.experiment_design.limits import DIGITS
from camid.experiment_design.result import Design
from camid.writing import check_folder, without_infinities, write_whole

INPUT, DESIGN, PICTURE = "input.csv", "design.json", "design.png"
# All that may be written, and by what each is known to be camid's; an input and a picture say nothing of themselves.
FILES = {DESIGN: '"frame_rate":', INPUT: None, PICTURE: None}
# Columns of an input file: a time where the rig's files have one, and the input.
MOST_COLUMNS = 2


def write_design(design: Design, folder: str | os.PathLike[str], *, picture: bool = True) -> list[Path]:
    """Write the files of a design into a folder, which is made if its parent is there; each whole or not at all.

    Parameters
    ----------
    design : Design
    folder : path
    picture : bool
        Whether to draw design.png, too; if not, one of an earlier design in the folder is removed.

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds a file of one of these names that camid did not write.
    """
    folder = Path(folder)
    check_folder(folder, FILES)
    texts = {
        INPUT: input_text(design),
        DESIGN: json.dumps(without_infinities(design.to_mapping()), indent=2, ensure_ascii=False) + "\n",
    }
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write ({error.strerror})", where=str(folder), hint="write elsewhere") from None
    written = []
    for name, text in texts.items():
        data = text.encode("utf-8", errors="replace")
        write_whole(folder / name, lambda path, data=data: path.write_bytes(data))  # type: ignore[misc]
        written.append(folder / name)
    if picture:
        draw_design(design, folder / PICTURE)
        written.append(folder / PICTURE)
    else:
        (folder / PICTURE).unlink(missing_ok=True)
    return written


def write_input(design: Design, path: str | os.PathLike[str]) -> Path:
    """Write the input of a design alone, as the CSV that :func:`write_design` calls input.csv.

    Raises
    ------
    InputError
        If the file cannot be written to, or holds more than an input.
    """
    target = Path(path)
    refuse_other_tables(target)
    write_whole(target, lambda temporary: temporary.write_text(input_text(design), encoding="utf-8"))
    return target


def refuse_other_tables(path: Path) -> None:
    """Refuse to overwrite a file that has other columns than a time and an input, as a recording has.

    Raises
    ------
    InputError
        That says so.
    """
    if not path.is_file() or not path.stat().st_size:
        return
    try:
        with path.open(encoding="utf-8", errors="replace") as stream:
            columns = len(next(csv.reader(stream), []))
    except (OSError, csv.Error):  # whatever it is, it is no input
        columns = MOST_COLUMNS + 1
    if columns > MOST_COLUMNS:
        raise InputError(
            "this is a file with other columns than those of an input, and would be overwritten",
            where=str(path),
            hint="move or remove it, or name another file",
        )


def input_text(design: Design) -> str:
    """The input as a table: time and input, in the units of the rig's columns."""
    columns, played = Columns.of(design.hypotheses[0].simulation), design.played
    time = columns.seconds.cells(np.asarray(played.period * np.arange(len(played.signal)), dtype=np.float64))
    signal = columns.inputs.cells(played.signal) + 0.0  # a zero has no sign
    reading = design.hypotheses[0].simulation.reading
    alone = reading.period is not None
    text = StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([columns.signal] if alone else [columns.time, columns.signal])
    for t, u in zip(time.tolist(), signal.tolist(), strict=True):
        writer.writerow([f"{u:.{DIGITS}g}"] if alone else [f"{t:.9g}", f"{u:.{DIGITS}g}"])
    return text.getvalue()
