"""What the commands print for people."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from camid.number_text import percentage, plain, probability, with_deviation

if TYPE_CHECKING:
    from camid.commands.join import Joined
    from camid.identification.identification import Identification
    from camid.identification.order_selection import OrderSelection


def print_identification(result: Identification, written: list[Path]) -> None:
    """Table of coefficients and characteristics, fit and residual test."""
    from rich.console import Console
    from rich.table import Table

    model = result.simulation
    console = Console(highlight=False)
    table = Table(title="Identified plant", title_justify="left")
    table.add_column("quantity")
    table.add_column("value ± standard deviation", justify="right")
    table.add_column("unit")
    for group in result.quantities():
        for name, value, deviation, unit in group:
            table.add_row(name, with_deviation(value, deviation), unit)
        table.add_section()
    console.print(table)
    if explained := model.units.explained:
        console.print(f"in units: {', '.join(explained)}", soft_wrap=True)
    held = "free decay" if model.input_column is None else f"input {model.hold}"
    sensor = "instant sensor" if model.sensor == "instant" else f"camera, exposure {_milliseconds(model.exposure)}"
    console.print(
        f"fitted to {result.rows_fitted} samples, period {_milliseconds(result.period)}; {held}; {sensor}, "
        f"latency {_milliseconds(model.known_latency)}; initial state: {model.initial_state}",
        soft_wrap=True,
    )
    validation = (
        "" if result.nrmse_validation is None else f", {percentage(result.nrmse_validation)} on validation rows"
    )
    console.print(
        f"residual: {percentage(result.nrmse)} of the output's standard deviation{validation} "
        f"({'converged' if result.converged else 'not converged'})",
        soft_wrap=True,
    )
    if result.residual_analysis is not None:
        console.print(result.residual_analysis.summary(), soft_wrap=True)
    for path in written:
        console.print(f"written to {path}", soft_wrap=True)


def _milliseconds(seconds: float | None) -> str:
    return plain(1e3 * (seconds or 0.0), 6, "ms")


def print_orders(result: OrderSelection) -> None:
    """Table of the orders tried."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    table = Table(title="Orders", title_justify="left")
    for heading in ("poles", "zeros", "residual", "ΔBIC", "weight", "independence p"):
        table.add_column(heading, justify="right")
    table.add_column("remarks")
    for row in result.table.to_dict("records"):
        remarks = [
            *(["chosen"] if row["chosen"] else []),
            *([] if row["converged"] else ["no convergence"]),
            *([] if row["determined"] or not row["converged"] else ["a pole is not determined"]),
            *(["a zero cancels a pole"] if row["cancels"] else []),
        ]
        numbers = (
            percentage(row["nrmse"]),
            f"{row['delta_bic']:.1f}",
            probability(row["weight"]),
            probability(row["independence_p"]),
        )
        shown = ["–" if n.startswith("nan") else n for n in numbers]
        table.add_row(str(row["poles"]), str(row["zeros"]), *shown, ", ".join(remarks))
    console.print(table)
    console.print(f"chosen: --order {result.poles} {result.zeros}")


def print_joined(result: Joined, written: list[Path]) -> None:
    """Offset and skew, what they are from, and what was written."""
    from rich.console import Console
    from rich.table import Table

    console, clocks = Console(highlight=False), result.clocks
    table = Table(title="Two clocks", title_justify="left")
    table.add_column("quantity")
    table.add_column("value ± standard deviation", justify="right")
    table.add_column("unit")
    table.add_row("offset", with_deviation(1e3 * clocks.offset, 1e3 * clocks.offset_deviation), "ms")
    table.add_row("skew", with_deviation(1e6 * clocks.skew, 1e6 * clocks.skew_deviation), "10⁻⁶")
    console.print(table)
    console.print("time of the drive = offset + (1 + skew) · time of the clip", soft_wrap=True)
    console.print(f"from {result.method}; correlation {clocks.correlation:.4f}", soft_wrap=True)
    rows = f"{len(result.table)} rows, period {_milliseconds(result.period)}; {result.frames} frames"
    console.print(rows, soft_wrap=True)
    console.print(
        f"frames are dated {_milliseconds(result.latency)} later than their time stamps, in '{result.frame_time}': "
        f"say time: {result.frame_time}, latency: estimate, skew: estimate under sensor",
        soft_wrap=True,
    )
    for path in written:
        console.print(f"written to {path}", soft_wrap=True)
