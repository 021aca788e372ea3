"""What was chosen and computed so far, and which step can be done next. It knows nothing of the page."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from camid.recording.files import SPREADSHEETS, SUFFIXES
from camid.studio.marker import Marker

STEPS = ("recording", "marker", "simulation", "identify", "diagnose", "files")
# Names of what camid writes into the folder.
FRAME, PREVIEW, SIMULATION, MODEL = "frame.png", "preview.png", "simulation.yaml", "model.yaml"
COMPARISON, COMPARISON_NUMBERS, DIAGNOSIS = "comparison.png", "comparison.csv", "diagnosis"
RESERVED = {FRAME, PREVIEW, SIMULATION, MODEL, COMPARISON, COMPARISON_NUMBERS, DIAGNOSIS}
PACKED = {".zip", ".gz"}
YAML_SUFFIXES = {".yaml", ".yml"}
LONGEST_NAME = 100


def safe_name(name: str) -> str:
    """The name of an uploaded file: no folder, no option, nothing hidden, and none that camid writes itself."""
    last = name.replace("\\", "/").rpartition("/")[2]
    clean = "".join(c if c.isprintable() and c not in '<>:"|?*' else "_" for c in last).strip().lstrip(".-")
    stem, dot, suffix = clean.rpartition(".")
    clean = f"{stem[: LONGEST_NAME - len(suffix)]}{dot}{suffix[:20]}" if stem else clean[:LONGEST_NAME]
    clean = clean or "recording"
    return f"my-{clean}" if clean.lower() in RESERVED else clean


def kind_of(name: str) -> str:
    """``recording``, ``simulation`` or ``clip``, by the suffix: what is no table is given to FFmpeg."""
    suffix = Path(name).suffix.lower()
    if suffix in YAML_SUFFIXES:
        return "simulation"
    return "recording" if suffix in SUFFIXES or suffix in SPREADSHEETS or suffix in PACKED else "clip"


@dataclass
class Project:
    """One recording on its way to a report.

    Attributes
    ----------
    folder : Path
    recordings : list of str
        Names of the tables that are used; of a clip, the one that was tracked.
    clip : str or None
    marker : Marker
    frame : dict or None
        What :func:`camid.studio.look.frame` found.
    tracked : dict or None
        Summary of ``camid track``.
    columns : dict or None
        What :func:`camid.studio.look.columns` found in the recording that came last.
    simulation : str
        Its text; empty before there is one.
    identification, diagnosis : dict or None
        As the commands print them.
    errors, warnings : dict of str to str or list of str
        By step.
    """

    folder: Path
    recordings: list[str] = field(default_factory=list)
    clip: str | None = None
    marker: Marker = field(default_factory=Marker)
    frame: dict[str, Any] | None = None
    tracked: dict[str, Any] | None = None
    columns: dict[str, Any] | None = None
    simulation: str = ""
    identification: dict[str, Any] | None = None
    diagnosis: dict[str, Any] | None = None
    errors: dict[str, str] = field(default_factory=dict)
    warnings: dict[str, list[str]] = field(default_factory=dict)

    def take_clip(self, name: str) -> None:
        """Use a clip; whatever was there before belongs to another recording."""
        self.forget("recording")
        self.clip, self.recordings, self.marker = name, [], Marker()

    def take_recording(self, name: str) -> None:
        """Use a table, beside those that are there already; of a clip, another one cannot be beside."""
        self.forget("recording")
        kept = [] if self.clip is not None else [r for r in self.recordings if r != name]
        self.clip, self.recordings = None, [*kept, name]

    def take_tracked(self, name: str, summary: dict[str, Any], warnings: list[str]) -> None:
        """Use what was tracked in the clip."""
        self.forget("marker")
        self.tracked, self.recordings, self.warnings["marker"] = summary, [name], warnings

    def forget(self, step: str) -> None:
        """Remove what follows from a step, which is done anew; identification and diagnosis do not need each other."""
        first = STEPS.index(step)
        gone = STEPS[first:] if first < STEPS.index("identify") else (step,)
        for later in gone:
            self.errors.pop(later, None)
            self.warnings.pop(later, None)
        if "recording" in gone:
            self.frame = None
        if "marker" in gone:
            self.tracked, self.columns, self.simulation = None, None, ""
        if "marker" in gone and self.clip is not None:
            self.recordings = []
        if "identify" in gone:
            self.identification = None
            self._remove(MODEL, COMPARISON, COMPARISON_NUMBERS)
        if "diagnose" in gone:
            self.diagnosis = None
            self._remove(DIAGNOSIS)

    def _remove(self, *names: str) -> None:
        for name in names:
            path = self.folder / name
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)

    def state(self, step: str) -> str:
        """``done``, ``open``, ``waiting`` for the step before, or ``not needed``."""
        if step == "marker" and self.clip is None and self.recordings:
            return "not needed"
        simulated = bool(self.simulation) and "simulation" not in self.errors
        done, possible = {
            "recording": (bool(self.clip or self.recordings), True),
            "marker": (self.tracked is not None, self.clip is not None),
            "simulation": (simulated, self.columns is not None),
            "identify": (self.identification is not None, simulated),
            "diagnose": (self.diagnosis is not None, simulated),
            "files": (bool(self.files()), False),
        }[step]
        return "done" if done else "open" if possible else "waiting"

    def files(self) -> list[str]:
        """What can be downloaded, as paths within the folder: what camid wrote, and nothing that was uploaded."""
        written = [*self.recordings, PREVIEW] if self.tracked is not None else []
        written += [SIMULATION, MODEL, COMPARISON, COMPARISON_NUMBERS] if self.recordings else []
        results = sorted(p.name for p in (self.folder / DIAGNOSIS).glob("*") if not p.name.startswith("."))
        names = [*written, *(f"{DIAGNOSIS}/{name}" for name in results)]
        return [name for name in names if (self.folder / name).is_file()]

    def without_folder(self, line: str) -> str:
        """A message without the folder, which may be a temporary one."""
        return line.replace(f"{self.folder}/", "")
