"""The house rules that no linter knows: effects are named in their classes only, and no module imports in a circle."""

import ast
from dataclasses import fields
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.effects import known_effects
from camid.effects.base import Effect

SOURCE = Path(camid.__file__).parent
# What makes recordings with known effects, and what judges the tool by them, has to name them.
NAMES_EFFECTS = {"effects", "proof", "paper", "ablations", "real_recordings"}
# An exposure is also what a simulation declares of its camera.
DECLARED = {field.name for field in fields(Acquisition)}


def named_effects(source):
    """Identifiers of the catalogue that stand as strings in a program, with their lines."""
    identifiers = set(known_effects()) - DECLARED
    return [
        (node.lineno, node.value)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in identifiers
    ]


def test_no_effect_is_named_outside_of_its_class():
    files = [p for p in SOURCE.rglob("*.py") if p.relative_to(SOURCE).parts[0] not in NAMES_EFFECTS]
    assert len(files) > 50
    found = {str(p): named for p in files if (named := named_effects(p.read_text(encoding="utf-8")))}
    assert not found, "make it an attribute of the effect's class"


def test_a_named_effect_is_found():
    assert named_effects('weights = {"backlash": 1}') == [(1, "backlash")]
    assert named_effects("'''backlash is play'''; exposure = 'exposure'") == []


@pytest.mark.parametrize("effect", known_effects().values(), ids=lambda effect: effect.identifier)
def test_what_an_effect_says_of_itself_agrees_with_what_it_does(effect):
    assert effect.corrects_declaration == (effect.declare is not Effect.declare)
    if effect.spoils_rows or effect.shows_in_values or effect.makes_variance_uneven or effect.colours_noise:
        assert effect.noise_like
    if effect.added_variance is not Effect.added_variance:
        assert effect.makes_variance_uneven
    if effect.colours_noise:
        assert effect.of_autoregression.__func__ is not Effect.of_autoregression.__func__


def test_no_modules_import_each_other_in_a_circle():
    graph = grimp.build_graph("camid", exclude_type_checking_imports=True, cache_dir=None)
    order = TopologicalSorter({m: graph.find_modules_directly_imported_by(m) for m in graph.modules})
    order.prepare()  # raises CycleError with the circle
    assert graph.modules
