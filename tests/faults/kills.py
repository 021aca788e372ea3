"""SIGKILL at random moments: of the workflow with its jobs, of the workflow alone, of a job, of a command."""

import os
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

from tests.faults.campaign import TARGETS, Budget, Count, bench, camid, ended, progress

TRIALS = {"workflow": 24, "alone": 14, "worker": 18, "command": 24}
# The first part of a run only reads the Snakefile.
EARLIEST = 0.2


def workers(session):
    """Processes of a session that run a script of the workflow."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, ValueError):
            command = (entry / "cmdline").read_bytes().split(b"\0")
            of_session = int((entry / "stat").read_text().rpartition(")")[2].split()[3]) == session
            if of_session and b"python" in command[0] and any(b"/.snakemake/scripts/" in part for part in command[1:2]):
                found.append(int(entry.name))
    return found


def kill_worker(process, moment):
    """Kill a job at a moment, or the next one that there is; whether there was one."""
    while process.poll() is None:
        if time.perf_counter() >= moment:
            for pid in workers(process.pid):
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                    return True
        time.sleep(0.01)
    return False


def kill_workflow(project, reference, seconds, random, counts):
    """Trials of the three ways to kill a workflow, in turns."""
    ways = [way for way in ("workflow", "alone", "worker") for _ in range(TRIALS[way])]
    random.shuffle(ways)
    for number, way in enumerate(ways, 1):
        if Budget.over(counts[way]):
            continue
        if number % 8 == 0:
            progress(f"kill {number} of {len(ways)}")
        project.reset()
        process = project.start()
        moment = time.perf_counter() + random.uniform(EARLIEST, 1.0) * seconds
        if way == "worker":
            hit = kill_worker(process, moment)
            ended(process)
        else:
            with suppress(subprocess.TimeoutExpired):
                process.wait(max(moment - time.perf_counter(), 0.0))
            hit = process.poll() is None
            with suppress(ProcessLookupError):
                (os.killpg if way == "workflow" else os.kill)(process.pid, signal.SIGKILL)
            process.wait()
        wrong = project.wrong_after(reference)
        with suppress(ProcessLookupError):  # what still runs of the killed one
            os.killpg(process.pid, signal.SIGKILL)
        process.stdout.close()
        counts[way].add("killed, same bytes after the rerun" if hit else "had ended before", wrong)


def kill_commands(folder, random, count):
    """A command is killed at a random moment: its output is the old one or the new one, each whole."""
    bench(folder)
    arguments = ["simulate", "recording.csv", "--simulation", "S.yaml", "--output", "simulated.csv"]
    start = time.perf_counter()
    ended(camid(arguments, folder))
    seconds = time.perf_counter() - start
    output, inputs = folder / "simulated.csv", {}
    new = output.read_bytes()
    inputs = {name: (folder / name).read_bytes() for name in ("recording.csv", "S.yaml")}
    for _ in range(TRIALS["command"]):
        if Budget.over(count):
            break
        output.write_bytes(b"an older result\n")
        process = camid(arguments, folder)
        with suppress(subprocess.TimeoutExpired):
            process.wait(random.uniform(0.3, 1.1) * seconds)
        hit = process.poll() is None
        process.kill()
        ended(process)
        found = output.read_bytes()
        wrong = None if found in (b"an older result\n", new) else f"{len(found)} bytes of {len(new)}"
        if any((folder / name).read_bytes() != content for name, content in inputs.items()):
            wrong = "an input was changed"
        count.add("killed, old or new result whole" if hit else "had ended before", wrong)


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    tried = f"`snakemake -c2 {' '.join(TARGETS)}` in little"
    same = "the same command ends in the same bytes"
    counts = {
        "workflow": Count("SIGKILL of the workflow with its jobs", tried, same),
        "alone": Count("SIGKILL of the workflow alone, whose jobs go on", tried, same),
        "worker": Count("SIGKILL of a job", tried, same),
        "command": Count(
            "SIGKILL of a command", "`camid simulate` over an older result", "the old or the new file, whole"
        ),
    }
    kill_commands(folder / "command", random, counts["command"])
    kill_workflow(project, reference, seconds, random, counts)
    return list(counts.values())
