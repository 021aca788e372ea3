"""Two at once in one folder: two Snakemakes, two commands with the same output."""

import time

from tests.faults.campaign import Budget, Count, bench, camid, ended, progress

SNAKEMAKES, SIMULATIONS, DIAGNOSES = 6, 8, 2
REFUSALS = ("Directory cannot be locked", "another Snakemake is at work")


def two_snakemakes(project, reference, random, count):
    for trial in range(SNAKEMAKES):
        if Budget.over(count):
            break
        project.reset()
        targets = [["fig2", "fig6"], ["fig2", "fig6"]] if trial % 2 else [["fig2"], ["fig6"]]
        processes = []
        for wanted in targets:
            processes.append(project.start(targets=wanted))
            time.sleep(random.choice([0.0, 0.0, 0.5, 2.0]))
        answers = [ended(p) for p in processes]
        refused = [printed for code, printed in answers if code == 1 and any(r in printed for r in REFUSALS)]
        done = [code for code, _ in answers if code == 0]
        wrong = None if len(done) + len(refused) == 2 and done else str([(c, p[-200:]) for c, p in answers])
        wrong = wrong or project.wrong_after(reference)
        count.add("one worked, one was refused" if refused else "one after the other", wrong)


def two_commands(folder, count):
    bench(folder)
    kinds = [("simulate", "both.csv", [])] * SIMULATIONS + [("diagnose", "both", ["--no-report"])] * DIAGNOSES
    alone = {}
    for command, output, options in kinds:
        if Budget.over(count) and command in alone:
            continue
        start = [command, "recording.csv", "--simulation", "S.yaml", *options, "--output"]
        if command not in alone:
            ended(camid([*start, f"alone-{output}"], folder))
            alone[command] = contents(folder / f"alone-{output}")
        answers = [ended(p) for p in [camid([*start, output], folder) for _ in range(2)]]
        wrong = None if all(code == 0 for code, _ in answers) else str(answers)[-300:]
        found = contents(folder / output)
        if not wrong and found != alone[command]:
            wrong = f"other bytes: {sorted(n for n in alone[command] if found.get(n) != alone[command][n])}"
        count.add("both ended, one whole result", wrong)


def contents(path):
    """Files by their names, without the run time that a diagnosis states."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    return {
        p.name if path.is_dir() else "": b"\n".join(
            line for line in p.read_bytes().split(b"\n") if b'"seconds"' not in line and b'"time"' not in line
        )
        for p in files
    }


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    del seconds
    counts = [
        Count(
            "two Snakemakes at once in one folder",
            "the same targets, and different ones",
            "one works, or one after the other",
        ),
        Count("two commands at once with one output", "`camid simulate`, `camid diagnose`", "the bytes of one alone"),
    ]
    progress("two Snakemakes at once")
    two_snakemakes(project, reference, random, counts[0])
    progress("two commands at once")
    two_commands(folder, counts[1])
    return counts
