"""Every ablation is whole: modules, configuration, tolerances, tests and committed results."""

import ast
import re

import pytest
from ruamel.yaml import YAML

from tests.workflow.conftest import ROOT


def ablations():
    """The dictionary of workflow/rules/ablations.smk."""
    text = (ROOT / "workflow/rules/ablations.smk").read_text(encoding="utf-8")
    return ast.literal_eval(re.search(r"^ABLATIONS = (\{.*?^\})", text, flags=re.MULTILINE | re.DOTALL)[1])


def loaded(name):
    return YAML(typ="safe").load(ROOT / name)


@pytest.mark.parametrize("name", list(ablations()))
def test_ablation_is_whole(name):
    for folder in ("src/camid/experiments/ablations", "src/camid/figures/ablations"):
        assert (ROOT / folder / f"{name}.py").is_file()
    assert (ROOT / f"tests/experiments/ablations/test_{name}.py").is_file()
    assert name in loaded("config/ablations.yaml")["ablations"]
    assert name in loaded("workflow/schemas/ablations.schema.yaml")["properties"]
    guards = [t for t in loaded("config/tolerances.yaml") if t["target"] == f"ablation_{name}"]
    assert guards, "no tolerance guards its conclusion"
    for kind in ("png", "pdf", "csv"):
        assert (ROOT / f"paper_figs/ablation_{name}.{kind}").is_file()
    assert f"(`ablation_{name}`)" in (ROOT / "paper_figs/ablations.md").read_text(encoding="utf-8")


def test_nothing_is_configured_or_committed_that_is_no_ablation():
    names = set(ablations())
    assert set(loaded("config/ablations.yaml")["ablations"]) == names
    assert set(loaded("workflow/schemas/ablations.schema.yaml")["properties"]) == names
    committed = {p.stem.removeprefix("ablation_") for p in (ROOT / "paper_figs").glob("ablation_*")}
    assert committed == names
    guarded = {
        t["target"].removeprefix("ablation_") for t in loaded("config/tolerances.yaml") if "ablation_" in t["target"]
    }
    assert guarded == names


def test_readme_shows_the_conclusions_that_the_workflow_wrote():
    written = (ROOT / "paper_figs/ablations.md").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert written.strip() in readme, "README.md is behind paper_figs/ablations.md; run `make readme`"


def test_readme_quotes_the_whole_monte_carlo():
    written = (ROOT / "paper_figs/monte_carlo.txt").read_text(encoding="utf-8")
    assert written.strip() in " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
