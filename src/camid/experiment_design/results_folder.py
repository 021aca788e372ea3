"""The folder of a design: input.csv, design.json and design.png."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camid.errors import InputError
from camid.experiment_design.columns import Columns
from camid.experiment_design.drawing import draw_design
from camid.experiment_design.limits import DIGITS
from camid.experiment_design.result import Design
from camid.writing import check_writable, without_infinities, write_whole

INPUT, DESIGN, PICTURE = "input.csv", "design.json", "design.png"
FILES = (INPUT, DESIGN, PICTURE)


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
        If the folder cannot be written to.
    """
    folder = Path(folder)
    check_folder(folder)
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


def input_text(design: Design) -> str:
    """The input as a table: time and input, in the units of the rig's columns."""
    columns, played = Columns.of(design.hypotheses[0].simulation), design.played
    time = columns.seconds.cells(np.asarray(played.period * np.arange(len(played.signal)), dtype=np.float64))
    signal = columns.inputs.cells(played.signal)
    reading = design.hypotheses[0].simulation.reading
    names = [columns.signal] if reading.period is not None else [columns.time, columns.signal]
    rows = [",".join(_quoted(name) for name in names)]
    for t, u in zip(time.tolist(), signal.tolist(), strict=True):
        rows.append(f"{u:.{DIGITS}g}" if len(names) == 1 else f"{t:.9g},{u:.{DIGITS}g}")
    return "\n".join(rows) + "\n"


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(c in name for c in ',"\n') else name


def check_folder(folder: Path, inputs: Sequence[Path] = ()) -> None:
    """Refuse, before the work is done, a folder that the design cannot go to.

    Raises
    ------
    InputError
        If it is a file or cannot be written to, its parent does not exist, or it would overwrite an input.
    """
    parent = folder.resolve().parent
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", where=str(folder), hint="name a folder for the design")
    if not parent.is_dir():
        raise InputError("no such folder", where=str(parent), hint="make it, or write elsewhere")
    if not os.access(folder if folder.exists() else parent, os.W_OK | os.X_OK):
        raise InputError("no permission to write here", where=str(folder), hint="write elsewhere")
    for target in (folder / name for name in FILES):
        if any(target.exists() and path.exists() and target.samefile(path) for path in inputs):
            raise InputError(
                f"{target.name} would overwrite what it is made from", where=str(target), hint="name another folder"
            )
        if folder.exists():
            check_writable(target)
