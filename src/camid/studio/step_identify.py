"""The fourth step: the plant is re-estimated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from camid.studio.project import COMPARISON, MODEL

if TYPE_CHECKING:
    from camid.studio.page import Page


def draw(page: Page) -> None:
    """The button, and what was estimated."""
    project = page.work.project
    ui.label("Re-estimates the plant of your simulation from the recording.").classes("studio-note")
    page.button("Identify", page.work.identify)
    found = project.identification
    if found is None:
        return
    share = f"{100.0 * found['nrmse']:.3g} % of the output's standard deviation remain"
    state = "" if found["converged"] else " NOT CONVERGED: do not use the numbers."
    ui.label(f"{share}, fitted to {found['rows_fitted']} rows.{state}").classes("studio-fact").mark("remains")
    rows = rows_of(page, found)
    with ui.element("table").classes("studio-table"):
        with ui.element("tr"):
            for heading in ("quantity", "value ± standard deviation", "unit"):
                with ui.element("th"):
                    ui.label(heading)
        for row in rows:
            with ui.element("tr"):
                for cell in row:
                    with ui.element("td"):
                        ui.label(cell)
    if (project.folder / COMPARISON).is_file():
        page.picture(COMPARISON, "Recorded and simulated output")


def rows_of(page: Page, found: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Quantity, estimate and unit, in the words of the commands."""
    from camid.number_text import with_deviation
    from camid.simulation.file import load_simulation

    model = load_simulation(page.work.project.folder / MODEL)
    named = [(n, with_deviation(v, d), unit) for n, v, d, unit in model.coefficient_rows()]
    return named + [
        (str(row["name"]), with_deviation(row["value"], row["standard_deviation"]), str(row["unit"]))
        for row in [*found["characteristics"], *found["constants"]]
    ]
