"""Fresh copies of the project, and Snakemake runs in them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

TINY = ROOT / "tests/workflow/tiny.yaml"
# Drawn in little: a chain of the paper, an ablation, the sealed proof.
TINY_TARGETS = ["fig7", "ablation_monte_carlo", "concealed_sample"]
COPIED = ["Snakefile", "config", "workflow", "profiles", "src", "paper_figs", "pyproject.toml"]


class Copy:
    """A fresh clone: what is committed, committed figures included, and nothing that was computed.

    ``configuration`` is a file that every run takes on top of those of the clone.
    """

    def __init__(self, folder: Path, configuration: Path | None = None) -> None:
        self.folder = folder
        self.configuration = configuration
        folder.mkdir(exist_ok=True)
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(source, folder / name)

    def snakemake(
        self,
        *arguments: str,
        cores: int = 2,
        cache: Path | None = None,
        expect: int | None = 0,
        recordings: bool = False,
    ) -> str:
        """Run Snakemake with the copy's own sources and return what it printed."""
        environment = {**os.environ, "PYTHONPATH": str(self.folder / "src")}
        environment.pop("SNAKEMAKE_OUTPUT_CACHE", None)
        if not recordings:  # their diagnoses take minutes, and `make check` guards them
            environment.pop("CAMID_RECORDINGS", None)
        if cache is not None:
            environment["SNAKEMAKE_OUTPUT_CACHE"] = str(cache)
        command = [sys.executable, "-m", "snakemake", f"-c{cores}", *arguments, *(["--cache"] if cache else [])]
        if self.configuration is not None:
            command += ["--configfile", str(self.configuration)]
        run = subprocess.run(
            command, cwd=self.folder, env=environment, capture_output=True, text=True, timeout=1200, check=False
        )
        printed = run.stdout + run.stderr
        if expect is not None:
            assert run.returncode == expect, printed
        return printed

    def planned(self, *arguments: str) -> set[str]:
        """Rules that a dry run would run."""
        return self.ran(*arguments, "-n")

    def ran(self, *arguments: str) -> set[str]:
        """Run Snakemake, and which rules it ran."""
        printed = self.snakemake(*arguments, "--quiet", "host")
        lines = printed.splitlines()
        starts = [i for i, line in enumerate(lines) if line.startswith("Job stats:")]
        if not starts:
            assert "Nothing to be done" in printed, printed
            return set()
        rules = set()
        for line in lines[starts[0] + 3 :]:
            if not line.strip() or line.startswith("total"):
                break
            rules.add(line.split()[0])
        return rules

    def summary(self, *arguments: str) -> dict[str, list[str]]:
        """Output file → input files, of everything that a target needs."""
        lines = [line.split("\t") for line in self.snakemake(*arguments, "--detailed-summary").splitlines()]
        (heading,) = [line for line in lines if line[0] == "output_file"]
        column = heading.index("input-file(s)")
        return {line[0]: line[column].split(",") for line in lines if len(line) == len(heading)}

    def outputs(self) -> dict[str, bytes]:
        """Contents of the committed kinds of results."""
        return {p.name: p.read_bytes() for p in sorted((self.folder / "paper_figs").iterdir())}


@pytest.fixture(scope="session")
def tiny(tmp_path_factory) -> Copy:
    """A fresh clone in which some targets have run in little."""
    copy = Copy(tmp_path_factory.mktemp("tiny"), TINY)
    copy.before = {p.name: p.stat().st_mtime_ns for p in (copy.folder / "paper_figs").iterdir()}
    copy.printed = copy.snakemake(*TINY_TARGETS)
    return copy


@pytest.fixture(scope="session")
def computed(tmp_path_factory) -> Copy:
    """A fresh clone in which `check` has run on two cores, with a cache between workflows."""
    copy = Copy(tmp_path_factory.mktemp("computed"))
    copy.cache = tmp_path_factory.mktemp("cache")
    copy.before = copy.outputs()
    copy.figures_before = {p.name: p.stat().st_mtime_ns for p in (copy.folder / "paper_figs").iterdir()}
    copy.printed = copy.snakemake("check", cache=copy.cache)
    return copy


@pytest.fixture
def fresh(tmp_path) -> Copy:
    """A fresh clone in which nothing has run."""
    return Copy(tmp_path / "clone")
