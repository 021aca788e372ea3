"""A full disk, a folder without the right to write, a dataset that was cut or in which a bit was flipped."""

import contextlib
import os
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd

from camid.errors import InputError
from camid.workflow.dataset_files import DAMAGED, read_arrays, read_dataset, write_arrays, write_dataset
from tests.faults.campaign import Budget, Count, bench, camid, ended, progress, refused_in_one_line

COMMANDS = {
    "simulate": ["simulate", "recording.csv", "--simulation", "S.yaml", "--output", "out/simulated.csv"],
    "identify": ["identify", "recording.csv", "--simulation", "S.yaml", "--output", "out/model.yaml"],
    "diagnose": ["diagnose", "recording.csv", "--simulation", "S.yaml", "--output", "out/diagnosis", "--no-report"],
}
OLDER = {"simulated.csv": "older", "model.yaml": "older", "diagnosis/residuals.csv": "older"}
# Bytes that the disk, or a file, may have at most.
DISKS = (4096, 8192, 16384)
FILES = (0, 100, 1500, 3000)
WORKFLOW_DISKS = (8, 40, 96)  # KiB
BIT_FLIPS, CUTS, OF_THE_WORKFLOW = 300, 100, 2


def may_mount(folder):
    """Whether this user may mount a file system in memory."""
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", str(folder)], capture_output=True, check=False
    )
    if done.returncode == 0:
        subprocess.run(["umount", str(folder)], check=True)
    return done.returncode == 0


@contextlib.contextmanager
def small_disk(folder, size):
    """A file system of some bytes at a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def lay_older(folder):
    for name, content in OLDER.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content)


def after_a_refusal(folder, code, printed):
    """What is wrong after a command that could not write."""
    if wrong := refused_in_one_line(code, printed):
        return wrong
    found = {str(p.relative_to(folder)): p for p in folder.rglob("*") if p.is_file()}
    for name, content in OLDER.items():
        if found[name].read_text() not in {content} and code == 2 and len(found[name].read_text()) == 0:
            return f"{name} is empty"
    left = [name for name in found if ".camid-" in name]
    return f"left behind: {left}" if left else None


def full_disk_of_commands(folder, count, mountable):
    out = folder / "out"
    for arguments in COMMANDS.values():
        for size in DISKS if mountable else ():
            with small_disk(out, size):
                (out / "diagnosis").mkdir()
                with contextlib.suppress(OSError):
                    (out / "filled").write_bytes(b"x" * size)
                code, printed = ended(camid(arguments, folder))
                wrong = refused_in_one_line(code, printed)
                left = [p.name for p in out.rglob("*") if p.name.startswith(".camid-")]
                count.add("refused in one line", wrong or (f"left behind: {left}" if left else None))
        for size in FILES:
            shutil.rmtree(out, ignore_errors=True)
            lay_older(out)
            code, printed = ended(camid(arguments, folder, largest_file=size))
            if code == 0:
                count.add("fitted into the limit")
                continue
            count.add("refused in one line", after_a_refusal(out, code, printed))
        shutil.rmtree(out, ignore_errors=True)


def full_disk_of_the_workflow(project, reference, count):
    results = project.folder / "results"
    for size in WORKFLOW_DISKS:
        if Budget.over(count):
            break
        project.reset()
        results.mkdir()
        with small_disk(results, f"{size}k"):
            code, printed = project.run()
            failed = code not in {0, "hang"} and "No space left" in printed
            subprocess.run(["mount", "-o", "remount,size=64m", str(results)], check=True)
            wrong = project.wrong_after(reference) if failed else f"exit code {code}: {printed[-300:]}"
        count.add("stopped, same bytes once there was room", wrong)
    shutil.rmtree(results, ignore_errors=True)


def unwritable(project, reference, folder, commands, workflow):
    """As a user whom the folder's mode binds: the superuser gives up the right to ignore it."""
    prefix = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.getuid() == 0 else []
    out = folder / "out"
    for name, arguments in COMMANDS.items():
        shutil.rmtree(out, ignore_errors=True)
        lay_older(out)
        for path in (out / "diagnosis", out):
            path.chmod(0o555)
        code, printed = ended(camid(arguments, folder, prefix=prefix))
        for path in (out, out / "diagnosis"):
            path.chmod(0o755)
        commands.add("refused in one line", after_a_refusal(out, code, printed) or (None if name else ""))
    for locked in ("results/datasets", "results/estimates", "paper_figs"):
        if Budget.over(workflow):
            break
        project.reset()
        path = project.folder / locked
        path.mkdir(parents=True, exist_ok=True)
        path.chmod(0o555)
        code, printed = project.run(prefix=prefix)
        with contextlib.suppress(FileNotFoundError):  # an empty folder that Snakemake removed
            path.chmod(0o755)
        failed = (code not in {0, "hang"} and "ermission denied" in printed) or "cannot write" in printed
        wrong = project.wrong_after(reference) if failed else f"exit code {code}: {printed[-300:]}"
        workflow.add("stopped, same bytes once it was allowed", wrong)


def damage(path, random, *, cut):
    """Cut a file, or flip one bit of it."""
    data = bytearray(path.read_bytes())
    if cut:
        data = data[: random.randrange(len(data))]
    else:
        place = random.randrange(8 * len(data))
        data[place // 8] ^= 1 << place % 8
    path.write_bytes(data)


def damaged_files(folder, random, cuts, flips):
    """Each damage is noticed, or the values are those that were written."""
    generator = np.random.default_rng(5)
    table = pd.DataFrame({"k": np.arange(300), "u": generator.standard_normal(300), "name": ["abc"] * 300})
    arrays = {"image": generator.standard_normal((20, 30)), "k": np.arange(7)}
    folder.mkdir(parents=True, exist_ok=True)
    files = {
        "table.parquet": lambda p: write_dataset(table, p, {"seed": 1}),
        "arrays.npz": lambda p: write_arrays(arrays, p),
    }
    for cut, trials, count in ((True, CUTS, cuts), (False, BIT_FLIPS, flips)):
        for trial in range(trials):
            name = list(files)[trial % 2]
            path = folder / name
            files[name](path)
            damage(path, random, cut=cut)
            try:
                found = read_dataset(path) if name == "table.parquet" else read_arrays(path)
            except InputError:
                wrong = None if (folder / f"{name}{DAMAGED}").exists() and not path.exists() else "not put aside"
                count.add("noticed", wrong)
                continue
            same = (
                found.equals(table)
                if name == "table.parquet"
                else all(np.array_equal(found[k], v) for k, v in arrays.items())
            )
            count.add("changed no value", None if same else "values changed without a word")


def damaged_cache(project, reference, folder, random, count):
    """A dataset in a cache between workflows: the run that reads it stops, and the same command makes it anew."""
    for trial in range(2 * OF_THE_WORKFLOW):
        if Budget.over(count):
            break
        project.reset()
        cache = folder / f"cache{trial}"
        cache.mkdir(parents=True)
        options = {"environment": {"SNAKEMAKE_OUTPUT_CACHE": str(cache)}}
        project.run("--cache", **options)
        project.reset()
        entry = random.choice(sorted(p for p in cache.iterdir() if p.suffix in {".parquet", ".npz"}))
        damage(entry, random, cut=trial % 2 == 0)
        code, printed = project.run("--cache", **options)
        noticed = code == 1 and "this dataset is damaged" in printed
        code, printed = project.run("--cache", **options)
        results = project.results()
        different = [n for n in reference if results.get(n) != reference[n]]
        wrong = f"rerun {code}, other bytes: {different}; {printed[-200:]}" if code != 0 or different else None
        count.add("noticed, same bytes after the rerun" if noticed else "no job read it", wrong)


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    del seconds
    work = bench(folder / "work")
    mountable = sys.platform == "linux" and may_mount(folder / "mount")
    how = "a disk of 4 to 16 KiB, files of at most 0 to 3000 bytes" if mountable else "files of at most 0 to 3000 bytes"
    three = "`camid simulate`, `identify`, `diagnose`"
    little = "the workflow in little"
    refusal = "one line, exit code 2, nothing half-written"
    counts = [
        Count("full disk", f"{three}; {how}", refusal),
        Count("full disk", f"{little}; 8 to 96 KiB for its results", "it stops; with room, the same bytes"),
        Count("folder without the right to write", three, refusal),
        Count(
            "folder without the right to write",
            f"{little}; datasets, estimates, figures",
            "it stops; then the same bytes",
        ),
        Count("dataset cut anywhere", "Parquet and NPZ", "noticed when read, and put aside"),
        Count("one bit of a dataset flipped", "Parquet and NPZ", "noticed when read, or no value changed"),
        Count("cached dataset cut, or one bit flipped", little, "it stops; the same command ends in the same bytes"),
    ]
    progress("full disk")
    full_disk_of_commands(work, counts[0], mountable)
    if mountable:
        full_disk_of_the_workflow(project, reference, counts[1])
    progress("unwritable folders")
    unwritable(project, reference, work, counts[2], counts[3])
    progress("damaged datasets")
    damaged_files(folder / "damaged", random, counts[4], counts[5])
    damaged_cache(project, reference, folder / "caches", random, counts[6])
    return [count for count in counts if count.trials]
