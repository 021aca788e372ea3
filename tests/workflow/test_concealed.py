"""The sealed proof: what is committed of it, and what its rules promise; test_tiny.py runs a small set."""

import re

import pytest

from tests.support import ROOT


def test_published_seals_are_as_many_as_the_recordings():
    published = ROOT / "paper_figs/concealed_seals.csv"
    table = (ROOT / "paper_figs/concealed.md").read_text(encoding="utf-8")
    assert re.search(r"salt is `[0-9a-f]{64}`", table)
    lines = published.read_text(encoding="utf-8").splitlines()
    assert len(lines) - 1 == int(re.search(r"^(\d+) recordings of seed", table, flags=re.MULTILINE)[1])


@pytest.mark.workflow
def test_another_seed_makes_other_files_throughout(fresh):
    made = [f for f in fresh.summary("concealed", "--config", "concealed_seed=12345") if f.startswith("results/")]
    assert len(made) > 20
    assert all(f.startswith("results/concealed/full/12345/") for f in made)
    wrong = fresh.snakemake("concealed", "-n", "--config", "concealed_sed=12345", expect=1)
    assert "concealed_sed" in wrong


@pytest.mark.workflow
def test_whole_set_is_no_part_of_check_and_the_sample_is(fresh):
    assert not {name for name in fresh.planned("all") if name.startswith("concealed")}
    assert "concealed" not in fresh.planned("check")
    assert {"concealed_sample", "concealed_diagnoses", "concealed_reveal"} <= fresh.planned("check")
    assert {"concealed", "concealed_confusion_matrix", "concealed_run_time"} <= fresh.planned("concealed")
