"""The first step: a file is dropped."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from camid.studio.guard import MEGABYTE, too_large
from camid.studio.project import kind_of, safe_name

if TYPE_CHECKING:
    from camid.studio.page import Page


def draw(page: Page) -> None:
    """The place for a file, and what is there."""
    project, limit = page.work.project, page.guard.largest_upload

    def refused() -> None:
        project.errors["recording"] = too_large(limit)
        page.work.changed()

    async def uploaded(event: events.UploadEventArguments) -> None:
        await take(page, event.file)

    ui.upload(
        label="Drop a file here, or press +",
        auto_upload=True,
        max_file_size=limit,
        on_upload=uploaded,
        on_rejected=refused,
    ).props("flat bordered").classes("studio-drop")
    ui.label(
        "A recording: CSV, Parquet, MAT, HDF5 or Excel; several one after the other, if of one rig. A clip of a "
        f"marker: MP4, AVI, MKV, … A simulation: YAML. At most {limit / MEGABYTE:g} MB."
    ).classes("studio-note")
    names = [project.clip] if project.clip else project.recordings
    if names:
        ui.label(f"In use: {', '.join(names)}").classes("studio-fact")
        page.button("Start over", page.work.start_over, main=False)
    if project.columns is not None:
        ui.label(f"Columns: {', '.join(project.columns['names'])}").classes("studio-note")


async def take(page: Page, file: Any) -> None:
    """Keep an uploaded file, and begin what it is good for."""
    work, project, name = page.work, page.work.project, safe_name(file.name)
    if work.busy:
        ui.notify("Something is running: wait for its end, or cancel it, then drop the file again.", type="warning")
        return
    kind = kind_of(name)
    project.errors.pop("recording", None)
    if kind == "simulation":
        if not project.recordings:
            project.errors["recording"] = f"{name}: a simulation is used with a recording; drop that one first"
            work.changed()
            return
        page.begin(work.take_simulation, (await file.read()).decode("utf-8", errors="replace"))
        return
    try:
        await file.save(project.folder / name)
    except OSError as error:
        project.errors["recording"] = f"{name}: cannot be kept ({error.strerror}); make room on the disk"
        work.changed()
        return
    if kind == "clip":
        project.take_clip(name)
        page.begin(work.look_at_clip)
    else:
        project.take_recording(name)
        page.begin(work.draft)
