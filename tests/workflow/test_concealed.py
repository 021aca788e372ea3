"""The sealed proof: what its rules promise, shown by running a tiny set in a fresh copy."""

import json
import re

import pytest
from ruamel.yaml import YAML

from tests.workflow.conftest import ROOT

SEED = 411
SHARD = "0_of_1"


def tiny(copy, recordings=3):
    """Few recordings in the sample."""
    path = copy.folder / "config/concealed.yaml"
    yaml = YAML()
    configuration = yaml.load(path)
    configuration["concealed"]["sample"] |= {"seed": SEED, "recordings": recordings, "shards": 1}
    yaml.dump(configuration, path)
    return copy.folder / f"results/concealed/sample/{SEED}"


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def summary(copy, *arguments):
    """Output file → input files, of everything that a target needs."""
    printed = copy.snakemake(*arguments, "--detailed-summary")
    lines = [line.split("\t") for line in printed.splitlines()]
    (heading,) = [line for line in lines if line[0] == "output_file"]
    column = heading.index("input-file(s)")
    return {line[0]: line[column].split(",") for line in lines if len(line) == len(heading)}


def test_published_seals_are_as_many_as_the_recordings():
    published = ROOT / "paper_figs/concealed_seals.csv"
    if not published.exists():
        pytest.skip("the target `concealed` was never computed")
    table = (ROOT / "paper_figs/concealed.md").read_text(encoding="utf-8")
    assert re.search(r"salt is `[0-9a-f]{64}`", table)
    lines = published.read_text(encoding="utf-8").splitlines()
    assert len(lines) - 1 == int(re.search(r"^(\d+) recordings of seed", table, flags=re.MULTILINE)[1])


@pytest.mark.workflow
def test_tiny_set_is_sealed_diagnosed_blindly_and_revealed(fresh):
    folder = tiny(fresh)
    fresh.snakemake("paper_figs/concealed_sample.png", "results/concealed/quantities.csv")
    for name in ("png", "pdf", "csv"):
        assert (fresh.folder / f"paper_figs/concealed_sample.{name}").is_file()
    diagnoses = contents(folder / "diagnoses" / SHARD)
    assert {p.name for p in diagnoses} >= {"diagnosis.json", "improved.yaml"}
    assert not any(p.name == "failure.txt" for p in diagnoses), diagnoses
    seals = (folder / f"seals/{SHARD}.csv").read_text(encoding="utf-8").splitlines()
    assert len(seals) == 4
    assert all(re.fullmatch(r"\d+,[0-9a-f]{64}", line) for line in seals[1:])

    # Neither truth nor held-out recording is an input of the diagnoses, and the truths are read after all of them.
    results = str(folder.relative_to(fresh.folder))
    inputs = summary(fresh, f"{results}/scores.parquet")
    seen = inputs[f"{results}/diagnoses/{SHARD}"]
    assert {f for f in seen if f.startswith("results/")} == {
        f"{results}/recordings/{SHARD}",
        f"{results}/seals/{SHARD}.csv",
    }
    opened = inputs[f"{results}/revealed/{SHARD}/scores.parquet"]
    assert {f"{results}/diagnoses/{SHARD}", f"{results}/truths/{SHARD}"} <= set(opened)
    # A change of the generator makes other recordings; what diagnoses them does not know it.
    assert "src/camid/proof/concealed/generator.py" in inputs[f"{results}/recordings/{SHARD}"]
    assert not any("concealed/generator" in f for f in seen)

    # Once more without any truth and any held-out recording: every diagnosis is the same to the byte.
    kept = {name: (folder / name).rename(folder / f"kept_{name}") for name in ("truths", "held_out")}
    target = f"results/concealed/sample/{SEED}/diagnoses/{SHARD}"
    arguments = ["--allowed-rules", "concealed_diagnoses", "--forcerun", "concealed_diagnoses"]
    stamp = (folder / "run_times" / f"{SHARD}.csv").stat().st_mtime_ns
    fresh.snakemake(target, *arguments)
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
    printed = fresh.snakemake(scores, *arguments, expect=1)
    assert "the seal of recording 1 is broken" in printed
    assert not (fresh.folder / scores).exists()


@pytest.mark.workflow
def test_another_seed_makes_other_files_throughout(fresh):
    made = [f for f in summary(fresh, "concealed", "--config", "concealed_seed=12345") if f.startswith("results/")]
    assert len(made) > 20
    assert all(f.startswith("results/concealed/full/12345/") for f in made)
    wrong = fresh.snakemake("concealed", "-n", "--config", "concealed_sed=12345", expect=1)
    assert "concealed_sed" in wrong


@pytest.mark.workflow
def test_whole_set_is_no_part_of_all_and_the_sample_is(fresh):
    assert "concealed" not in fresh.planned("all")
    assert {"concealed_sample", "concealed_diagnoses", "concealed_reveal"} <= fresh.planned("all")
    assert {"concealed", "concealed_confusion_matrix", "concealed_run_time"} <= fresh.planned("concealed")
