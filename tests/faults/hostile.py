"""Hostile files, names and numbers, each in a process of its own with a limit of memory and time."""

import contextlib
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

from tests.faults.campaign import Count, bench, camid, ended, progress, refused_in_one_line
from tests.support import ROOT, hostile_files, hostile_numbers
from tests.support import linear_rig as rig

MEMORY = 8 * 2**30  # bytes of address space; half of it is libraries and what a recording may have
UNPACKED = 2**30
FUZZED = ("csv", "parquet", "mat", "hdf5", "yaml", "video")
FUZZ_SECONDS = 75
EXAMPLES = 600
NAMES = (
    *hostile_numbers.NAMES,
    hostile_files.SCRIPT,
    '"><img src=x onerror=alert(1)>',
    "{{ 7 * 7 }}",
    "y\u202e",
    "a\tb",
)
SEVERAL_READERS = [["identify", "{}", "--simulation", "S.yaml"], ["init", "recording", "{}", "--output", "draft.yaml"]]


def run_all(jobs):
    """Exit code and output of commands, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda job: ended(camid(*job, memory=MEMORY)), jobs))


def hostile_inputs(folder, count_recordings, count_yaml, count_videos):
    os.chdir(bench(folder))
    owned = folder / "owned"
    (folder / "recordings").mkdir()
    files = hostile_files.recordings(folder / "recordings", unpacked=UNPACKED)
    progress(f"{len(files)} hostile recordings")
    jobs = [([a.format(p) for a in form], folder) for p in files for form in SEVERAL_READERS]
    for job, (code, printed) in zip(jobs, run_all(jobs), strict=True):
        wrong = None if code == 0 and "Traceback" not in printed else refused_in_one_line(code, printed)
        count_recordings.add("read" if code == 0 else "refused in one line", wrong and f"{job[0]}: {wrong}")
    texts = hostile_files.simulations(owned)
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    jobs = [(["identify", "recording.csv", "--simulation", f"{name}.yaml"], folder) for name in texts]
    for job, (code, printed) in zip(jobs, run_all(jobs), strict=True):
        wrong = refused_in_one_line(code, printed)
        count_yaml.add(
            "refused in one line", (wrong and f"{job[0]}: {wrong}") or ("code was run" if owned.exists() else None)
        )
    (folder / "videos").mkdir()
    sources = hostile_files.videos(folder / "videos")
    jobs = [(["track", str(p), "--bright", "--frame-rate", "50", "--output", "t.csv"], folder) for p in sources]
    for job, (code, printed) in zip(jobs, run_all(jobs), strict=True):
        wrong = refused_in_one_line(code, printed)
        count_videos.add("refused in one line", wrong and f"{job[0]}: {wrong}")


def hostile_names(folder, count):
    """Names of columns and files that are markup, shell or paths elsewhere: a diagnosis with its report."""
    table = rig.recording(300)
    bench(folder)
    jobs = []
    for number, name in enumerate(NAMES):
        place = folder / f"{number} · $(touch owned); <b> & 'x'"
        place.mkdir()
        table.rename(columns={"y": name}).to_csv(place / "rec <script>.csv", index=False)
        rig.write_yaml(rig.simulation(sensor={"column": name, "kind": "camera"}), place / "S.yaml")
        arguments = ["diagnose", "rec <script>.csv", "--simulation", "S.yaml", "--output", "out", "--time-limit", "2"]
        jobs.append((arguments, place))
    for (_, place), name, (code, printed) in zip(jobs, NAMES, run_all(jobs), strict=True):
        made = sorted(p.name for p in place.iterdir())
        wrong = None if code == 0 else refused_in_one_line(code, printed)
        if code == 0 and made != ["S.yaml", "out", "rec <script>.csv"]:
            wrong = f"{name}: made {made}"
        page = place / "out/report.html"
        if code == 0 and (active := active_markup(page.read_text(encoding="utf-8"))):
            wrong = f"{name}: {active}"
        count.add("escaped, nothing run" if code == 0 else "refused in one line", wrong)


def active_markup(page):
    """What of a hostile name would be markup in a page."""
    return [text for text in (hostile_files.SCRIPT, "<b>y</b>", "<img src=x", "<b> &", "rec <script>") if text in page]


def numbers(count, random):
    """Commands on columns that no machine ever recorded, in this process."""

    @seed(random.randrange(2**31))
    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        derandomize=False,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(hostile_numbers.tables(), hostile_numbers.COMMANDS, hostile_numbers.SETTINGS)
    def once(recorded, command, chosen):
        with tempfile.TemporaryDirectory() as folder:
            try:
                wrong, code = hostile_numbers.answer(Path(folder), recorded, command, chosen)
            except Exception as error:  # a traceback at the command line
                wrong, code = (
                    f"{type(error).__name__}: {error} ({command}, {chosen}, {recorded[1].head(3)})",
                    "traceback",
                )
        count.add({0: "result", 2: "refused in one line"}.get(code, str(code)), wrong)

    once()


def long_recording(folder, count):
    """Ten million rows: the commands that take them, and the refusals of those that do not."""
    program = (
        "import numpy as np, pandas as pd; n = 10**7;"
        "u = np.repeat(np.random.default_rng(1).uniform(-1, 1, n // 4), 4);"
        "pd.DataFrame({'t': 0.05 * np.arange(n), 'u': u, 'y': np.roll(u, 3)}).to_parquet('long.parquet')"
    )
    subprocess.run([sys.executable, "-c", program], cwd=bench(folder), check=True)
    for arguments in (
        ["simulate", "long.parquet", "--simulation", "S.yaml", "--output", "long-simulated.parquet"],
        ["identify", "long.parquet", "--simulation", "S.yaml"],
        ["diagnose", "long.parquet", "--simulation", "S.yaml", "--output", "out", "--no-report"],
    ):
        code, printed = ended(camid(arguments, folder, memory=2 * MEMORY))
        wrong = None if code == 0 else refused_in_one_line(code, printed)
        count.add("result" if code == 0 else "refused in one line", wrong and f"{arguments[0]}: {wrong}")


def fuzz(folder, random, counts):
    """The readers under a fuzzer that follows coverage, two at a time."""
    if find_spec("atheris") is None:
        progress("atheris is not installed: no fuzzing (make test-faults installs it where there is one)")
        return
    folder.mkdir(parents=True)
    jobs = [(reader, str(random.randrange(1, 2**31))) for reader in FUZZED]

    def one(job):
        reader, start = job
        place = folder / reader
        place.mkdir()
        command = [sys.executable, "-m", "tests.faults.readers", reader, str(FUZZ_SECONDS), start]
        variables = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
        variables["PYTHONPATH"] += os.pathsep + os.environ.get("PYTHONPATH", "")
        with contextlib.suppress(subprocess.TimeoutExpired):
            done = subprocess.run(
                command, cwd=place, env=variables, capture_output=True, text=True, timeout=3 * FUZZ_SECONDS, check=False
            )
            return done.returncode, done.stdout + done.stderr
        return "hang", ""

    progress(f"fuzzing {len(jobs)} readers for {FUZZ_SECONDS} s each")
    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(one, jobs))
    for (reader, _), (code, printed) in zip(jobs, answers, strict=True):
        runs = re.search(r"Done (\d+) runs", printed)
        count = counts[reader]
        count.trials = int(runs[1]) if runs else 1
        count.outcomes = {"read, or refused by an InputError": count.trials}
        if code != 0:
            count.wrong.append(f"{reader}: exit code {code}: {printed[-600:]}")


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    del project, reference, seconds
    refusal = "a result, or one line and exit code 2; no hang, no more than 8 GiB"
    recordings, simulations, videos, names = (
        Count("hostile files", tried, refusal)
        for tried in (
            "recordings: archives, HDF5, MAT, Parquet, sheets that unpack to gigabytes; circles, links, pipes",
            "simulations: billion laughs, nesting, code, circles",
            "videos: pictures of 10 gigapixels, playlists, pipes",
            "column, file and folder names: markup, shell, paths, other scripts",
        )
    )
    extremes = Count(
        "hostile numbers",
        "NaN, infinities, constants, subnormals, scales of 1e±300, two rows, repeated columns and names (hypothesis)",
        "a result, or one line and exit code 2",
    )
    long = Count("ten million rows", "`camid simulate`, `identify`, `diagnose`", refusal)
    fuzzed = {
        reader: Count(
            "coverage-guided fuzzing", f"reader of {reader} ({FUZZ_SECONDS} s)", "read, or refused by an InputError"
        )
        for reader in FUZZED
    }
    here = Path.cwd()
    try:
        hostile_inputs(folder / "files", recordings, simulations, videos)
    finally:
        os.chdir(here)
    progress("hostile names")
    hostile_names(folder / "names", names)
    progress("hostile numbers")
    numbers(extremes, random)
    progress("ten million rows")
    long_recording(folder / "long", long)
    fuzz(folder / "fuzz", random, fuzzed)
    return [c for c in (recordings, simulations, videos, names, extremes, long, *fuzzed.values()) if c.trials]
