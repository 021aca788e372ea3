"""``python -m tests.slurm``: a real Slurm on this machine, a campaign on it, and what is killed meanwhile.

Needs Debian's packages munge, slurmctld, slurmd and slurm-client, the superuser, and Snakemake's Slurm plugin
(``make slurm``). Counts go to the terminal and into results/; exit code 1 if anything was wrong.
"""

import argparse
import shutil
import signal
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

from tests.faults.__main__ import keep
from tests.faults.campaign import progress
from tests.slurm.campaign import CONFIGURATION, KILLS, Clone, with_kill, without_faults
from tests.slurm.cluster import one_machine, refusal


def main():
    argparse.ArgumentParser(prog="python -m tests.slurm", description=__doc__).parse_args()
    why = refusal()
    if why is None and find_spec("snakemake_executor_plugin_slurm") is None:
        why = "Snakemake's Slurm plugin is not installed: make slurm"
    if why is not None:
        print(f"no Slurm is started: {why}")
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # daemons and folders are put away then, too
    started = time.time()
    folder = Path(tempfile.mkdtemp(prefix="camid-slurm-"))
    try:
        rows = run(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    for row in rows:
        outcomes = "; ".join(f"{n} {what}" for what, n in row.outcomes.items())
        print(f"{'WRONG' if row.wrong else 'right'}  {row.trials:5}  {row.fault}: {outcomes}", flush=True)
    wrong = sum(len(row.wrong) for row in rows)
    seconds = time.time() - started
    print(f"{sum(row.trials for row in rows)} trials on Slurm in {seconds / 60.0:.1f} min: {wrong} wrong")
    keep("slurm", [], seconds, rows)
    return 1 if wrong else 0


def run(folder):
    """Rows of the table."""
    # All clones are made before anything runs: who edits meanwhile changes nothing.
    local, slurm, *others = [Clone(folder / f"clone {number}", CONFIGURATION) for number in range(2 + len(KILLS))]
    progress("the reference, on the local executor")
    code, printed = local.run(slurm=False)
    assert code == 0, printed
    reference = local.results()
    rows = []
    with one_machine(folder / "cluster") as cluster:
        progress("on Slurm")
        rows.append(without_faults(cluster, slurm, reference))
        for fault, clone in zip(KILLS, others, strict=True):
            progress(fault)
            rows.append(with_kill(cluster, clone, reference, fault))
    return rows


if __name__ == "__main__":
    sys.exit(main())
