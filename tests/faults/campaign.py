"""What a campaign of faults counts, and what all campaigns use: copies of the project, and commands in them."""

import os
import resource
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, field

from tests.support import ROOT
from tests.support import linear_rig as rig
from tests.workflow.conftest import TINY, Copy

# Two chains of a dataset, as Parquet and as NPZ, and its figure: seconds, and every kind of job.
TARGETS = ["fig2", "fig6"]
LONGEST = 240.0  # seconds of a command, after which it counts as hanging


class Budget:
    """When to stop: never, or once each fault was tried and the time is over."""

    end = float("inf")

    @classmethod
    def over(cls, count):
        """Whether a count has a trial and there is no time for another."""
        return count.trials > 0 and time.time() > cls.end


@dataclass
class Count:
    """One row of the table: a fault, what it was tried on, how often, and what was wrong."""

    fault: str
    tried_on: str
    expected: str
    trials: int = 0
    outcomes: dict[str, int] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)

    def add(self, outcome, wrong=None):
        """A trial: a word for what happened, and what should not have."""
        self.trials += 1
        self.outcomes[outcome] = self.outcomes.get(outcome, 0) + 1
        if wrong:
            self.wrong.append(wrong)
            print(f"  WRONG: {self.fault}: {wrong}", flush=True)


class Project(Copy):
    """A copy of the project in which a small target is computed again and again."""

    def __init__(self, folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        super().__init__(folder, TINY)
        self.committed = {p: p.read_bytes() for p in self._figures()}
        self.stamps = {p: p.stat().st_mtime_ns for p in self.committed}

    def _figures(self):
        return sorted(p for t in TARGETS for p in (self.folder / "paper_figs").glob(f"{t}.*"))

    def reset(self):
        """As a fresh clone; only what was read of the sources is kept."""
        shutil.rmtree(self.folder / "results", ignore_errors=True)
        for entry in (self.folder / ".snakemake").glob("*"):
            if entry.is_dir():
                shutil.rmtree(entry)
        for path, content in self.committed.items():
            path.write_bytes(content)
            os.utime(path, ns=(self.stamps[path], self.stamps[path]))

    def results(self):
        """Datasets, estimates and figures, by their names."""
        found = [
            *self._figures(),
            *(self.folder / "results").glob("datasets/*"),
            *self.folder.glob("results/estimates/*"),
        ]
        return {str(p.relative_to(self.folder)): p.read_bytes() for p in found if not p.name.startswith(".")}

    def start(self, *arguments, cores=2, targets=TARGETS, environment=None, prefix=(), **options):
        """Snakemake in a session of its own."""
        command = [*prefix, sys.executable, "-m", "snakemake", f"-c{cores}", *targets, *arguments]
        variables = {**os.environ, "PYTHONPATH": str(self.folder / "src"), **(environment or {})}
        variables.pop("CAMID_RECORDINGS", None)
        return subprocess.Popen(
            [*command, "--configfile", str(TINY)],
            cwd=self.folder,
            env=variables,
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            **options,
        )

    def run(self, *arguments, **options):
        """Exit code and what was printed, of a whole run."""
        return ended(self.start(*arguments, **options))

    def wrong_after(self, reference, *arguments):
        """What is wrong once the same command was given again; None if it ended in the same bytes."""
        code, printed = self.run(*arguments)
        if code != 0:
            return f"the rerun ended with {code}: {printed[-400:]}"
        results = self.results()
        if set(results) != set(reference):
            return f"other files: {sorted(set(results) ^ set(reference))}"
        different = sorted(name for name in reference if results[name] != reference[name])
        return f"other bytes: {different}" if different else None


def ended(process):
    """Exit code and what was printed; a process that hangs is killed, and the code is "hang"."""
    try:
        printed = process.communicate(timeout=LONGEST)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        return "hang", process.communicate()[0]
    return process.returncode, printed


def camid(arguments, folder, *, memory=None, largest_file=None, prefix=(), environment=None):
    """A camid command in a session of its own, with limits of its address space and of its files in bytes."""
    variables = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}", **(environment or {})}
    if largest_file is not None:  # Python itself would leave its compiled modules cut short, for all later trials
        variables["PYTHONDONTWRITEBYTECODE"] = "1"
    process = subprocess.Popen(
        [*prefix, sys.executable, "-m", "camid", *map(str, arguments)],
        cwd=folder,
        env=variables,
        start_new_session=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    for kind, limit in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_FSIZE, largest_file)):
        if limit is not None:
            resource.prlimit(process.pid, kind, (limit, limit))
    return process


def bench(folder):
    """A folder with a recording and its simulation."""
    folder.mkdir(parents=True, exist_ok=True)
    rig.recording().to_csv(folder / "recording.csv", index=False)
    rig.write_yaml(rig.simulation(), folder / "S.yaml")
    return folder


def refused_in_one_line(code, printed):
    """What is wrong with a refusal; None for exit code 2 and one line."""
    lines = [line for line in printed.splitlines() if not line.startswith("camid: warning: ")]
    if code == 2 and len(lines) == 1 and lines[0].startswith("camid: error: "):
        return None
    return f"exit code {code}: {printed[-300:]}"


def progress(text):
    """A line with the time, for people who wait."""
    print(f"[{time.strftime('%H:%M:%S')}] {text}", flush=True)
