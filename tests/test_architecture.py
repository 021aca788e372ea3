"""The house rules that no linter knows: effects are named in their classes only, and functions are short."""

import ast
from dataclasses import fields
from pathlib import Path

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
LONGEST_FUNCTION = 60
LONG_FUNCTIONS = {
    "proof/second_author/integrator.integrate": "one compiled loop over samples and substeps",
    "engine/smooth_step.smooth_step": "compiled as one: the compiler made slower code of its parts",
    "identification/safeguarded._iterate": "its steps share more variables than a call can return",
}


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


def long_functions(source):
    """Functions of more than 60 lines, docstring not counted."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            lines = node.end_lineno - node.lineno + 1
            if ast.get_docstring(node) is not None:
                lines -= node.body[0].end_lineno - node.body[0].lineno + 1
            if lines > LONGEST_FUNCTION:
                yield node.name


def test_functions_are_short():
    found = {
        f"{path.relative_to(SOURCE).with_suffix('').as_posix()}.{name}"
        for path in SOURCE.rglob("*.py")
        for name in long_functions(path.read_text(encoding="utf-8"))
    }
    assert found <= set(LONG_FUNCTIONS), "split it, or say in LONG_FUNCTIONS why it is one function"


def test_a_long_function_is_found():
    body = "    x = 1\n"
    docstring = "    '''One.\n\n    Two.\n    '''\n"
    assert list(long_functions("def short():\n" + docstring + 59 * body)) == []
    assert list(long_functions("def long():\n" + docstring + 60 * body)) == ["long"]
