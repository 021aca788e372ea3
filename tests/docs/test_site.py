"""What the site generates is whole, and the built site asks nothing of any network."""

import importlib.util
import json
import re
import subprocess
import sys

import pytest
from ruamel.yaml import YAML

from camid.effects import known_effects
from camid.effects.base import PLACES
from tests.support import ROOT


@pytest.fixture(scope="module")
def generator():
    """The hook that mkdocs calls."""
    spec = importlib.util.spec_from_file_location("docs_site", ROOT / "workflow/scripts/docs_site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_catalogue_has_every_effect(generator):
    text = generator.catalogue()
    for identifier, kind in known_effects().items():
        if kind.__module__.startswith("camid."):
            assert f"{{#{identifier}}}" in text
            assert all(f"| `{p.name}` |" in text for p in kind.parameters)
            assert all(law.equation and f"`{law.parameters[-1].name}`" in text for law in kind.finer_laws)


def test_claims_and_ablations_are_all_shown(generator):
    text = generator.claims()
    assert text.count("!!! ") == len(generator.rows("claims.csv")) > 0
    assert all(row["number"] in text for row in generator.rows("claims.csv"))
    assert all(row["conclusion"] in generator.ablations() for row in generator.rows("ablations.csv"))


def test_every_key_of_a_simulation_file_is_shown_once_in_each_part(generator):
    schema = json.loads((ROOT / "src/camid/schemas/simulation.schema.json").read_text(encoding="utf-8"))
    text = generator.simulation_keys()
    parts = [schema, *(part for part in schema["$defs"].values() if "properties" in part)]
    assert text.count("\n## ") + 1 == len(parts)
    assert text.count("\n| `") == sum(len(part["properties"]) for part in parts)
    assert "| `latency` | number or `estimate` |" in text
    assert "(#physicalpart)" in text
    assert "{#physicalpart}" in text


def test_pages_ask_for_parts_that_exist(generator):
    asked = {name for page in (ROOT / "docs").glob("*.md") for name in generator.MARK.findall(page.read_text("utf-8"))}
    assert asked == set(generator.GENERATED)


def test_the_number_of_limits_set_afterwards_is_true():
    files = [ROOT / "config/tolerances.yaml", *(ROOT / "src/camid/ablations").glob("*/tolerances.yaml")]
    entries = [entry for file in files for entry in YAML(typ="safe").load(file)]
    afterwards = sum("set after the first run" in entry["source"] for entry in entries)
    assert f"{afterwards} of the {len(entries)} entries were set after the first run" in " ".join(
        (ROOT / "docs/workflow.md").read_text(encoding="utf-8").split()
    )


def test_the_page_of_the_catalogue_lists_every_id_without_being_built():
    rows = re.findall(r"^\| (\w+) \| (`[^|]*`) \|$", (ROOT / "docs/effects.md").read_text(encoding="utf-8"), re.M)
    listed = {place: re.findall(r"`([^`]*)`", ids) for place, ids in rows if place in PLACES}
    assert listed == {p: sorted(i for i, e in known_effects().items() if e.place == p) for p in PLACES}


@pytest.mark.slow
def test_the_site_builds_strictly_and_loads_nothing_from_elsewhere(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", tmp_path], cwd=ROOT, check=True
    )
    pages = list(tmp_path.rglob("*.html"))
    assert len(pages) > 20
    for page in pages:
        loaded = re.findall(r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]*)"', page.read_text(encoding="utf-8"))
        assert not loaded, f"{page.name}: {loaded}"
