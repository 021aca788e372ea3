"""Recordings: tables with a time column, read strictly and written whole or not at all."""

from __future__ import annotations

import csv
import os
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
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
# Rounding of the times, as a share of the period, that still tells a missing row from a rounded one.
COARSEST_RESOLUTION = 0.5


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
        Seconds: the median step, or the slope of the times where rounding makes the steps differ.
    source : str
        Name for messages.
    period_uncertainty : float
        Seconds by which rounded times may have falsified the period; 0 where the steps are equal.
    """

    time: Array
    columns: dict[str, Array]
    period: float
    source: str
    period_uncertainty: float = 0.0

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
        _refuse_repeated([str(c) for c in table.columns], name)
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
    period, uncertainty = _period(time, time_column, name, path)
    return Recording(time, {c: v for c, v in columns.items() if c != time_column}, period, name, uncertainty)


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
            line, header = next(_rows(stream), (1, []))
        _refuse_repeated(header, f"{path}, line {line}")
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            return pd.read_csv(
                path,
                index_col=False,  # a comma at the end of each line must not shift the columns by one
                skipinitialspace=True,
                encoding="utf-8-sig",
                low_memory=False,
            )
    except InputError:
        raise
    except pd.errors.EmptyDataError:
        raise InputError("the file is empty", where=str(path), mend="it needs a header line and rows") from None
    except UnicodeDecodeError:
        raise InputError("this is no UTF-8 text", where=str(path), mend="a recording is CSV or Parquet") from None
    except pd.errors.ParserWarning:
        raise InputError(
            "the rows have more cells than the header",
            where=str(path),
            mend="put commas between the cells only, and a point into the numbers",
        ) from None
    except (pd.errors.ParserError, csv.Error) as error:
        detail = str(error).replace("Error tokenizing data. C error: ", "").strip()
        raise InputError(detail, where=str(path), mend="each row needs as many cells as the header") from None
    except (OSError, ValueError) as error:  # a Parquet file that is none, or no right to read
        detail = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"cannot be read ({detail})", where=str(path), mend="a recording is CSV or Parquet") from None


def _rows(stream: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    """Lines, and cells without the space around them, of what pandas takes for rows: blank lines are none."""
    reader = csv.reader(stream, skipinitialspace=True)
    for cells in reader:
        stripped = [c.strip() for c in cells]
        if len(stripped) > 1 or any(stripped):
            yield reader.line_num, stripped


def _refuse_repeated(names: Sequence[str], where: str) -> None:
    repeated = sorted({c for c in names if names.count(c) > 1 and c})
    if repeated:
        raise InputError(f"two columns are named '{repeated[0]}'", where=where, mend="rename one")


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
    with path.open(encoding="utf-8-sig", newline="") as stream, suppress(csv.Error):
        for line, _ in islice(_rows(stream), row + 1, None):  # the header is a row, too
            return f"line {line}"
    return f"row {row}"


def _numbers(table: pd.DataFrame, column: str, name: str, path: Path | None) -> Array:
    values = table[column]
    numbers = _as_floats(values)
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


def _as_floats(values: pd.Series) -> Array:
    """Numbers, and NaN for everything else: truth values and dates are no numbers."""
    import pandas as pd
    from pandas.api import types

    if types.is_object_dtype(values) or types.is_string_dtype(values):
        values = pd.to_numeric(values.mask(values.map(lambda cell: isinstance(cell, bool))), errors="coerce")
    if not types.is_numeric_dtype(values) or types.is_bool_dtype(values) or types.is_complex_dtype(values):
        return np.full(len(values), np.nan)
    return values.to_numpy(dtype=float, na_value=np.nan)


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


def _period(time: Array, column: str, name: str, path: Path | None) -> tuple[float, float]:
    """Sampling period and its uncertainty in seconds."""
    steps = np.diff(time)
    median = float(np.median(steps))
    deviation = np.abs(steps - median)
    if np.max(deviation) <= PERIOD_TOLERANCE * median:
        return median, 0.0
    # Rounded times, such as 0.033, 0.067, 0.100 at 30 frames/s: no step is exact, but all times lie along a straight
    # line within the rounding. Digits as coarse as the period would hide a missing row.
    rows = np.arange(len(time)) - 0.5 * (len(time) - 1)
    elapsed = time - time[0]
    slope = float(rows @ elapsed / (rows @ rows))
    spread = float(np.ptp(elapsed - slope * rows))
    for resolution in _resolutions(time):
        if resolution <= COARSEST_RESOLUTION * median and spread <= 1.5 * resolution:
            return slope, 2.0 * resolution / (len(time) - 1)
    row = int(np.argmax(deviation >= 0.5 * np.max(deviation))) + 1
    step = time[row] - time[row - 1]
    missing = round(step / median) - 1
    rows_missing = "a row seems" if missing == 1 else f"{missing} rows seem"
    reason = f"{rows_missing} to be missing" if step > 1.5 * median else "the sampling is irregular"
    raise InputError(
        f"a step of {step:.6g} s where the others have {median:.6g} s: {reason}",
        where=f"{name}, {_row_name(row, path)}, column '{column}'",
        mend="resample to a constant period or cut the recording there",
    )


def _resolutions(time: Array) -> list[float]:
    """Seconds to which the times may be rounded: by the floating point of large offsets, and by their decimals."""
    largest = float(np.max(np.abs(time)))
    rounding = 4.0 * float(np.spacing(largest))
    for decimals in range(16):
        if 10.0**-decimals <= rounding:
            break
        if np.max(np.abs(np.round(time, decimals) - time)) <= rounding:
            return [rounding, rounding + 10.0**-decimals]
    return [rounding]


def write_table(table: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write CSV or Parquet, whole or not at all."""

    def write(temporary: Path) -> None:
        if Path(path).suffix.lower() in {".parquet", ".pq"}:
            table.to_parquet(temporary, index=False)
        else:
            table.to_csv(temporary, index=False)

    write_whole(path, write)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Refuse what :func:`write_whole` could not write, before the work is done.

    Raises
    ------
    InputError
        If the folder does not exist, or the path is a folder, a device or a pipe.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise InputError("this is a folder", where=str(path), mend="name a file to write")
    if not target.parent.is_dir():
        raise InputError("no such folder", where=str(target.parent), mend="make it, or write somewhere else")
    if target.exists() and not target.is_file():
        raise InputError("this is a device or a pipe", where=str(path), mend="name a file to write")


def write_whole(path: str | os.PathLike[str], write: Callable[[Path], Any]) -> None:
    """Let ``write`` fill a temporary file beside ``path``, then rename it: nothing is ever half-written.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written to.
    """
    check_writable(path)
    target = Path(os.path.realpath(path))  # a link stays a link to the file that is written
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=".camid-", suffix=target.suffix)
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
