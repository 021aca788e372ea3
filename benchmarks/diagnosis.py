"""Where a diagnosis spends its time: whole commands beside those of an earlier state, and a profile of its stages.

``python -m benchmarks.diagnosis [REVISION]`` in the ordinary environment, on idle cores; the earlier state is 3ee4f06,
the last one before weights were calibrated and the search was made faster. It replaces its part of docs/benchmarks.md.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pandas as pd

import camid
from camid.diagnosis.watch import Watch
from camid.engine.work import Work
from camid.proof.concealed.cases import plan
from camid.proof.concealed.generator import make
from camid.proof.sealed_files import RECORDING, SIMULATION, write_table, write_yaml

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/benchmarks.md"
FRAGMENT = ROOT / "benchmarks/diagnosis_profile.md"
TITLE = "## Where a diagnosis spends its time"
EARLIER = "3ee4f06"
SEED, CASES = 97, 400
# What is concealed, and where the first such recording of the plan is.
WANTED: dict[str, Callable[[tuple[str, ...]], bool]] = {
    "nothing": lambda effects: effects == (),
    "Coulomb friction": lambda effects: effects == ("coulomb-friction",),
    "hysteresis": lambda effects: effects == ("hysteresis",),
    "two effects": lambda effects: len(effects) == 2,
}
REPEATS = 2
# What a diagnosis says on its way, by the part of the table that it belongs to.
STAGES = {
    "reading": ("reading", "re-estimating"),
    "screening": ("screening",),
    "search": ("fitting what may be missing",),
    "rivals": ("testing what could replace",),
    "what is left": ("testing what is left", "testing whether"),
    "laws without a name": ("learning", "looking for"),
    "limits": ("working out", "designing"),
}


def recordings(folder: Path) -> dict[str, tuple[Path, int]]:
    """Write the recordings; folder and number of frames of each."""
    found = {}
    for name, wanted in WANTED.items():
        case = next(c for c in plan(SEED, CASES) if c.kind in ("none", "single", "several") and wanted(c.effects))
        made = make(case)
        place = folder / name.replace(" ", "_")
        write_table(made.recording, place / RECORDING)
        write_yaml(made.simulation, place / SIMULATION)
        found[name] = (place, len(made.recording))
    return found


def whole_command(place: Path, source: Path) -> float:
    """Seconds of ``camid diagnose`` with its report, the fastest of a few runs, by the package in a folder."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"} | {"PYTHONPATH": str(source)}
    command = [sys.executable, "-m", "camid", "diagnose", "recording.csv", "--simulation", "simulation.yaml"]
    seconds = []
    for i in range(REPEATS + 1):  # the first one compiles
        start = time.perf_counter()
        output = ["--output", f"{source.parent.name}_{i}", "--time-limit", "0"]
        subprocess.run([*command, *output], cwd=place, env=environment, check=True, capture_output=True)
        seconds.append(time.perf_counter() - start)
    return min(seconds[1:])


def profile(place: Path) -> tuple[dict[str, float], int]:
    """Seconds of each stage, and how many simulations there were."""
    count, works = Watch.count, []

    def counted(watch: Watch, work: Work, rows: int) -> None:
        works.append(work)
        count(watch, work, rows)

    spent = dict.fromkeys(STAGES, 0.0)
    last, since = "reading", time.perf_counter()

    def say(sentence: str) -> None:
        nonlocal last, since
        now = time.perf_counter()
        spent[last] += now - since
        last = next((stage for stage, words in STAGES.items() if sentence.startswith(words)), last)
        since = now

    Watch.count = counted  # type: ignore[method-assign]
    try:
        camid.diagnose(place / "recording.csv", place / "simulation.yaml", progress=say, time_limit=None)
    finally:
        Watch.count = count  # type: ignore[method-assign]
    say("")
    return spent, works[0].runs


def table(earlier: str) -> pd.DataFrame:
    """Whole commands before and now, and the stages of the diagnosis."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        add = ["git", "worktree", "add", "--quiet", "--detach", str(folder / "earlier"), earlier]
        subprocess.run(add, cwd=ROOT, check=True)
        try:
            places = recordings(folder)
            profile(places["nothing"][0])  # imports and compiles
            for what, (place, frames) in places.items():
                before, now = (whole_command(place, tree / "src") for tree in (folder / "earlier", ROOT))
                spent, count = profile(place)
                row: dict[str, object] = {"concealed": what, "frames": frames}
                row |= {f"whole command at {earlier}": f"{before:.1f} s", "now": f"{now:.1f} s"}
                rows.append(row | {stage: f"{s:.2f} s" for stage, s in spent.items()} | {"simulations": count})
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", folder / "earlier"], cwd=ROOT, check=True)
    return pd.DataFrame(rows)


def put_in(page: str, fragment: str) -> str:
    """The page with the part on diagnoses at its end."""
    return re.sub(rf"\n*{re.escape(TITLE)}.*\Z", "", page, flags=re.DOTALL).rstrip() + (
        "\n\n" + fragment if fragment else "\n"
    )


def main(arguments: list[str]) -> int:
    """Measure, and write the part of the page."""
    earlier = arguments[0] if arguments else EARLIER
    fragment = (
        f"{TITLE}\n\n"
        "`python -m benchmarks.diagnosis` on two idle cores: recordings of the generator of the sealed proof, the "
        f"whole command with start and report (fastest of {REPEATS}) at an earlier commit and now, in one run; then "
        "the stages of the diagnosis within a warm process, and how many times the chain was simulated. A "
        "simulation of friction or hysteresis takes 1 to 10 ms, one of a linear chain 0.1 ms: a long search is bound "
        "by the integrator. The rest of a whole command is loading (NumPy, SciPy, numba's machine code) and "
        "pictures.\n\n"
        f"{table(earlier).to_markdown(index=False)}\n"
    )
    FRAGMENT.write_text(fragment, encoding="utf-8")
    PAGE.write_text(put_in(PAGE.read_text(encoding="utf-8"), fragment), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
