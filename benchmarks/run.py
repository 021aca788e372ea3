"""Run benchmarks, print their tables, and write the CSV files; all together also docs/benchmarks.md and its figure."""

from __future__ import annotations

import importlib
import platform
import sys
from importlib import metadata
from pathlib import Path

import cv2
import pandas as pd

from benchmarks.diagnosis import FRAGMENT, put_in
from benchmarks.peers import PEERS
from benchmarks.report import Report, number
from benchmarks.task import ROOT
from benchmarks.threads import SINGLE_THREAD

NAMES = ("identification", "scaling", "rendering", "measurement", "engine", "tracking")
LIBRARIES = ("camid", "numpy", "scipy", "numba", "opencv-python-headless", "av")
TABLES = ROOT / "results" / "benchmarks"
SCREEN_WIDTH = 150  # characters, where there is no terminal to ask
DOCUMENT, FIGURE = ROOT / "docs" / "benchmarks.md", ROOT / "docs" / "benchmarks.png"


def processor() -> str:
    """Model of the processor, as the system names it."""
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def header() -> str:
    """What the numbers were measured with, in Markdown."""
    versions = {name: metadata.version(name) for name in LIBRARIES}
    versions |= {peer.distribution: peer.version() for peer in PEERS}
    threads = ", ".join(f"{name}={value}" for name, value in SINGLE_THREAD.items())
    return (
        "# Benchmarks\n\n"
        "Written by `make bench` (`python -m benchmarks` in the environment of `requirements-benchmark.lock`); "
        "how each peer is called, and why, is in [benchmarks/README.md](../benchmarks/README.md).\n\n"
        f"- Processor: {processor()}; one thread ({threads}; OpenCV with one thread)\n"
        f"- Python {platform.python_version()}, {platform.system()}\n"
        f"- {', '.join(f'{name} {version}' for name, version in versions.items())}\n"
    )


def markdown(reports: list[Report]) -> str:
    """The whole document."""
    parts = [header()]
    parts.append(
        "![Time of a fit against its error](benchmarks.png)\n\n"
        "*Time of one fit at T = 0.1 s against its error, as in the first table.*\n"
    )
    goals = goal_table(reports)
    parts.append("## Goals\n\n" + goals.to_markdown(index=False, disable_numparse=True) + "\n")
    for report in reports:
        table = report.shown.to_markdown(index=False, disable_numparse=True)
        parts.append(f"## {report.title}\n\n{report.explanation}\n\n{table}\n")
    return "\n".join(parts)


def goal_table(reports: list[Report]) -> pd.DataFrame:
    """Every goal with what was measured."""
    return pd.DataFrame(
        [
            {
                "goal": goal.text,
                "measured": number(goal.measured),
                "limit": f"{'≥' if goal.larger_is_better else '≤'} {number(goal.limit, 2)}",
                "": "met" if goal.met else "**missed**",
            }
            for report in reports
            for goal in report.goals
        ],
        columns=["goal", "measured", "limit", ""],
    )


def show(title: str, table: pd.DataFrame) -> None:
    """Print a table for people."""
    from rich.console import Console  # noqa: PLC0415 - only the screen needs it
    from rich.table import Table  # noqa: PLC0415

    drawn = Table(title=title)
    for column in table.columns:
        drawn.add_column(column, justify="right" if column.startswith(("ms", "frames", "time", "µs")) else "left")
    for row in table.itertuples(index=False):
        drawn.add_row(*(str(value).replace("**", "") for value in row))
    Console(width=None if sys.stdout.isatty() else SCREEN_WIDTH).print(drawn)


def main(arguments: list[str]) -> int:
    """Run the named benchmarks, or all.

    Parameters
    ----------
    arguments : list of str
        Some of `NAMES`.

    Returns
    -------
    int
        Exit code: 2 for a name that there is not.
    """
    unknown = sorted(set(arguments) - set(NAMES))
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there are {', '.join(NAMES)}")
        return 2
    cv2.setNumThreads(1)
    TABLES.mkdir(parents=True, exist_ok=True)
    reports = []
    for name in arguments or NAMES:
        print(f"{name} …", flush=True)
        report = importlib.import_module(f"benchmarks.{name}").run()
        report.table.to_csv(TABLES / f"{report.name}.csv", index=False, lineterminator="\n")
        show(report.title, report.shown)
        reports.append(report)
    goals = goal_table(reports)
    goals.to_csv(TABLES / "goals.csv", index=False, lineterminator="\n")
    show("Goals", goals)
    if [report.name for report in reports] == list(NAMES):
        DOCUMENT.parent.mkdir(exist_ok=True)
        # The profile of a diagnosis has a command of its own: it needs idle cores and an earlier state of the package.
        fragment = FRAGMENT.read_text(encoding="utf-8") if FRAGMENT.exists() else ""
        DOCUMENT.write_text(put_in(markdown(reports), fragment), encoding="utf-8")
        importlib.import_module("benchmarks.figure").save(reports[0].table, FIGURE)
        print(f"written: {DOCUMENT.relative_to(ROOT)} and {FIGURE.name}, tables in {TABLES.relative_to(ROOT)}")
    return 0
