"""A campaign on Slurm and on the local executor: the same bytes, also where jobs, nodes or Snakemake are killed."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pandas as pd

from tests.faults.campaign import Count, progress
from tests.support import ROOT
from tests.workflow.conftest import Copy

CONFIGURATION = ROOT / "tests/slurm/campaign.yaml"
PROFILE = "workflow/profiles/slurm"
# As the profile, but for a machine that answers at once: a test is no reason to wait.
QUICK = (
    "--slurm-init-seconds-before-status-checks",
    "3",
    "--latency-wait",
    "15",
    "--seconds-between-status-checks",
    "2",
)
TARGETS = ("results/monte_carlo/all.parquet", "concealed_sample")
# Of the configuration beside this file.
SHARDS, SEEDS = 4, 40
LONGEST = 900.0
SECONDS_FOR_A_JOB = 120.0


class Clone(Copy):
    """A fresh clone that computes on Slurm or here."""

    def start(self, *, slurm, cores=2):
        """Snakemake in a session of its own; what it prints goes to ``snakemake.log`` in the clone."""
        how = ["--profile", PROFILE, *QUICK] if slurm else [f"-c{cores}"]
        variables = {**os.environ, "PYTHONPATH": str(self.folder / "src")}
        for name in ("CAMID_RECORDINGS", "SNAKEMAKE_OUTPUT_CACHE"):
            variables.pop(name, None)
        self.printed = self.folder / "snakemake.log"
        with self.printed.open("w") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "snakemake", *how, "--configfile", str(CONFIGURATION), "--", *TARGETS],
                cwd=self.folder,
                env=variables,
                start_new_session=True,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def run(self, **how):
        """Exit code and what was printed, of a whole run."""
        return self.ended(self.start(**how))

    def ended(self, process):
        """Exit code and what was printed; one that hangs is killed."""
        try:
            code = process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            code = "hang"
        return code, self.printed.read_text(encoding="utf-8", errors="replace")

    def results(self):
        """What was computed, by name; not the salt of the seals, which is drawn anew, nor run times."""
        found = [*(self.folder / "results").rglob("*"), *(self.folder / "paper_figs").glob("concealed_sample*")]
        return {
            str(p.relative_to(self.folder)): p.read_bytes() for p in found if p.is_file() and not depends_on_the_run(p)
        }


def depends_on_the_run(path):
    """Whether a file holds random or measured numbers: salt and seals, times of day, run times, logs."""
    parts = {path.name, *(parent.name for parent in path.parents)}
    return path.name.startswith(".") or bool(
        parts & {"logs", "salt", "seals", "run_times", "run_times.parquet", "diagnoses", "code_digests.json"}
    )


def difference(found, reference):
    """What differs from the reference; None where nothing does."""
    if set(found) != set(reference):
        return f"other files: {sorted(set(found) ^ set(reference))[:6]}"
    other = sorted(name for name in reference if found[name] != reference[name])
    return f"other bytes: {other[:6]}" if other else None


def counted_twice(folder):
    """Each period and parameter has as many fits as there are seeds, no shard more than once; None if so."""
    table = pd.read_parquet(folder / "results/monte_carlo/all.parquet")
    if set(table["fits"]) != {SEEDS} or table.duplicated(["period", "parameter"]).any():
        return f"fits {sorted(set(table['fits']))}, {SEEDS} seeds were asked for"
    shards = list((folder / f"results/monte_carlo/{SEEDS}_seeds").glob("*.parquet"))
    return None if len(shards) == SHARDS else f"{len(shards)} shards of {SHARDS}"


def scripts_of(cluster, job):
    """Processes of a job that compute: those that run a script of the workflow."""
    found = []
    for pid in cluster.job_processes(job):
        with suppress(OSError):
            with open(f"/proc/{pid}/cmdline", "rb") as stream:
                words = stream.read().split(b"\0")
            if b"python" in words[0] and any(b"/.snakemake/scripts/" in word for word in words[1:2]):
                found.append(pid)
    return found


def wait_for_a_job(cluster, process, find):
    """What ``find`` finds of a running job, as soon as it finds something; nothing if Snakemake ends before."""
    end = time.monotonic() + SECONDS_FOR_A_JOB
    while process.poll() is None and time.monotonic() < end:
        for job in cluster.running():
            if found := find(job):
                return job, found
        time.sleep(0.1)
    return None, []


def kill(pids):
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def kill_job(cluster, process):
    """The process that computes is killed, as by a machine without memory."""
    job, pids = wait_for_a_job(cluster, process, lambda job: scripts_of(cluster, job))
    kill(pids)
    return job


def kill_step_daemon(cluster, process):
    """Slurm's own process over the job is killed; the job goes on unseen until Slurm misses it."""
    job, _ = wait_for_a_job(cluster, process, lambda job: scripts_of(cluster, job))
    if job is not None:
        kill(cluster.step_daemons(job))
    return job


def kill_node(cluster, process):
    """The node's daemon and everything that it started are killed; the node comes back half a minute later."""
    job, _ = wait_for_a_job(cluster, process, lambda job: scripts_of(cluster, job))
    if job is not None:
        cluster.kill_node()
        time.sleep(30.0)
        cluster.start_node()
    return job


def kill_snakemake(cluster, process):
    """The Snakemake that submits is killed; its jobs go on, and the same command is given again at once."""
    job, _ = wait_for_a_job(cluster, process, lambda job: scripts_of(cluster, job))
    if job is not None:
        os.killpg(process.pid, signal.SIGKILL)
    return job


KILLS = {
    "SIGKILL of a job's process on the node": kill_job,
    "SIGKILL of the `slurmstepd` of a job": kill_step_daemon,
    "SIGKILL of the node: `slurmd` and all jobs": kill_node,
    "SIGKILL of the Snakemake that submits": kill_snakemake,
}
TRIED = "Monte Carlo and concealed recordings in little"


def without_faults(cluster, clone, reference):
    """On Slurm, nothing killed."""
    count = Count("Slurm instead of the local executor", TRIED, "the same bytes")
    before = time.monotonic()
    code, printed = clone.run(slurm=True)
    submitted = printed.count("has been submitted with SLURM jobid")
    progress(f"{submitted} jobs on Slurm in {time.monotonic() - before:.0f} s")
    wrong = None if code == 0 else f"exit code {code}: {printed[-1500:]}"
    count.add("same bytes", wrong or difference(clone.results(), reference) or counted_twice(clone.folder))
    return count


def with_kill(cluster, clone, reference, fault):
    """One trial of a kill."""
    count = Count(fault, TRIED, "tried again by itself: the same bytes, nothing counted twice")
    process = clone.start(slurm=True)
    job = KILLS[fault](cluster, process)
    code, printed = clone.ended(process)
    outcome = "retried, same bytes"
    if KILLS[fault] is kill_snakemake:
        count.expected = "the same command ends in the same bytes, nothing counted twice"
        outcome = "same command again, same bytes"
        code, printed = clone.run(slurm=True)
    elif job is not None and "Trying to restart job" not in printed:
        count.add("not noticed", f"no word of a retry: {printed[-800:]}")
        return count
    wrong = None if code == 0 else f"exit code {code}: {printed[-1500:]}"
    cluster.wait_until_empty()  # jobs of a killed Snakemake may still write what they compute: the same bytes
    wrong = wrong or difference(clone.results(), reference) or counted_twice(clone.folder)
    count.add(outcome if job is not None else "had ended before", wrong)
    return count
