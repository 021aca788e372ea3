"""``python -m tests.versions``: the tests with the oldest and the newest allowed packages, on all Pythons here.

Needs uv. Each environment is made anew in ``results/versions``; counts go to the terminal and into
``results/test-versions.json``, from which ``--page`` alone writes the table of docs/versions.md. Exit code 1 if a test
failed.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from tests.faults.page import cell, with_table
from tests.support import ROOT

FOLDER = ROOT / "results/versions"
RESULT = ROOT / "results/test-versions.json"
PAGE = ROOT / "docs/versions.md"
BEGIN, END = "<!-- table: python -m tests.versions --page -->", "<!-- end of the table -->"
HEADING = (
    "| packages | Python | numpy, scipy, pandas, numba, pydantic | tests | passed | skipped | failed | minutes |\n"
    "|---|---|---|---|---:|---:|---:|---:|\n"
)
PYTHONS = ("3.11", "3.12", "3.13")
# The oldest packages are those of the oldest Python: newer ones need newer packages than the bounds say.
ENVIRONMENTS = [("oldest", PYTHONS[0]), *(("newest", python) for python in PYTHONS)]
RESOLUTIONS = {"oldest": "lowest-direct", "newest": "highest"}
EXTRAS = ("--extra", "workflow", "--extra", "development")
SHOWN = ("numpy", "scipy", "pandas", "numba", "pydantic")
# What meets other people's packages: files and their formats, compiled code, videos, the command line.
TELLING = ("recording", "simulation", "chain", "tracking", "engine", "cli")


@dataclass
class Environment:
    """Packages of one age on one Python."""

    packages: str
    python: str

    @property
    def name(self):
        return f"{self.packages}-{self.python}"

    @property
    def interpreter(self):
        return FOLDER / self.name / "bin/python"

    def make(self):
        """Install; what went wrong, None if nothing did."""
        FOLDER.mkdir(parents=True, exist_ok=True)
        python = interpreter_of(self.python)
        if python is None:
            return f"no Python {self.python} on this machine"
        lock = FOLDER / f"{self.name}.txt"
        where = ("--python", python, "pyproject.toml", "--output-file", str(lock))
        for command in (
            ("pip", "compile", "--quiet", "--no-header", "--resolution", RESOLUTIONS[self.packages], *EXTRAS, *where),
            ("venv", "--quiet", "--clear", "--python", python, str(FOLDER / self.name)),
            ("pip", "install", "--quiet", "--python", str(self.interpreter), "--requirement", str(lock)),
        ):
            done = uv(*command)
            if done.returncode != 0:
                return f"uv {command[0]}: {done.stderr[-300:].strip()}"
        return None

    def versions(self):
        """Of Python, and of the packages that the table names."""
        program = (
            "import platform, sys; from importlib.metadata import version; "
            "print(platform.python_version(), *map(version, sys.argv[1:]))"
        )
        done = subprocess.run([self.interpreter, "-c", program, *SHOWN], capture_output=True, text=True, check=True)
        python, *packages = done.stdout.split()
        return python, ", ".join(packages)

    def test(self, tests, cores):
        """Counts of a run of the tests."""
        report = FOLDER / f"{self.name}.xml"
        report.unlink(missing_ok=True)
        variables = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
        command = [self.interpreter, "-m", "pytest", "-q", "-n", str(cores), "--dist", "loadfile"]
        command += ["-p", "no:cacheprovider", f"--junitxml={report}", *tests]
        subprocess.run(command, cwd=ROOT, env=variables, check=False)
        if not report.exists():
            return {"passed": 0, "skipped": 0, "failed": ["the tests could not be collected"]}
        cases = list(ElementTree.parse(report).iter("testcase"))
        failed = [f"{c.get('classname')}::{c.get('name')}" for c in cases if {"failure", "error"} & {e.tag for e in c}]
        skipped = sum(c.find("skipped") is not None for c in cases)
        return {"passed": len(cases) - len(failed) - skipped, "skipped": skipped, "failed": failed}


def interpreter_of(version):
    """An interpreter of a version: pyenv's, whose own commands stand for one version at a time, or of the path."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = [*sorted(pyenv.glob(f"versions/{version}.*/bin/python")), shutil.which(f"python{version}")]
    for path in filter(None, found):
        if subprocess.run([path, "--version"], capture_output=True, check=False).returncode == 0:
            return str(path)
    return None


def uv(*arguments):
    return subprocess.run(["uv", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)


def table(content):
    """The table of docs/versions.md."""
    lines = [HEADING]
    for row in content.values():
        cells = (row["packages"], row["python"], row["versions"], row["tests"])
        counts = (row["passed"], row["skipped"], len(row["failed"]), f"{row['seconds'] / 60:.0f}")
        lines.append(f"| {' | '.join(map(cell, (*cells, *counts)))} |\n")
    return "".join(lines)


def keep(row, name):
    RESULT.parent.mkdir(exist_ok=True)
    content = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.exists() else {}
    content[name] = row
    RESULT.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def run(environment, tests, cores):
    """The tests in one environment; whether all passed."""
    print(f"{environment.name}: installing", flush=True)
    if why := environment.make():
        print(f"{environment.name}: {why}", flush=True)
        return not why.startswith("uv")
    python, versions = environment.versions()
    print(f"{environment.name}: Python {python}; {', '.join(SHOWN)} {versions}", flush=True)
    before = time.time()
    counts = environment.test(tests, cores)
    row = {"packages": environment.packages, "python": python, "versions": versions}
    row |= {"tests": "all" if not tests else "part", "seconds": time.time() - before, **counts}
    keep(row, environment.name)
    for test in counts["failed"]:
        print(f"  FAILED {test}")
    print(
        f"{environment.name}: {counts['passed']} passed, {len(counts['failed'])} failed, {counts['skipped']} skipped",
        flush=True,
    )
    return not counts["failed"]


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.versions", description=__doc__)
    names = [Environment(*e).name for e in ENVIRONMENTS]
    parser.add_argument("environments", nargs="*", help=f"of {', '.join(names)} [all]")
    parser.add_argument("--all", action="store_true", help="all tests, not only those that meet other packages")
    parser.add_argument("--cores", type=int, default=2, help="workers of the tests [2]")
    parser.add_argument("--page", action="store_true", help="only write the table of docs/versions.md")
    chosen = parser.parse_args()
    if not chosen.page:
        if unknown := set(chosen.environments) - set(names):
            parser.error(f"not known: {', '.join(sorted(unknown))}")
        tests = [] if chosen.all else [f"tests/{name}" for name in TELLING]
        wanted = [Environment(*e) for e in ENVIRONMENTS if Environment(*e).name in (chosen.environments or names)]
        passed = [run(environment, tests, chosen.cores) for environment in wanted]
        return 0 if all(passed) else 1
    if not RESULT.exists():
        sys.exit(f"{RESULT} is missing: call make test-versions first")
    content = json.loads(RESULT.read_text(encoding="utf-8"))
    content = {name: content[name] for name in names if name in content}
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), table(content), BEGIN, END), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
