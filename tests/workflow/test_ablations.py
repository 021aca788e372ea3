"""Every ablation is whole: modules, configuration, tolerances, tests and committed results."""

import shutil

import pytest
from ruamel.yaml import YAML

from tests.support import ROOT

ABLATIONS = ROOT / "src/camid/ablations"


def ablations():
    """Names of the folders that the workflow finds."""
    return sorted(p.parent.name for p in ABLATIONS.glob("*/ablation.yaml"))


def loaded(name):
    return YAML(typ="safe").load(ROOT / name)


@pytest.mark.parametrize("name", ablations())
def test_ablation_is_whole(name):
    for file in ("runs.py", "drawing.py", "settings.yaml", "settings.schema.yaml", "tolerances.yaml"):
        assert (ABLATIONS / name / file).is_file()
    assert (ROOT / f"tests/ablations/test_{name}.py").is_file()
    guards = [t for t in loaded(ABLATIONS / name / "tolerances.yaml") if t["target"] == f"ablation_{name}"]
    assert guards, "no tolerance guards its conclusion"
    for kind in ("png", "csv"):
        assert (ROOT / f"paper_figs/ablation_{name}.{kind}").is_file()
    assert f"(`ablation_{name}`)" in (ROOT / "paper_figs/ablations.md").read_text(encoding="utf-8")


def test_nothing_is_committed_that_is_no_ablation():
    names = set(ablations())
    committed = {p.stem.removeprefix("ablation_") for p in (ROOT / "paper_figs").glob("ablation_*")}
    assert committed == names


@pytest.mark.workflow
def test_new_ablation_is_one_new_folder(fresh):
    folder = fresh.folder / "src/camid/ablations/brand_new"
    shutil.copytree(fresh.folder / "src/camid/ablations/latency", folder)
    tolerances = folder / "tolerances.yaml"
    tolerances.write_text(tolerances.read_text(encoding="utf-8").replace("ablation_latency", "ablation_brand_new"))
    assert {"brand_new_runs", "ablation_brand_new"} <= fresh.planned("all")
    assert "src/camid/ablations/brand_new/tolerances.yaml" in fresh.snakemake("check", "--filegraph")
    settings = folder / "settings.yaml"
    settings.write_text(settings.read_text(encoding="utf-8") + "bran: 1\n", encoding="utf-8")
    assert "settings of the ablation brand_new: Additional properties are not allowed ('bran' was unexpected)" in (
        fresh.snakemake("-n", expect=1)
    )


@pytest.mark.workflow
def test_configuration_of_an_ablation_that_there_is_not_is_refused(fresh):
    printed = fresh.snakemake("-n", "--config", "ablations={past_shanon: {seeds: 3}}", expect=1)
    assert "config: no ablation is called past_shanon; src/camid/ablations holds acceleration, " in printed
    (fresh.folder / "few.yaml").write_text("ablations: {past_shannon: {seeds: 3}}\n", encoding="utf-8")
    assert "past_shannon_runs" in fresh.planned("all", "--configfile", "few.yaml")
