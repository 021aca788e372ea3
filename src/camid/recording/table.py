"""Columns of a file, by name, with the place of every row for messages."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from camid.errors import InputError, nearest_match
from camid.recording.cells import Cells, as_cells, as_floats
from camid.recording.units import unit_in_header, with_bracketed_unit

# Names that are listed where no column is like the one that is missing.
MOST_NAMES = 30


@dataclass(frozen=True)
class Table:
    """Columns of a file.

    Attributes
    ----------
    columns : mapping of str to one-dimensional array
        They need not be of one length.
    name : str
        For messages.
    where : callable
        Name of a row, counted from zero: ``line 7``.
    refused : dict of str to str
        Variables that are not columns, and why.
    hint : str
        What else to say where a column is missing.
    experiment : str or None
        What tells it from the other tables of its file.
    aliases : mapping of str to str
        Names in the file of columns that are asked for by another.
    single : mapping of str to float
        Single values beside the columns.
    notes : tuple of str
        What was taken from elsewhere than declared, one sentence each.
    written : callable
        Cell of a row, counted from zero, and a column by its name in the file, as it is written there; None where that
        is not known.
    """

    columns: Mapping[str, Any]
    name: str
    where: Callable[[int], str] = field(default=lambda row: f"row {row}")
    refused: dict[str, str] = field(default_factory=dict)
    hint: str = ""
    experiment: str | None = None
    aliases: Mapping[str, str] = field(default_factory=dict)
    single: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    written: Callable[[int, str], str | None] = field(default=lambda row, column: None)

    def quoted(self, row: int, column: str) -> str | None:
        """A cell as the file has it, for messages; None where that is not known."""
        found = self.find(column)
        return None if found is None else self.written(row, found)

    def renamed(self, aliases: Mapping[str, str]) -> Table:
        """The same table, in which columns are asked for by other names."""
        return replace(self, aliases=dict(aliases))

    def find(self, name: str) -> str | None:
        """Name in the file of a column: as it is asked for, without its unit, over it, or with points for strokes."""
        name = self.aliases.get(name, name)
        if name in self.columns:
            return name
        for other in (name.replace(".", "/"), with_bracketed_unit(name)):
            if other in self.columns:
                return other
        bare = [str(c) for c in self.columns if unit_in_header(str(c))[0] == name]
        return bare[0] if len(bare) == 1 else None

    def column(self, name: str, role: str | None = None) -> Cells:
        """A column by its name.

        Parameters
        ----------
        name : str
        role : {"time", "input", "output", "label"}, optional
            What it is asked for, for the columns that an error offers.

        Raises
        ------
        InputError
            If there is none; with the nearest match, and the columns that would do.
        """
        found = self.find(name)
        if found is not None:
            return as_cells(self.columns[found])
        name = self.aliases.get(name, name)
        if name in self.refused:
            raise InputError(
                f"'{name}' is {self.refused[name]}", where=self.name, hint="a column is a vector of real numbers"
            )
        raise InputError(f"no column '{name}'", where=self.name, hint=self._offered(name, role) + self.hint)

    def _offered(self, name: str, role: str | None) -> str:
        from camid.recording.nature import would_do

        if not self.columns:
            return "it has no columns"
        near = nearest_match(name, [str(c) for c in self.columns])
        numbers = {str(n): as_floats(as_cells(c)) for n, c in self.columns.items()}
        fitting = would_do(numbers, role)
        if not fitting:
            return near
        if not near.startswith("did you mean") and len(self.columns) > MOST_NAMES:
            near = f"{len(self.columns)} columns are here"
        as_role = {"label": " to tell experiments apart", None: ""}.get(role, f" as the {role}")
        counted = any(re.search(r"\[\d+\]$", n) for n in self.columns)
        return f"{near}; columns that would do{as_role}: {fitting}" + (
            "; columns of a matrix are counted from 0" if counted else ""
        )
