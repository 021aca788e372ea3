"""Every ablation is whole: modules, configuration, tolerances, tests and committed results."""

import pytest
from ruamel.yaml import YAML

from tests.workflow.conftest import ROOT

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
    for kind in ("png", "pdf", "csv"):
        assert (ROOT / f"paper_figs/ablation_{name}.{kind}").is_file()
    assert f"(`ablation_{name}`)" in (ROOT / "paper_figs/ablations.md").read_text(encoding="utf-8")


def test_nothing_is_committed_that_is_no_ablation():
    names = set(ablations())
    committed = {p.stem.removeprefix("ablation_") for p in (ROOT / "paper_figs").glob("ablation_*")}
    assert committed == names
