"""Recordings: tables with a time column, read strictly and written whole or not at all."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError, nearest_match

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

# Steps that differ from the period by less than this share are regular (design, section 1).
PERIOD_TOLERANCE = 1e-6
FEWEST_ROWS = 3


@dataclass(frozen=True)
class Recording:
    """A regularly sampled recording.

    Attributes
    ----------
    time : ndarray, shape (N,)
        Seconds, strictly increasing.
    columns : dict of str to ndarray, each of shape (N,)
        The columns that were asked for.
    period : float
        Seconds: the median step, or the mean step where the printed digits hide the difference.
    source : str
        Name for messages.
    """

    time: Array
    columns: dict[str, Array]
    period: float
    source: str

    def __len__(self) -> int:
        return len(self.time)


def read_recording(
    source: str | os.PathLike[str] | pd.DataFrame,
    time_column: str,
    required: Sequence[str],
    optional: Sequence[str] = (),
) -> Recording:
    """Read and check the columns of a recording.

    Parameters
    ----------
    source : path or DataFrame
        CSV (one header line, commas) or Parquet file, or a table.
    time_column : str
    required : sequence of str
        Columns that must be there.
    optional : sequence of str
        Columns that are taken where they are there.

    Raises
    ------
    InputError
        No such file or column, text or NaN in a cell, times that are unsorted, duplicated or irregular, too few rows.
    """
    import pandas as pd

    if isinstance(source, pd.DataFrame):
        table, name, path = source, "recording", None
    else:
        path = Path(source)
        table, name = _read_table(path), str(source)
    wanted = [time_column, *required]
    for column in wanted:
        if column not in table.columns:
            raise InputError(
                f"no column '{column}'",
                where=name,
                mend=nearest_match(column, [str(c) for c in table.columns]) + _separator_hint(table),
            )
    wanted += [c for c in optional if c in table.columns and c not in wanted]
    if len(table) < FEWEST_ROWS:
        raise InputError(f"{len(table)} rows", where=name, mend=f"a recording needs at least {FEWEST_ROWS}")
    columns = {c: _numbers(table, c, name, path) for c in dict.fromkeys(wanted)}
    time = columns[time_column]
    _check_order(time, time_column, name, path)
    period = _period(time, time_column, name, path)
    return Recording(time, {c: v for c, v in columns.items() if c != time_column}, period, name)


def _read_table(path: Path) -> pd.DataFrame:
    import pandas as pd

    if not path.exists():
        raise InputError("no such file", where=str(path), mend="check the path")
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), mend="name a CSV or Parquet file")
    try:
        if path.suffix.lower() in {".parquet", ".pq"}:
            return pd.read_parquet(path)
        with path.open(encoding="utf-8-sig", newline="") as stream:
            header = next(csv.reader(stream), [])
        repeated = sorted({c for c in header if header.count(c) > 1 and c})
        if repeated:
            raise InputError(f"two columns are named '{repeated[0]}'", where=f"{path}, line 1", mend="rename one")
        # index_col=False: a comma at the end of each line must not shift the columns by one.
        return pd.read_csv(path, index_col=False, skipinitialspace=True, encoding="utf-8-sig", low_memory=False)
    except InputError:
        raise
    except pd.errors.EmptyDataError:
        raise InputError("the file is empty", where=str(path), mend="it needs a header line and rows") from None
    except UnicodeDecodeError:
        raise InputError("this is no text file", where=str(path), mend="a recording is CSV or Parquet") from None
    except (pd.errors.ParserError, csv.Error) as error:
        detail = str(error).replace("Error tokenizing data. C error: ", "").strip()
        raise InputError(detail, where=str(path), mend="each row needs as many cells as the header") from None
    except (OSError, ValueError) as error:  # a Parquet file that is none, or no right to read
        detail = str(error).splitlines()[0]
        raise InputError(f"cannot be read ({detail})", where=str(path), mend="a recording is CSV or Parquet") from None


def _separator_hint(table: pd.DataFrame) -> str:
    if len(table.columns) == 1:
        for separator, word in ((";", "semicolons"), ("\t", "tabs")):
            if separator in str(table.columns[0]):
                return f" (the cells are separated by {word}; camid reads commas)"
    return ""


def _row_name(row: int, path: Path | None) -> str:
    """'line 7' of a CSV file, 'row 5' of any other table; blank lines count in a file."""
    if path is None or path.suffix.lower() in {".parquet", ".pq"}:
        return f"row {row}"
    with path.open(encoding="utf-8-sig", newline="") as stream:
        reader = csv.reader(stream)
        next(reader, None)
        rows = (reader.line_num for cells in reader if cells)
        for index, line in enumerate(rows):
            if index == row:
                return f"line {line}"
    return f"row {row}"


def _numbers(table: pd.DataFrame, column: str, name: str, path: Path | None) -> Array:
    import pandas as pd

    values = table[column]
    numeric = pd.to_numeric(values, errors="coerce") if not pd.api.types.is_bool_dtype(values) else None
    if numeric is None:
        bad, cell = 0, str(values.iloc[0])
    else:
        numbers = numeric.to_numpy(dtype=float, na_value=np.nan)
        wrong = np.flatnonzero(~np.isfinite(numbers))
        if wrong.size == 0:
            return np.ascontiguousarray(numbers)
        bad = int(wrong[0])
        cell = str(values.iloc[bad])
    shown = "an empty cell or NaN" if cell.strip().lower() in {"", "nan", "<na>", "none"} else f"'{cell}'"
    raise InputError(
        f"{shown} where a number should be",
        where=f"{name}, {_row_name(bad, path)}, column '{column}'",
        mend="fill in the number (with a decimal point) or remove the row",
    )


def _check_order(time: Array, column: str, name: str, path: Path | None) -> None:
    steps = np.diff(time)
    wrong = np.flatnonzero(steps <= 0.0)
    if wrong.size == 0:
        return
    row = int(wrong[0]) + 1
    where = f"{name}, {_row_name(row, path)}, column '{column}'"
    if steps[row - 1] == 0.0:
        raise InputError(f"the time {time[row]:.9g} s stands twice", where=where, mend="remove one of the rows")
    raise InputError(
        f"the time goes back from {time[row - 1]:.9g} s to {time[row]:.9g} s", where=where, mend="sort the rows by time"
    )


def _period(time: Array, column: str, name: str, path: Path | None) -> float:
    steps = np.diff(time)
    median = float(np.median(steps))
    # Large offsets, such as seconds since 1970, leave few digits to the steps.
    rounding = 4.0 * float(np.spacing(np.max(np.abs(time))))
    deviation = np.abs(steps - median)
    if np.max(deviation) <= PERIOD_TOLERANCE * median + rounding:
        return median
    resolution = _printed_resolution(path, column)
    mean = float((time[-1] - time[0]) / (len(time) - 1))
    if np.max(np.abs(steps - mean)) <= PERIOD_TOLERANCE * mean + rounding + 1.001 * resolution:
        # Rounded times: 0.033, 0.067, 0.100 at 30 frames/s. Their median step is off by the rounding, their mean is not.
        return mean
    row = int(np.argmax(deviation > PERIOD_TOLERANCE * median + rounding + 1.001 * resolution)) + 1
    step = time[row] - time[row - 1]
    missing = step / median
    reason = f"{round(missing) - 1} rows seem to be missing" if missing > 1.5 else "the sampling is irregular"
    raise InputError(
        f"a step of {step:.6g} s where the others have {median:.6g} s: {reason}",
        where=f"{name}, {_row_name(row, path)}, column '{column}'",
        mend="resample to a constant period or cut the recording there",
    )


def _printed_resolution(path: Path | None, column: str) -> float:
    """Smallest difference that the printed digits of a CSV column can show; 0 where it is not printed."""
    if path is None or path.suffix.lower() in {".parquet", ".pq"}:
        return 0.0
    import pandas as pd

    cells = pd.read_csv(
        path, index_col=False, usecols=[column], dtype=str, skipinitialspace=True, encoding="utf-8-sig"
    )[column].dropna()
    digits = -30
    for cell in cells.str.strip().str.lower():
        mantissa, _, exponent = cell.partition("e")
        digits = max(digits, len(mantissa.partition(".")[2]) - int(exponent or 0))
    return float(10.0**-digits)


def write_table(table: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write CSV or Parquet, whole or not at all."""

    def write(temporary: Path) -> None:
        if Path(path).suffix.lower() in {".parquet", ".pq"}:
            table.to_parquet(temporary, index=False)
        else:
            table.to_csv(temporary, index=False)

    write_whole(path, write)


def write_whole(path: str | os.PathLike[str], write: Callable[[Path], Any]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then rename it: nothing is ever half-written.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError("no such folder", where=str(target.parent), mend="make it, or write somewhere else")
    if target.is_dir():
        raise InputError("this is a folder", where=str(target), mend="name a file to write")
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=target.suffix)
    except OSError as error:
        raise InputError(f"cannot write ({error.strerror})", where=str(target.parent), mend="write elsewhere") from None
    os.close(handle)
    try:
        write(Path(temporary))
        # A temporary file is private; what it becomes is as readable as any other new file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
