"""The fifth step: what the simulation leaves out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from camid.diagnosis.watch import TIME_LIMIT
from camid.studio.project import DIAGNOSIS

if TYPE_CHECKING:
    from camid.studio.page import Page

REPORT = f"{DIAGNOSIS}/report.html"


def draw(page: Page) -> None:
    """The button, the verdict and the report."""
    project, work = page.work.project, page.work
    ui.label(
        "Finds, names and models what the simulation leaves out, in seconds to a quarter of a minute, seldom more."
    ).classes("studio-note")
    limit = page.chosen.setdefault("limit", TIME_LIMIT)
    with ui.element("div").classes("studio-buttons"):
        page.button("Diagnose", lambda: work.diagnose(page.chosen["limit"] or 0.0))
        ui.number(
            "Time limit in s", value=limit, min=0, on_change=lambda event: page.chosen.update(limit=event.value)
        ).props('outlined dense hint="0: none"')
    found = project.diagnosis
    if found is None:
        return
    from camid.diagnosis.report.summary import HARDLY_ANYTHING, VERDICT_WORDS

    explains = found["verdict"] != "adequate" or found["fit"].get("explains_output", True)
    symbol, word, _ = VERDICT_WORDS[found["verdict"]] if explains else HARDLY_ANYTHING
    ui.label(f"{symbol} {word.upper()}").classes("studio-verdict").mark("verdict")
    ui.label(found["explanation"]).classes("studio-fact")
    address = page.address(REPORT)
    ui.link("Open the report in its own tab", address, new_tab=True).classes("studio-link")
    frame = ui.element("iframe").classes("studio-report").mark("report")
    frame.props["src"] = address
    frame.props["title"] = "Report of the diagnosis"
    frame.props["sandbox"] = "allow-scripts allow-downloads allow-popups"
