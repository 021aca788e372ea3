"""What every result of this package is: numbers, a short table, remarks and a picture."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from camid.errors import InputError, need
from camid.writing import check_writable, without_infinities, write_table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PICTURES = (".png", ".svg", ".pdf")
TABLES = (".csv", ".parquet")
# Rows of the short table that a repr shows.
ROWS_OF_REPR = 6


@dataclass(frozen=True)
class ShortTable:
    """What the terminal and a notebook show.

    Attributes
    ----------
    title : str
    headings : tuple of str
        The first ``texts`` columns are text, the others are numbers.
    rows : sequence of tuple of str
        A cell may have several lines.
    """

    title: str
    headings: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    texts: int = 1


class View(ABC):
    """Numbers, a short table, remarks and a picture.

    Attributes
    ----------
    columns : tuple of str
        First columns of :attr:`numbers`, by which a file that camid wrote before is known.
    """

    columns: ClassVar[tuple[str, ...]]

    @property
    @abstractmethod
    def numbers(self) -> pd.DataFrame:
        """What the picture draws, in SI units and those of the columns."""

    @abstractmethod
    def short_table(self) -> ShortTable:
        """The numbers that people look for."""

    @abstractmethod
    def said(self) -> tuple[str, ...]:
        """What the picture does not show, a sentence each."""

    @abstractmethod
    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""

    @abstractmethod
    def _draw(self) -> Figure:
        """The picture, within the project's look."""

    def figure(self) -> Figure:
        """The picture as a figure of matplotlib, made without pyplot: nothing of the caller's settings changes.

        Raises
        ------
        InputError
            If matplotlib is not installed.
        """
        need("a picture", "plots", hint="the numbers are there without it")
        from camid import plotting

        with plotting.look():
            return self._draw()

    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the picture, and the numbers as CSV beside it; of a name that ends with .csv or .parquet the numbers.

        Returns
        -------
        list of Path
            What was written.

        Raises
        ------
        InputError
            If it cannot be written, or a CSV of something else is there.
        """
        files = files_of(path)
        refuse_foreign(files[-1], self.columns)
        picture = self._picture(files[0]) if len(files) > 1 else None
        if picture is not None:
            from camid.writing import write_whole

            write_whole(files[0], lambda temporary: temporary.write_bytes(picture))
        write_table(self.numbers, files[-1])
        return files

    def _picture(self, path: Path) -> bytes:
        from camid import plotting

        return plotting.rendered(self.figure(), path.suffix[1:].lower())

    def __repr__(self) -> str:
        table = self.short_table()
        rows = ["; ".join(row).replace("\n", ", ") for row in table.rows[:ROWS_OF_REPR]]
        more = [] if len(table.rows) <= ROWS_OF_REPR else [f"… {len(table.rows) - ROWS_OF_REPR} more"]
        head = f"<{type(self).__name__}: {'; '.join(table.headings)}"
        return "\n".join([head, *(f"  {row}" for row in rows + more)]) + ">"

    def _repr_html_(self) -> str:
        """Picture (where matplotlib is there), table and remarks, for a notebook."""
        from importlib.util import find_spec

        from camid import plotting

        drawn = plotting.image_element(self.figure()) if find_spec("matplotlib") is not None else ""
        said = "".join(f"<li>{escape(sentence)}</li>" for sentence in self.said())
        return f"<div>{drawn}{html_table(self.short_table())}{f'<ul>{said}</ul>' if said else ''}</div>"


def html_table(table: ShortTable) -> str:
    """The table as HTML, its cells escaped."""
    import pandas as pd

    body = pd.DataFrame(table.rows, columns=list(table.headings)).to_html(index=False, border=0)
    lines = body.replace("\\n", "<br>")  # a cell of several lines, as pandas writes it
    return f"<p><b>{escape(table.title)}</b></p>{lines}"


def files_of(path: str | os.PathLike[str]) -> list[Path]:
    """The files that a name stands for: a picture and the numbers beside it, or the numbers alone.

    Raises
    ------
    InputError
        If it ends otherwise, or cannot be written.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in (*PICTURES, *TABLES):
        raise InputError(
            f"'{target.suffix}' is no kind of picture" if target.suffix else "this name has no ending",
            where=str(path),
            hint=f"end it with {', '.join(PICTURES)}, or with .csv for the numbers alone",
        )
    files = [target] if suffix in TABLES else [target, target.with_suffix(".csv")]
    for file in files:
        check_writable(file)
    return files


def refuse_foreign(path: Path, columns: tuple[str, ...]) -> None:
    """Refuse to put numbers over a CSV of something else: a recording may bear the name of the picture."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return
    with path.open("rb") as stream:
        first = stream.readline(4096).decode("utf-8", errors="replace").strip()
    if tuple(first.split(",")[: len(columns)]) != columns:
        raise InputError(
            "this file holds something else than the numbers of such a picture",
            where=str(path),
            hint="remove it, or give the picture another name",
        )


def common_mapping(view: View, **content: Any) -> dict[str, Any]:
    """Content of ``--json`` with its version and the remarks, without infinities."""
    found = {"schema": 1, **content, "remarks": list(view.said())}
    return {key: without_infinities(value) for key, value in found.items()}
