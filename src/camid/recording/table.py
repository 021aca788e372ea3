"""Columns of a file, by name, with the place of every row for messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from camid.errors import InputError, nearest_match

if TYPE_CHECKING:
    import pandas as pd


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
    """

    columns: Mapping[str, Any]
    name: str
    where: Callable[[int], str] = field(default=lambda row: f"row {row}")
    refused: dict[str, str] = field(default_factory=dict)
    hint: str = ""
    experiment: str | None = None

    def column(self, name: str) -> pd.Series:
        """A column by its name.

        Raises
        ------
        InputError
            If there is none; with the nearest match.
        """
        import pandas as pd

        if name in self.columns:
            return pd.Series(self.columns[name]).reset_index(drop=True)
        if name in self.refused:
            raise InputError(
                f"'{name}' is {self.refused[name]}", where=self.name, hint="a column is a vector of real numbers"
            )
        known = nearest_match(name, [str(c) for c in self.columns]) if self.columns else "it has no columns"
        raise InputError(f"no column '{name}'", where=self.name, hint=f"{known}{self.hint}")
