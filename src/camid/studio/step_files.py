"""The last step: what camid wrote, to be taken away."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nicegui import ui

from camid.studio.project import DIAGNOSIS

if TYPE_CHECKING:
    from camid.studio.page import Page

ARCHIVE = "camid.zip"


def draw(page: Page) -> None:
    """A link for each file, and one for all."""
    names = page.work.project.files()
    for name in names:
        ui.link(name, page.address(name, download=True)).classes("studio-link").props["download"] = name.rpartition(
            "/"
        )[2]
    ui.link("All of them (ZIP)", page.address(ARCHIVE, download=True)).classes("studio-link").props["download"] = (
        ARCHIVE
    )
    if f"{DIAGNOSIS}/improved.yaml" in names:
        ui.label("improved.yaml is a simulation again: drop it into step 1 to go on with it.").classes("studio-note")
