"""What the workflow promises, shown by running it in little in a fresh copy; test_workflow.py shows it of the whole."""

import json
import re

import pytest

from tests.workflow.conftest import TINY_TARGETS

SEED, SHARD = 426, "0_of_1"


def test_fresh_clone_computes_what_lies_there_committed(tiny):
    """The trap: figures that are there and whose data are missing look up to date to Snakemake."""
    for figure in TINY_TARGETS:
        for kind in ("png", "csv"):
            name = f"{figure}.{kind}"
            assert (tiny.folder / "paper_figs" / name).stat().st_mtime_ns > tiny.before[name], name
    assert (tiny.folder / "paper_figs/fig5.png").stat().st_mtime_ns == tiny.before["fig5.png"]


def test_settings_of_the_tiny_configuration_arrive(tiny):
    import pandas as pd

    runs = pd.read_parquet(tiny.folder / "results/estimates/sampling_period.parquet")
    assert sorted(runs["period"].unique()) == pytest.approx([0.1, 0.2, 0.3])
    fits = pd.read_parquet(tiny.folder / "results/ablations/monte_carlo.parquet")
    assert set(fits["fits"]) == {4}


def test_a_deleted_figure_takes_one_job_and_is_the_same_again(tiny):
    path = tiny.folder / "paper_figs/fig7.png"
    drawn = path.read_bytes()
    path.unlink()
    assert tiny.ran(*TINY_TARGETS) == {"fig7"}
    assert path.read_bytes() == drawn


def test_second_run_does_nothing_and_changed_source_reruns_the_rules_that_use_it(tiny):
    path = tiny.folder / "src/camid/paper/fig7_sampling_period/drawing.py"
    text = path.read_text(encoding="utf-8")
    try:
        path.write_text(text + "\nCHANGED = True\n", encoding="utf-8")
        assert tiny.planned(*TINY_TARGETS) == {"fig7"}
        # What only a reader sees changes nothing.
        path.write_text(text.replace('"""', '"""Other words. ', 1), encoding="utf-8")
        assert tiny.planned(*TINY_TARGETS) == set()
    finally:
        path.write_text(text, encoding="utf-8")


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_set_is_sealed_diagnosed_blindly_and_revealed(tiny):
    folder = tiny.folder / f"results/concealed/sample/{SEED}"
    assert (tiny.folder / "results/concealed/quantities.csv").is_file()
    for name in ("png", "csv"):
        assert (tiny.folder / f"paper_figs/concealed_sample.{name}").is_file()
    diagnoses = contents(folder / "diagnoses" / SHARD)
    assert {p.name for p in diagnoses} >= {"diagnosis.json", "improved.yaml"}
    assert not any(p.name == "failure.txt" for p in diagnoses), diagnoses
    seals = (folder / f"seals/{SHARD}.csv").read_text(encoding="utf-8").splitlines()
    assert len(seals) == 3
    assert all(re.fullmatch(r"\d+,[0-9a-f]{64}", line) for line in seals[1:])

    # Neither truth nor held-out recording is an input of the diagnoses, and the truths are read after all of them.
    results = str(folder.relative_to(tiny.folder))
    inputs = tiny.summary(f"{results}/scores.parquet")
    seen = inputs[f"{results}/diagnoses/{SHARD}"]
    assert {f for f in seen if f.startswith("results/")} == {
        f"{results}/recordings/{SHARD}",
        f"{results}/seals/{SHARD}.csv",
    }
    opened = inputs[f"{results}/revealed/{SHARD}/scores.parquet"]
    assert {f"{results}/diagnoses/{SHARD}", f"{results}/truths/{SHARD}"} <= set(opened)


@pytest.mark.workflow
def test_diagnoses_need_no_truth_and_an_altered_truth_is_refused(tiny):
    folder = tiny.folder / f"results/concealed/sample/{SEED}"
    diagnoses = contents(folder / "diagnoses" / SHARD)

    # Once more without any truth and any held-out recording: every diagnosis is the same to the byte.
    kept = {name: (folder / name).rename(folder / f"kept_{name}") for name in ("truths", "held_out")}
    target = f"results/concealed/sample/{SEED}/diagnoses/{SHARD}"
    arguments = ["--allowed-rules", "concealed_diagnoses", "--forcerun", "concealed_diagnoses"]
    stamp = (folder / "run_times" / f"{SHARD}.csv").stat().st_mtime_ns
    tiny.snakemake(target, *arguments)
    assert (folder / "run_times" / f"{SHARD}.csv").stat().st_mtime_ns > stamp
    assert not (folder / "truths").exists()
    assert contents(folder / "diagnoses" / SHARD) == diagnoses
    for name, moved in kept.items():
        moved.rename(folder / name)

    # An altered truth is refused with its index, and nothing is scored.
    path = folder / "truths" / SHARD / "1.json"
    truth = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**truth, "kind": "none" if truth["kind"] != "none" else "single"}), encoding="utf-8")
    scores = f"results/concealed/sample/{SEED}/revealed/{SHARD}/scores.parquet"
    arguments = ["--allowed-rules", "concealed_reveal", "--forcerun", "concealed_reveal"]
    printed = tiny.snakemake(scores, *arguments, expect=1)
    assert "the seal of recording 1 is broken" in printed
    assert not (tiny.folder / scores).exists()
