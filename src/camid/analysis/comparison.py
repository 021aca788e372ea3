"""Recorded and simulated outputs side by side, with the fit in per cent.

The fit is 100 (1 − ‖y − ŷ‖/‖y − mean y‖) (Ljung, System Identification Toolbox, ``compare``): 100 % is a perfect
model, 0 % one that follows no better than the mean, and there is no lower end. It is 100 (1 − NRMSE).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from camid.analysis.view import ShortTable, View, common_mapping
from camid.simulation.declared_units import IN_U_AND_Y, SignalUnit

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

OUTPUT, CONTROL = "output", "control"


def fit_percent(recorded: Array, simulated: Array) -> float | None:
    """Fit of a simulated to a recorded signal in per cent; None where the recorded one does not change.

    Parameters
    ----------
    recorded, simulated : ndarray, shape (N,)
        Rows without a recorded value (NaN) do not count.
    """
    known = np.isfinite(recorded)
    if not known.any():
        return None
    size = float(np.max(np.abs(recorded[known]))) or 1.0  # squares must not overflow
    y, error = recorded[known] / size, (recorded[known] - simulated[known]) / size
    spread = float(np.linalg.norm(y - np.mean(y)))
    # What is left of a constant is rounding.
    if spread <= 1e-12 * float(np.linalg.norm(y)):
        return None
    with np.errstate(over="ignore"):
        return 100.0 * (1.0 - float(np.linalg.norm(error)) / spread)


@dataclass(frozen=True)
class ComparedSignal:
    """A recorded signal, and what models make of it.

    Attributes
    ----------
    kind : {"output", "control"}
        The control is what the controller of a closed loop puts out.
    symbol : str
        Its column.
    experiment : str or None
        What tells the experiment from the others in its file.
    time, recorded : ndarray, shape (N,)
    simulated : dict of str to ndarray, each of shape (N,)
        By model.
    compared : ndarray of bool, shape (N,)
        Rows that count: not those that the simulation says to leave out.
    held_out : ndarray of bool, shape (N,)
        Rows that were not fitted.
    unit : SignalUnit
        What people read it in; the values are in SI units.
    """

    kind: str
    symbol: str
    experiment: str | None
    time: Array
    recorded: Array
    simulated: Mapping[str, Array]
    compared: NDArray[np.bool_]
    held_out: NDArray[np.bool_]
    unit: SignalUnit = IN_U_AND_Y.output

    def in_declared_unit(self) -> ComparedSignal:
        """The same with values as people read them."""
        factor = self.unit.factor
        simulated = {name: values / factor for name, values in self.simulated.items()}
        return replace(self, recorded=self.recorded / factor, simulated=simulated)

    def fit_text(self, model: str) -> str:
        """Fits in words."""
        found = self.fits(model)
        held = (self.held_out & self.compared).any()
        return percent(found["fit"]) + (f", held out {percent(found['fit_held_out'])}" if held else "")

    def fits(self, model: str) -> dict[str, float | None]:
        """Fit in per cent on all rows that count, on those that were fitted, and on those that were not."""
        fitted, held_out = self.compared & ~self.held_out, self.compared & self.held_out
        rows = {"fit": self.compared, "fit_fitted": fitted, "fit_held_out": held_out}
        known = {"fit"} if not held_out.any() else set(rows)
        return {
            name: fit_percent(self.recorded[part], self.simulated[model][part]) if name in known else None
            for name, part in rows.items()
        }


@dataclass(frozen=True, repr=False)
class Comparison(View):
    """What ``camid.compare`` returns.

    Attributes
    ----------
    signals : list of ComparedSignal
        A file with several experiments has one for each; a closed loop has one for its control, too.
    models : tuple of str
    source : str
        The recording.
    zoom : tuple of float or None
        Start and end in seconds of what the picture shows.
    remarks : tuple of str
    """

    signals: list[ComparedSignal]
    models: tuple[str, ...]
    source: str
    zoom: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()

    columns: ClassVar[tuple[str, ...]] = ("experiment", "signal", "time", "held_out", "recorded")

    @property
    def fits(self) -> pd.DataFrame:
        """A row a model and signal: ``model``, ``experiment``, ``signal``, ``fit``, ``fit_fitted``, ``fit_held_out``.

        In per cent; NaN where a part of the rows does not exist or does not change.
        """
        import pandas as pd

        rows = [
            {"model": model, "experiment": s.experiment, "signal": s.symbol, **s.fits(model)}
            for s in self.signals
            for model in self.models
            if model in s.simulated
        ]
        return pd.DataFrame(rows).astype(dict.fromkeys(("fit", "fit_fitted", "fit_held_out"), float))

    @property
    def numbers(self) -> pd.DataFrame:
        """A row a recorded row and signal.

        ``experiment``, ``signal``, ``time`` (s), ``held_out`` (0 or 1), ``recorded``, and a column of what each model
        simulates, in SI units.
        """
        import pandas as pd

        parts = [
            pd.DataFrame(
                {
                    "experiment": s.experiment or "",
                    "signal": s.symbol,
                    "time": s.time,
                    "held_out": s.held_out.astype(int),
                    "recorded": s.recorded,
                    **s.simulated,
                }
            )
            for s in self.signals
        ]
        return pd.concat(parts, ignore_index=True)

    @property
    def has_held_out(self) -> bool:
        """Whether some rows were not fitted."""
        return any((s.held_out & s.compared).any() for s in self.signals)

    def short_table(self) -> ShortTable:
        """The fits."""
        several, signals = len({s.experiment for s in self.signals}) > 1, len({s.symbol for s in self.signals}) > 1
        headings = ["model", *(["experiment"] if several else []), *(["signal"] if signals else []), "fit"]
        headings += ["fitted rows", "held-out rows"] if self.has_held_out else []
        rows = []
        for row in self.fits.to_dict("records"):
            labels = [row["model"]]
            labels += [row["experiment"] or ""] if several else []
            labels += [row["signal"]] if signals else []
            parts = ["fit", *(["fit_fitted", "fit_held_out"] if self.has_held_out else [])]
            rows.append((*map(str, labels), *(percent(row[part]) for part in parts)))
        return ShortTable(f"Fit to {self.source}", tuple(headings), rows)

    def said(self) -> tuple[str, ...]:
        """What was done to the rows, and what is shown."""
        return self.remarks

    def to_mapping(self) -> dict[str, Any]:
        """Content of ``--json``."""
        rows = [
            {str(k): None if isinstance(v, float) and not np.isfinite(v) else v for k, v in row.items()}
            for row in self.fits.to_dict("records")
        ]
        held = [s.time[s.held_out & s.compared] for s in self.signals if (s.held_out & s.compared).any()]
        span = {"start": float(min(t[0] for t in held)), "end": float(max(t[-1] for t in held))} if held else None
        rows_compared = int(sum(np.count_nonzero(s.compared) for s in self.signals))
        units = {signal.symbol: signal.unit.to_mapping() for signal in self.signals}
        return common_mapping(
            self, recording=self.source, unit="%", units=units, held_out=span, rows_compared=rows_compared, fits=rows
        )

    def _draw(self) -> Figure:
        from camid.drawing.comparison import draw

        return draw(self)


def percent(value: float | None) -> str:
    """A fit with two decimals, as the toolbox of Ljung prints it; a dash where there is none."""
    if value is None or not np.isfinite(value):
        return "–"
    return f"{value:.2f}\u00a0%".replace("-", "−") if abs(value) < 1e5 else f"{value:.3g}\u00a0%".replace("-", "−")


def rows_between(time: Array, spans: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Rows within one of some spans of time, ends included."""
    found = np.zeros(len(time), bool)
    for start, end in spans:
        found |= (time >= start) & (time <= end)
    return found
