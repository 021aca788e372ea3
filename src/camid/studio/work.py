"""What the page does when a button is pressed: one command of camid at a time, and what becomes of the project."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from camid.diagnosis.watch import TIME_LIMIT
from camid.errors import InputError
from camid.studio import declaration
from camid.studio.job import Job
from camid.studio.project import COMPARISON, DIAGNOSIS, FRAME, MODEL, PREVIEW, SIMULATION, Project


@dataclass
class Work:
    """A project, what runs for it, and those who want to know that something changed.

    Attributes
    ----------
    project : Project
    job : Job or None
        What runs now.
    busy : str
        The step that it belongs to; empty where nothing runs.
    watchers : list of callable
        Called without arguments after each change.
    """

    project: Project
    job: Job | None = None
    busy: str = ""
    watchers: list[Callable[[], None]] = field(default_factory=list)
    _closed: bool = False

    def changed(self) -> None:
        """Tell all pages."""
        for watcher in [*self.watchers]:
            watcher()

    async def _command(self, step: str, title: str, *arguments: str) -> Job | None:
        """Run ``python -m``; None, with the one line as the step's error, if it did not go well."""
        if self._closed:
            return None
        self.job, self.busy = Job(title, arguments, self.project.folder), step
        self.project.errors.pop(step, None)
        self.changed()
        job = self.job
        try:
            well = await job.run()
        except OSError as error:
            well, job.error = False, f"cannot start a process ({error.strerror})"
        finally:
            self.job, self.busy = None, ""
        if not well:
            self.project.errors[step] = self.project.without_folder(job.error or "")
        return job if well else None

    def cancel(self) -> None:
        """End what runs."""
        if self.job is not None:
            self.job.cancel()

    async def close(self) -> None:
        """End what runs, wait for its end, and begin nothing more."""
        self._closed = True
        self.cancel()
        while self.job is not None:
            await asyncio.sleep(0.05)

    async def look_at_clip(self) -> None:
        """Show the first frame, and where the marker would be found in it."""
        project = self.project
        asked = {"clip": project.clip, "picture": FRAME, "settings": _of_a_frame(project.marker.options())}
        job = await self._command(
            "marker", "looking at the clip", "camid.studio.look", "frame", json.dumps(asked, allow_nan=False)
        )
        if job is not None:
            project.frame = json.loads(job.output)
        self.changed()

    async def track(self) -> None:
        """Follow the marker through the clip, then go on as with a recording."""
        project = self.project
        assert project.clip is not None
        project.forget("marker")
        output = f"{Path(project.clip).stem}.csv"
        job = await self._command(
            "marker",
            "tracking",
            *("camid", "track", project.clip, "--output", output, "--preview", PREVIEW, "--json"),
            *project.marker.arguments(),
        )
        if job is not None:
            project.take_tracked(output, json.loads(job.output), job.warnings)
            await self.draft()
        self.changed()

    async def draft(self, plant: str | None = None) -> None:
        """Look at the columns of the recording, and write a first simulation of it."""
        project = self.project
        if project.columns is None:
            asked = json.dumps({"recording": project.recordings[-1]})
            job = await self._command("recording", "reading the recording", "camid.studio.look", "columns", asked)
            if job is None:
                await self._without_the_last()
                return
            project.columns = json.loads(job.output)
        named = [] if plant is None else ["--plant", plant]
        job = await self._command(
            "simulation", "writing a first simulation", "camid", "init", "recording", *project.recordings, *named
        )
        if job is not None:
            await self.take_simulation(job.output)
        self.changed()

    async def _without_the_last(self) -> None:
        """Go on without the recording that was refused; the line that says why stays."""
        project, line = self.project, self.project.errors.get("recording", "")
        if project.clip is None:
            project.recordings = project.recordings[:-1]
            if project.recordings:
                await self.draft()
            project.errors["recording"] = line
        self.changed()

    async def start_over(self) -> None:
        """Use no file any more."""
        self.project.forget("recording")
        self.project.clip, self.project.recordings = None, []
        self.changed()

    async def take_simulation(self, text: str) -> None:
        """Use a simulation that was drafted, uploaded, or edited; what is wrong with it is the step's error."""
        project = self.project
        project.forget("simulation")
        project.simulation = text
        path = project.folder / SIMULATION
        path.write_text(text, encoding="utf-8", errors="replace")
        try:
            await asyncio.to_thread(_check, path)
        except (InputError, OSError) as error:
            project.errors["simulation"] = project.without_folder(str(error))
        self.changed()

    async def change(self, path: tuple[str, ...], value: str) -> None:
        """Change one key of the simulation."""
        await self.take_simulation(declaration.changed(self.project.simulation, path, value))

    async def identify(self) -> None:
        """Re-estimate the plant, and draw recorded and simulated output."""
        project = self.project
        project.forget("identify")
        job = await self._command(
            "identify",
            "identifying",
            *("camid", "identify", *project.recordings, "--simulation", SIMULATION, "--output", MODEL, "--json"),
        )
        if job is not None:
            project.identification = json.loads(job.output)
            # The warnings are in the summary as well.
            project.warnings["identify"] = job.warnings
            await self._command(
                "identify",
                "drawing",
                *("camid", "compare", project.recordings[0], SIMULATION, MODEL, "--output", COMPARISON, "--json"),
            )
        self.changed()

    async def diagnose(self, time_limit: float = TIME_LIMIT) -> None:
        """Find what the simulation leaves out, and write the report."""
        project = self.project
        project.forget("diagnose")
        job = await self._command(
            "diagnose",
            "diagnosing",
            *("camid", "diagnose", *project.recordings, "--simulation", SIMULATION, "--output", DIAGNOSIS),
            *("--time-limit", f"{time_limit:g}", "--json"),
        )
        if job is not None:
            project.diagnosis = json.loads(job.output)
            project.warnings["diagnose"] = job.warnings
        self.changed()


def _of_a_frame(options: dict[str, Any]) -> dict[str, Any]:
    """What the first frame depends on."""
    kept = ("colour", "bright", "dark", "region", "start", "end", "frame_rate")
    return {name: options[name] for name in kept if name in options}


def _check(path: Path) -> None:
    from camid.simulation.file import load_simulation

    load_simulation(path)
