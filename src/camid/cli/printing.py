"""What the commands print for people."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from camid.chain.pendulum import Pendulum
    from camid.identification.identification import Identification
    from camid.identification.order_selection import OrderSelection
    from camid.simulation.model import Simulation


def print_identification(result: Identification, written: list[Path]) -> None:
    """Table of coefficients and characteristics, fit and residual test."""
    from rich.console import Console
    from rich.table import Table

    model = result.simulation
    console = Console(highlight=False)
    table = Table(title="Identified plant", title_justify="left")
    for heading in ("quantity", "value", "standard deviation", "unit"):
        table.add_column(heading, justify="left" if heading in {"quantity", "unit"} else "right")
    for row in _pendulum_rows(model.pendulum) if model.pendulum is not None else _coefficient_rows(model):
        table.add_row(*row)
    if model.pendulum is None:
        table.add_section()
        for found in result.characteristics():
            deviation = f"{found['standard_deviation']:.2g}"
            table.add_row(str(found["name"]), f"{found['value']:.8g}", deviation, str(found["unit"]))
    console.print(table)
    held = "free decay" if model.input_column is None else f"input {model.hold}"
    sensor = "instant sensor" if model.sensor == "instant" else f"camera, exposure {1e3 * (model.exposure or 0):.6g} ms"
    console.print(
        f"fitted to {result.rows_fitted} samples, period {1e3 * result.period:.6g} ms; {held}; {sensor}, "
        f"latency {1e3 * model.latency:.6g} ms; initial state: {model.initial_state}",
        soft_wrap=True,
    )
    validation = (
        "" if result.nrmse_validation is None else f", {100 * result.nrmse_validation:.4g} % on validation rows"
    )
    console.print(
        f"residual: {100 * result.nrmse:.4g} % of the output's standard deviation{validation} "
        f"({'converged' if result.converged else 'not converged'})",
        soft_wrap=True,
    )
    if result.residual_analysis is not None:
        console.print(result.residual_analysis.summary(), soft_wrap=True)
    for path in written:
        console.print(f"written to {path}", soft_wrap=True)


def _deviation(value: float | None) -> str:
    return "undetermined" if value is None else f"{value:.2g}" if value else "fixed"


def _coefficient_rows(model: Simulation) -> Iterator[tuple[str, str, str, str]]:
    """Coefficients of a transfer function with their standard deviations."""
    deviations = model.standard_deviations
    for name, letter, coefficients in (
        ("numerator", "b", model.plant.numerator),
        ("denominator", "a", model.plant.denominator),
    ):
        for i, value in enumerate(coefficients):
            power = len(coefficients) - 1 - i
            symbol = {0: "", 1: " · s"}.get(power, f" · s^{power}")
            deviation = _deviation(None if deviations is None else deviations[name][i])
            yield f"{letter}{power}{symbol}", f"{value:.8g}", deviation, ""


def _pendulum_rows(pendulum: Pendulum) -> Iterator[tuple[str, str, str, str]]:
    """Parameters of a pendulum with their standard deviations."""
    units = {"natural_frequency": "rad/s", "damping": "", "gain": "y/u", "rest": "rad"}
    for name, unit in units.items():
        deviation = None if pendulum.standard_deviations is None else pendulum.standard_deviations.get(name)
        yield name.replace("_", " "), f"{getattr(pendulum, name):.8g}", _deviation(deviation), unit


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
            f"{100.0 * row['nrmse']:.4g} %",
            f"{row['delta_bic']:.1f}",
            f"{row['weight']:.2g}",
            f"{row['independence_p']:.2g}",
        )
        shown = ["–" if n.startswith("nan") else n for n in numbers]
        table.add_row(str(row["poles"]), str(row["zeros"]), *shown, ", ".join(remarks))
    console.print(table)
    console.print(f"chosen: --order {result.poles} {result.zeros}")
