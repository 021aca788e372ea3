"""The page: steps from top to bottom, each drawn anew when something changed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import background_tasks, ui

from camid.studio import step_diagnose, step_files, step_identify, step_marker, step_recording, step_simulation
from camid.studio.guard import Guard
from camid.studio.project import COMPARISON, STEPS, Project
from camid.studio.work import Work

TITLES = {
    "recording": "Recording or clip",
    "marker": "Marker",
    "simulation": "Simulation",
    "identify": "Identify",
    "diagnose": "Diagnose",
    "files": "Files",
}
DRAWN = {
    "recording": step_recording.draw,
    "marker": step_marker.draw,
    "simulation": step_simulation.draw,
    "identify": step_identify.draw,
    "diagnose": step_diagnose.draw,
    "files": step_files.draw,
}
# What a step shows: it is drawn anew where this changes.
CONTENT: dict[str, Callable[[Project], Any]] = {
    "recording": lambda p: (p.clip, tuple(p.recordings), p.columns is None),
    "marker": lambda p: (p.clip, repr(p.frame), repr(p.marker.options()), repr(p.tracked)),
    "simulation": step_simulation.structure,
    "identify": lambda p: (repr(p.identification), (p.folder / COMPARISON).exists()),
    "diagnose": lambda p: repr(p.diagnosis),
    "files": lambda p: tuple((name, (p.folder / name).stat().st_mtime_ns) for name in p.files()),
}
STATES = {"done": "✓ done", "open": "", "waiting": "later", "not needed": "not needed: this is no clip"}
# Seconds between two looks at what a command says.
EVERY = 0.25


@dataclass
class Page:
    """One view of the project, in one tab of the browser.

    Attributes
    ----------
    work : Work
    guard : Guard
        Knows the address of files and how large an upload may be.
    """

    work: Work
    guard: Guard
    # What is chosen on this page alone.
    chosen: dict[str, Any] = field(default_factory=dict)
    _parts: dict[tuple[str, str], Any] = field(default_factory=dict)
    _shown: dict[tuple[str, str], Any] = field(default_factory=dict)
    _resting: list[tuple[Any, set[str]]] = field(default_factory=list)

    def build(self) -> None:
        """Draw everything, and keep it in step with the project."""
        ui.colors(primary="#0072B2", secondary="#56B4E9", positive="#007A5A", negative="#B34700", warning="#8A6D00")
        ui.add_css(Path(__file__).with_name("style.css"))
        with ui.element("header").classes("studio-head"):
            ui.label("camid studio").classes("studio-name").props('role="heading" aria-level="1"')
            ui.label("From a clip or a recording to a diagnosis. Everything stays on this computer.")
        with ui.element("main").classes("studio"):
            for step in STEPS:
                with ui.element("section").classes("studio-step").props(f'id="{step}"'):
                    for part in ("title", "body", "end"):
                        self._parts[step, part] = ui.element("div").classes(f"studio-{part}")
        self.refresh()
        ui.timer(EVERY, self._tell)
        self.work.watchers.append(self.refresh)
        ui.context.client.on_delete(lambda: self.work.watchers.remove(self.refresh))

    def refresh(self) -> None:
        """Draw anew what changed: what is typed elsewhere, and a report that is read, stay as they are."""
        for step in STEPS:
            self._refresh_step(step)
        step_simulation.update(self)
        for element, steps in self._resting:
            if not element.is_deleted:
                element.set_enabled(self.work.busy in steps)

    def _refresh_step(self, step: str) -> None:
        project, running = self.work.project, self.work.busy == step
        state = project.state(step)
        content = False if state in {"waiting", "not needed"} else CONTENT[step](project)
        said = (running, project.errors.get(step), tuple(project.warnings.get(step, [])))
        self._draw((step, "title"), state, lambda: self._title(step, state))
        self._draw((step, "body"), content, lambda: DRAWN[step](self))
        self._draw((step, "end"), said, lambda: self._end(*said))

    def _draw(self, part: tuple[str, str], content: Any, draw: Callable[[], None]) -> None:
        """Draw a part whose content is another one than before; False stands for nothing."""
        if part in self._shown and self._shown[part] == content:
            return
        container = self._parts[part]
        container.clear()
        if content is not False:
            with container:
                draw()
        self._shown[part] = content

    def _title(self, step: str, state: str) -> None:
        self._parts[step, "title"].classes(replace=f"studio-title {state.replace(' ', '-')}")
        ui.label(str(STEPS.index(step) + 1)).classes("studio-number").props('aria-hidden="true"')
        ui.label(TITLES[step]).classes("studio-heading").props('role="heading" aria-level="2"')
        ui.label(STATES[state]).classes("studio-state")

    def _end(self, running: bool, error: str | None, warnings: tuple[str, ...]) -> None:
        """What runs, what it does now, and how to end it; what went wrong, and what is to be known."""
        if running:
            with ui.element("div").classes("studio-progress").props('role="status"'):
                ui.spinner(size="1.4em")
                self.chosen["said"] = ui.label()
                ui.button("Cancel", on_click=self.work.cancel).props("flat dense no-caps")
            self._tell()
        if error:
            ui.label(error).classes("studio-error").props('role="alert"')
        for sentence in warnings:
            ui.label(sentence).classes("studio-warning")

    def _tell(self) -> None:
        """Say what runs now."""
        if self.work.job is not None and "said" in self.chosen:
            self.chosen["said"].set_text(f"{self.work.job.title}: {self.work.job.step}")

    def begin(self, task: Callable[..., Awaitable[None]], *arguments: Any) -> None:
        """Run one command, unless another one runs; it goes on if this page is closed."""
        if self.work.busy:
            ui.notify("Something is running: wait for its end, or cancel it.", type="warning")
            return
        background_tasks.create(task(*arguments), name=task.__name__)

    def button(self, text: str, task: Callable[..., Awaitable[None]], *arguments: Any, main: bool = True) -> Any:
        """A button that begins a task, and rests while another one runs."""
        button = ui.button(text, on_click=lambda: self.begin(task, *arguments), color=None).props("no-caps unelevated")
        button.classes(f"studio-button {'main' if main else ''}")
        self.rests(button)
        return button

    def rests(self, element: Any, *unless: str) -> None:
        """Let an element rest while a step is busy, unless it is one of those."""
        self._resting = [(e, steps) for e, steps in self._resting if not e.is_deleted]
        self._resting.append((element, {"", *unless}))
        element.set_enabled(self.work.busy in {"", *unless})

    def picture(self, name: str, words: str) -> Any:
        """A picture in the folder, with words for those who do not see it."""
        with ui.element("div").classes("studio-picture"):
            image = ui.element("img")
        image.props["src"], image.props["alt"] = self.address(name), words
        return image

    def address(self, name: str, download: bool = False) -> str:
        """Where the browser finds a file of the folder, as it is now."""
        path = self.work.project.folder / name
        written = path.stat().st_mtime_ns if path.exists() else 0
        return f"{self.guard.files}{quote(name)}?{'download=1&' if download else ''}v={written}"
