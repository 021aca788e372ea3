"""One Snakemake at a time, no lock after a kill, and no result from the future."""

import os
import subprocess
import sys
import time

import pytest

from tests.support import ROOT

sys.path.insert(0, str(ROOT / "workflow"))

from working_copy import WorkingCopy, settle_times

ENTER = """
import sys, time
sys.path.insert(0, {workflow!r})
from pathlib import Path
from working_copy import WorkingCopy
copy = WorkingCopy(Path({folder!r}))
print(copy.enter(), copy.begin_work(), flush=True)
time.sleep(60)
"""


@pytest.fixture
def folder(tmp_path):
    return tmp_path / ".snakemake"


@pytest.fixture
def other(folder):
    """Another process that is there and at work."""
    program = ENTER.format(workflow=str(ROOT / "workflow"), folder=str(folder))
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "True True\n"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def left_locks(folder):
    locks = folder / "locks"
    locks.mkdir(parents=True)
    (locks / "0.output.lock").write_text("paper_figs/fig2.png\n")
    return locks


def test_locks_of_a_killed_one_are_removed(folder):
    locks = left_locks(folder)
    assert WorkingCopy(folder).enter()
    assert not locks.exists()


def test_locks_of_one_that_is_at_work_stay_until_it_is_killed(folder, other):
    locks = left_locks(folder)
    second = WorkingCopy(folder)
    assert not second.enter()
    assert not second.begin_work()
    assert locks.exists()
    del second
    other.kill()
    other.wait()
    third = WorkingCopy(folder)
    assert third.enter()
    assert third.begin_work()
    assert not locks.exists()


def test_two_that_only_look_do_not_hinder_each_other(folder):
    first, second = WorkingCopy(folder), WorkingCopy(folder)
    assert first.enter()
    assert not second.enter()
    assert second.begin_work()
    assert not first.begin_work()


def test_files_from_the_future_keep_their_order(tmp_path):
    (tmp_path / "results").mkdir()
    now = time.time()
    ages = {"old": -1000.0, "soon": 100.0, "later": 5000.0, "last": 9000.0}
    for name, age in ages.items():
        path = tmp_path / "results" / name
        path.write_text(name)
        os.utime(path, (now + age, now + age))
    (tmp_path / "results/link").symlink_to("last")
    assert settle_times(tmp_path) == 3
    stamps = [(tmp_path / "results" / name).stat().st_mtime for name in ages]
    assert stamps == sorted(stamps)
    assert stamps[0] == pytest.approx(now - 1000.0, abs=1e-3)
    assert stamps[-1] <= time.time()
    assert settle_times(tmp_path) == 0
