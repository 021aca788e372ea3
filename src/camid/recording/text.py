"""Tables from text files: comments, separator, decimal mark and header line detected or as declared."""

from __future__ import annotations

import csv
import re
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from io import StringIO
from itertools import islice, zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.size_limits import LONGEST_LINE, refuse_long_lines, refuse_many_columns
from camid.recording.units import is_unit, unit_in_header, with_bracketed_unit

if TYPE_CHECKING:
    import pandas as pd

COMMENTS = ("#", "%")
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "blanks"}
# A cell may be as long as a line; Python's own limit is lower, and its error is none of ours.
csv.field_size_limit(LONGEST_LINE)
# Lines that are looked at to find the separator.
SAMPLE = 200
UTF_16 = (b"\xff\xfe", b"\xfe\xff")
NOT_TEXT = "a recording is CSV, Parquet, MAT or HDF5"


@dataclass(frozen=True)
class Text:
    """A text file, taken apart.

    Attributes
    ----------
    body : str
        From the header line (or the first row) on.
    skipped : int
        Lines before it.
    separator, decimal : str
    names : tuple of str
        Those in the last comment before the rows, as numpy.savetxt writes a header; empty if it does not name columns.
    units : int
        Lines of units between the names and the rows.
    """

    body: str
    skipped: int
    separator: str
    decimal: str
    names: tuple[str, ...] = ()
    units: int = 0

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line in the file and cells of what counts as a row: blank lines are none."""
        for line, cells in _rows(StringIO(self.body, newline=""), self.separator):
            yield line + self.skipped, cells


def read_text(data: bytes, name: str, wanted: Sequence[str], reading: Reading) -> tuple[dict[str, Any], Text]:
    """Columns of a text file by their names: arrays of floats or, where a cell is no number, Series as they are.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        For messages.
    wanted : sequence of str
        Columns that will be asked for.
    reading : Reading

    Raises
    ------
    InputError
        If this is not text or not a table, or what was declared about it is wrong.
    """
    text = _taken_apart(_decoded(data, name), name, reading)
    (line, first), (_, second) = [*islice(text.rows(), 2), (1, []), (1, [])][:2]
    if not first:
        raise InputError("the file is empty", where=name, hint="it needs a header line and rows")
    refuse_many_columns(len(first), f"{name}, line {line}")
    names = list(reading.columns)
    if reading.header:
        numeric = all(_is_number(c, text.decimal) for c in first if c)
        if not (numeric and _names_some(text.names, wanted)):
            text = replace(text, names=())
        if text.names:
            _refuse_repeated(text.names, f"{name}, line {text.skipped}")
            names = [*text.names, *([""] * (len(first) - len(text.names)))]
        elif numeric and not set(wanted) <= set(first):
            raise InputError(
                "the first line holds numbers, not names",
                where=f"{name}, line {line}",
                hint="say header: false and columns: [names in order] under recording in the simulation",
            )
        else:
            _refuse_repeated(first, f"{name}, line {line}")
            if _are_units(second):
                text = replace(text, units=1)
                units = [u.strip("[]() ") for u in second]
                names = [f"{n} [{u}]" if is_unit(u) else n for n, u in zip_longest(first, units, fillvalue="")]
    else:
        cells = first[:-1] if first[-1] == "" and len(first) == len(names) + 1 else first
        if not any(_is_number(c, text.decimal) for c in cells):
            raise InputError(
                f"a line of names ({', '.join(cells)}) in a file declared to have none",
                where=f"{name}, line {line}",
                hint="remove header: false and columns under recording",
            )
        if len(cells) != len(names):
            raise InputError(
                f"{len(cells)} cells, and {len(names)} columns are named",
                where=f"{name}, line {line}",
                hint=f"name all under {reading.where}.columns, in order",
            )
        names += [""] * (len(first) - len(cells))
    values = _numbers(text, len(names or first), _lines_before(text) if text.units or not names else 0)
    if values is not None and (names or all(first)):
        return {with_bracketed_unit(n).strip(): values[:, i] for i, n in enumerate(names or first)}, text
    frame = _parsed(text, name, names).rename(columns=with_bracketed_unit)
    return _named(frame, [] if names else first), text


def _named(frame: pd.DataFrame, first: Sequence[str]) -> dict[str, Any]:
    """Columns by name; what has no name in the first line is one where it holds something, by a name of ours."""
    columns = {}
    for i, column in enumerate(map(str, frame.columns)):
        nameless = i < len(first) and not first[i]
        if not (nameless and frame.iloc[:, i].isna().all()):
            columns[f"column{i + 1}" if nameless else column.strip()] = frame.iloc[:, i]
    return columns


def names_needed(data: bytes, name: str) -> int:
    """Number of columns of a text file that has no names for them; 0 if it has."""
    text = _taken_apart(_decoded(data, name), name, Reading())
    _, first = next(text.rows(), (1, []))
    cells = first[:-1] if len(first) > 1 and first[-1] == "" else first
    return len(cells) if cells and not text.names and all(_is_number(c, text.decimal) for c in cells if c) else 0


def _names_some(names: Sequence[str], wanted: Sequence[str]) -> bool:
    """Whether names are those of columns: one of those asked for, if any are, is among them."""
    plain = {*names, *(unit_in_header(with_bracketed_unit(n))[0] for n in names)}
    return bool(names) and (not wanted or not plain.isdisjoint(wanted))


def _numbers(text: Text, columns: int, before: int) -> NDArray[np.float64] | None:
    """Rows of a text that holds nothing but numbers, shape (n, columns), after some lines; None where it holds more.

    Whatever is not that plain is left to pandas, which takes longer to import than this takes.
    """
    if text.decimal not in {".", text.separator}:
        text = replace(text, body=text.body.replace(text.decimal, "."))
    separator = None if text.separator == " " else text.separator
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # no rows at all
            values = np.loadtxt(StringIO(text.body), delimiter=separator, skiprows=before, comments=None, ndmin=2)
    except (ValueError, UserWarning):
        return None
    return values if values.shape[1] == columns else None


def _parsed(text: Text, name: str, names: list[str]) -> pd.DataFrame:
    import pandas as pd

    twice = next((n for i, n in enumerate(names) if n in names[:i]), None)
    if twice is not None:
        called = f"called '{twice}'" if twice else "without a name"
        raise InputError(f"several columns are {called}", where=name, hint="give each column a name of its own")
    # To the last digit, as loadtxt; from pandas 3.1 on it does so by itself, and warns of being asked to.
    newer = tuple(int(part) for part in pd.__version__.split(".")[:2]) >= (3, 1)
    exactly: Any = {} if newer else {"float_precision": "round_trip"}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            frame = pd.read_csv(
                StringIO(text.body, newline=""),
                sep=r"\s+" if text.separator == " " else text.separator,
                decimal=text.decimal if text.decimal != text.separator else ".",
                header=None if names else 0,
                names=names or None,
                skiprows=_lines_before(text) if text.units else 0,
                index_col=False,  # a separator at the end of each line must not shift the columns by one
                skipinitialspace=True,
                low_memory=False,
                **exactly,
            )
    except pd.errors.ParserWarning:
        raise InputError(
            "the rows have more cells than the header",
            where=name,
            hint=f"put {_word(text.separator)} between cells only, and use a decimal point",
        ) from None
    except (pd.errors.ParserError, csv.Error) as error:
        detail = str(error).replace("Error tokenizing data. C error: ", "").strip()
        # pandas counts the lines that it was given.
        detail = re.sub(r"(?<=in line )\d+", lambda found: str(int(found[0]) + text.skipped), detail)
        raise InputError(detail, where=name, hint="each row needs as many cells as the header") from None
    if text.decimal == text.separator:  # numbers in quotes, each with a decimal comma
        for column in frame.select_dtypes(include=["object", "string"]):
            frame[column] = frame[column].str.replace(text.decimal, ".")
    return frame


def line_of(text: Text, row: int, *, header: bool) -> str:
    """Line of a row of the table, counted from zero, in the file: 'line 7'."""
    before = int(header and not text.names) + text.units
    with suppress(csv.Error):
        for line, _ in islice(text.rows(), row + before, None):
            return f"line {line}"
    return f"row {row}"


def cell_of(text: Text, row: int, column: int, *, header: bool) -> str | None:
    """Cell of a row and a column of the table, counted from zero, as it is written; None where it is not found."""
    before = int(header and not text.names) + text.units
    with suppress(csv.Error, IndexError):
        for _, cells in islice(text.rows(), row + before, None):
            return cells[column] or None
    return None


def _lines_before(text: Text) -> int:
    """Lines of the body up to the one with the units."""
    return next(islice(text.rows(), text.units, None))[0] - text.skipped


def _are_units(cells: Sequence[str]) -> bool:
    """Whether a line under the names holds units, such as ``s, V, mm``; a dash or nothing stands for none."""
    given = [c.strip("[]() ") for c in cells if c.strip("[]() ") not in {"", "-"}]
    return (
        bool(given)
        and all(is_unit(c) for c in given if not _is_number(c, "."))
        and not any(_is_number(c, ".") for c in given)
    )


def _decoded(data: bytes, name: str) -> str:
    """Text of a file: UTF-8, marked UTF-16, or Latin-1 in the lines before the numbers (µ and ° of older programs)."""
    if data.startswith(UTF_16):  # as spreadsheets call Unicode text; its first two bytes tell the order of the others
        with suppress(UnicodeDecodeError):
            return data.decode("utf-16")
    if b"\0" in data:
        hint = f"{NOT_TEXT}; UTF-16 needs its first mark, so save it as UTF-8"
        raise InputError("this is not UTF-8 text", where=name, hint=hint)
    with suppress(UnicodeDecodeError):
        return data.decode("utf-8-sig")
    head, rest = [], data
    while rest:
        line, end, rest = rest.partition(b"\n")
        head.append((line + end).decode("latin-1"))
        if line.strip() and not line.lstrip().startswith(tuple(c.encode() for c in COMMENTS)):
            break
    try:
        body = rest.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError("this is not UTF-8 text", where=name, hint=NOT_TEXT) from None
    if not all(c.isprintable() or c.isspace() for c in "".join(head)):
        raise InputError("this is not UTF-8 text", where=name, hint=NOT_TEXT)
    return "".join(head) + body


def _taken_apart(content: str, name: str, reading: Reading) -> Text:
    refuse_long_lines(content, name)
    declared, comment = reading.separator, ""
    position, skipped = 0, 0
    while position < len(content):
        end = content.find("\n", position) + 1 or len(content)
        line = content[position:end].strip()
        # A first line such as sep=; tells a spreadsheet what the separator is.
        directive = re.fullmatch(r'"?sep=(.)"?', content[position:end].strip("\r\n"), re.IGNORECASE)
        if directive and declared is None:
            declared = directive[1]
        elif line and not line.startswith(COMMENTS):
            break
        comment = line.lstrip("#% ") if line else comment
        position, skipped = end, skipped + 1
    body = content[position:]
    separator = declared or _separator(body, skipped, name)
    if reading.header and (titles := _title_lines(body, separator)):
        body, skipped = "".join(body.splitlines(keepends=True)[titles:]), skipped + titles
    decimal = reading.decimal or _decimal(body, separator)
    return Text(
        body, skipped, separator, decimal, _names_in_comment(comment, body, separator) if reading.header else ()
    )


def _title_lines(body: str, separator: str) -> int:
    """Lines of titles and remarks above the line of names, which have fewer cells than that, as in a spreadsheet."""
    rows: list[tuple[int, int]] = []  # last line and number of cells that are filled
    units = False
    with suppress(csv.Error):
        for line, cells in islice(_rows(StringIO(body, newline=""), separator), SAMPLE):
            filled = [c for c in cells if c]
            if len(filled) > 1 and all(_is_number(c, ",") or _is_number(c, ".") for c in filled):
                names = len(rows) - 1 - units
                above = rows[: max(names, 0)]
                named = names > 0 and rows[names][1] > 1
                return above[-1][0] if named and all(count < rows[names][1] for _, count in above) else 0
            units = _are_units(cells) and len(rows) > 0
            rows.append((line, len(filled)))
    return 0


def _names_in_comment(comment: str, body: str, separator: str) -> tuple[str, ...]:
    """Names in a comment such as ``# u, th``, if it has as many as the rows have cells and none is a number.

    The comment need not have the separator of the rows: numpy.savetxt puts blanks between numbers where it is not told
    otherwise.
    """
    _, first = next(_rows(StringIO(body, newline=""), separator), (1, []))
    count = len(first) - (1 if len(first) > 1 and first[-1] == "" else 0)
    for candidate in dict.fromkeys((separator, ",", ";", "\t", " ")):
        _, cells = next(_rows([comment.replace("\r", " ")], candidate), (1, []))
        if len(cells) == count and all(c and c[-1] not in ",;" and not _is_number(c, ".") for c in cells):
            return tuple(cells)
    return ()


def _rows(stream: Iterable[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Lines, and cells without the space around them."""
    if separator == " ":  # any number of blanks or tabs
        stream = (re.sub(r"[ \t]+", " ", line.strip(" \t")) for line in stream)
    reader = csv.reader(stream, delimiter=separator, skipinitialspace=separator != " ")
    for cells in reader:
        stripped = [c.strip() for c in cells]
        if len(stripped) > 1 or any(stripped):
            yield reader.line_num, stripped


def _separator(body: str, skipped: int, name: str) -> str:
    """The separator that every line has; of several the one that leaves the others inside of the cells."""
    sample = list(islice(StringIO(body, newline=""), SAMPLE))
    found: dict[str, dict[int, int]] = {}
    for separator in (";", "\t", ",", " "):
        with suppress(csv.Error):
            found[separator] = {line: len(cells) for line, cells in _rows(sample, separator)}
    if "," in found and " " in found and _blanks_between_decimal_commas(sample):
        del found[","]

    def share(separator: str) -> float:
        counts = found[separator].values()
        return sum(c > 1 for c in counts) / len(counts) if counts else 0.0

    best = max(found, key=share, default=",")
    if not found or share(best) == 0.0:
        return ","
    for line, count in found[best].items():
        for other in (c for c in ",;\t" if c != best and c in found):
            if count < 2 <= found[other].get(line, 0):
                raise InputError(
                    f"{_word(other)} between the cells, where most lines have {_word(best)}",
                    where=f"{name}, line {line + skipped}",
                    hint="use one separator throughout",
                )
    return best


def _blanks_between_decimal_commas(sample: Sequence[str]) -> bool:
    """Whether rows such as ``0,1 2,5`` hold decimal commas: between commas there would be two numbers in a cell."""
    rows = [cells for _, cells in _rows(sample, ",")][1:] or [cells for _, cells in _rows(sample, ",")]
    return all(any(len(c.split()) > 1 and all(_is_number(n, ".") for n in c.split()) for c in r) for r in rows)


def _decimal(body: str, separator: str) -> str:
    """A comma where numbers hold commas and none holds a point; between commas it would be a separator."""
    if separator == ",":
        return "."
    edge = r"[\s\"]" if separator == " " else rf"[{re.escape(separator)}\n\"]"
    cell = rf"(?:^|{edge})[ ]*[-+]?\d*{{}}\d+(?:[eEdD][-+]?\d+)?[ \r]*(?={edge}|$)"
    with_comma, with_point = (re.compile(cell.format(mark)) for mark in (",", r"\."))
    return "," if with_comma.search(body) and not with_point.search(body) else "."


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _word(separator: str) -> str:
    return SEPARATORS.get(separator, f"'{separator}'")


def _refuse_repeated(names: Sequence[str], where: str) -> None:
    repeated = sorted(c for c, count in Counter(names).items() if count > 1 and c)
    if repeated:
        raise InputError(f"two columns are named '{repeated[0]}'", where=where, hint="rename one")
