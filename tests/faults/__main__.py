"""``python -m tests.faults``: every campaign, or those that are named; counts go to the terminal and into results/.

Exit code 1 if anything was wrong.
"""

import argparse
import json
import os
import random
import shutil
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

from tests.faults import clocks, determinism, hostile, kills, storage, together
from tests.faults.campaign import Budget, Project, progress
from tests.support import ROOT

CAMPAIGNS = {
    "kills": kills.campaign,
    "storage": storage.campaign,
    "together": together.campaign,
    "clocks": clocks.campaign,
    "determinism": determinism.campaign,
    "hostile": hostile.campaign,
}
# Of the time for all: a campaign that is over sooner leaves its rest to nobody.
SHARES = {"kills": 0.5, "storage": 0.1, "together": 0.05, "clocks": 0.1, "determinism": 0.05, "hostile": 0.2}
RESULT = ROOT / "results/test-faults.json"


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("campaigns", nargs="*", help=f"of {', '.join(CAMPAIGNS)} [all]")
    parser.add_argument("--seed", type=int, default=17, help="of the moments and places of the faults [17]")
    parser.add_argument("--minutes", type=float, default=30.0, help="for all; then one trial of each fault [30]")
    parser.add_argument("--add", action="store_true", help="to the counts of earlier runs; give another seed")
    chosen = parser.parse_args()
    started = time.time()
    os.environ.pop("SNAKEMAKE_OUTPUT_CACHE", None)
    folder = Path(tempfile.mkdtemp(prefix="camid-faults-"))
    try:
        rows = run(chosen.campaigns or list(CAMPAIGNS), chosen.seed, folder, chosen.minutes, add=chosen.add)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    wrong = [f"{row.fault}: {sentence}" for row in rows for sentence in row.wrong]
    trials = sum(row.trials for row in rows)
    print(f"{trials} trials of {len(rows)} kinds in {(time.time() - started) / 60.0:.1f} min: {len(wrong)} wrong")
    return 1 if wrong else 0


def keep(name, seeds, seconds, rows, *, add=False):
    """Put the counts of a campaign beside those of the others; add them to those of its earlier runs if wanted."""
    RESULT.parent.mkdir(exist_ok=True)
    content = json.loads(RESULT.read_text(encoding="utf-8")) if RESULT.exists() else {}
    new = {"seeds": seeds, "seconds": round(seconds), "rows": [asdict(row) for row in rows]}
    content[name] = added(content[name], new) if add and name in content else new
    RESULT.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def added(old, new):
    """Counts of two runs of a campaign."""
    rows = {(row["fault"], row["tried_on"]): row for row in old["rows"]}
    for row in new["rows"]:
        known = rows.setdefault((row["fault"], row["tried_on"]), row)
        if known is not row:
            known["trials"] += row["trials"]
            known["wrong"] += row["wrong"]
            for what, number in row["outcomes"].items():
                known["outcomes"][what] = known["outcomes"].get(what, 0) + number
    seeds = sorted({*old["seeds"], *new["seeds"]})
    return {"seeds": seeds, "seconds": old["seconds"] + new["seconds"], "rows": list(rows.values())}


def run(names, seed, folder, minutes, *, add):
    """Rows of some campaigns."""
    project = Project(folder / "project")
    progress("the reference")
    project.reset()
    project.run()  # compiles, and reads the sources
    project.reset()
    before = time.perf_counter()
    code, printed = project.run()
    seconds = time.perf_counter() - before
    assert code == 0, printed
    reference = project.results()
    rows = []
    for name in names:
        began = time.time()
        Budget.end = began + 60.0 * minutes * SHARES[name] / sum(SHARES[other] for other in names)
        progress(f"campaign: {name}")
        found = CAMPAIGNS[name](project, reference, seconds, folder / name, random.Random(f"{seed} {name}"))
        for row in found:
            outcomes = "; ".join(f"{n} {what}" for what, n in row.outcomes.items())
            print(
                f"{'WRONG' if row.wrong else 'right'}  {row.trials:5}  {row.fault} ({row.tried_on}): {outcomes}",
                flush=True,
            )
        progress(f"{name}: {time.time() - began:.0f} s")
        keep(name, [seed], time.time() - began, found, add=add)
        rows += found
    return rows


if __name__ == "__main__":
    sys.exit(main())
