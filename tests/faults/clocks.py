"""A clock that jumps: by libfaketime where it is installed, else by the times of the files that it would have left."""

import os
import time
from pathlib import Path

from tests.faults.campaign import Budget, Count, progress

LIBRARIES = (
    "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1",
    "/usr/lib/aarch64-linux-gnu/faketime/libfaketime.so.1",
)
JUMPS = ("-3d", "+40m")
DURING = ("-1h", "+1h", "-5s")
DAY = 86400.0


def library():
    """libfaketime, from Debian's package of that name."""
    return next((path for path in LIBRARIES if Path(path).is_file()), None)


def faked(jump):
    # The monotonic clock and the times of files are those of the system, which no jump of the wall clock touches.
    return {"LD_PRELOAD": library(), "FAKETIME": jump, "FAKETIME_DONT_FAKE_MONOTONIC": "1", "NO_FAKE_STAT": "1"}


def whole_runs(project, reference, count):
    """A run under a clock that is wrong, then one under the right one."""
    for jump in JUMPS:
        if Budget.over(count):
            break
        project.reset()
        code, printed = project.run(environment=faked(jump))
        wrong = None if code == 0 else f"{jump}: exit code {code}: {printed[-1500:]}"
        count.add("same bytes", wrong or project.wrong_after(reference))
        # And back: everything is made again under the wrong clock, over results of the right one.
        code, printed = project.run("--forceall", environment=faked(jump))
        wrong = None if code == 0 else f"back to {jump}: exit code {code}: {printed[-1500:]}"
        count.add("same bytes", wrong or project.wrong_after(reference))


def set_clock(file, jump):
    """Let processes that look at a file have another time; whenever they look, the file is whole."""
    new = file.with_suffix(".new")
    new.write_text(f"{jump}\n")
    new.replace(file)


def during_a_run(project, reference, seconds, folder, random, count):
    """The clock jumps while jobs run; the rerun has the right clock again."""
    folder.mkdir(parents=True, exist_ok=True)
    for jump in DURING:
        if Budget.over(count):
            break
        project.reset()
        file = folder / "faketime"
        set_clock(file, "+0")
        variables = {k: v for k, v in faked(jump).items() if k != "FAKETIME"}
        variables |= {"FAKETIME_TIMESTAMP_FILE": str(file), "FAKETIME_NO_CACHE": "1"}
        process = project.start(environment=variables)
        time.sleep(random.uniform(0.5, 1.0) * seconds)
        set_clock(file, jump)
        try:
            process.communicate(timeout=60)
            outcome = "same bytes"
        except Exception:
            os.killpg(process.pid, 9)  # what a user would do who sees nothing happen
            process.communicate()
            outcome = "stood still, killed, same bytes after the rerun"
        count.add(outcome, project.wrong_after(reference))


def times_of_files(project, reference, random, count):
    """Files from the future and from the past, as a clock that was set back or forth leaves them."""
    for _ in range(4):
        if Budget.over(count):
            break
        project.reset()
        code, printed = project.run()
        if code != 0:
            count.add("no results", f"the first run ended with {code}: {printed[-400:]}")
            continue
        shift = random.choice([-3.0, -0.1, 0.1, 3.0]) * DAY
        files = sorted(p for p in (project.folder / "results").rglob("*") if p.is_file())
        for path in random.sample(files, len(files) // 2):
            stamp = path.stat().st_mtime + shift
            os.utime(path, (stamp, stamp))
        # Something to do: a figure, and what it is drawn from.
        for removed in (*project.folder.glob("results/estimates/*.parquet"), project.folder / "paper_figs/fig6.png"):
            removed.unlink()
        count.add("same bytes", project.wrong_after(reference))


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    wrong_clock = Count(
        "wrong clock, then the right one", f"the workflow in little; {', '.join(JUMPS)}", "the same bytes"
    )
    jumping = Count("clock that jumps during a run", f"the workflow in little; {', '.join(DURING)}", "the same bytes")
    files = Count("results from the future or the past", "half of the files, by hours or days", "the same bytes")
    progress("clocks" if library() else "clocks (libfaketime is not installed: times of files only)")
    if library():
        whole_runs(project, reference, wrong_clock)
        during_a_run(project, reference, seconds, folder, random, jumping)
    times_of_files(project, reference, random, files)
    return [count for count in (wrong_clock, jumping, files) if count.trials]
