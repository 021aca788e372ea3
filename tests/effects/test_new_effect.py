"""An effect defined by the text of docs/adding_an_effect.md alone is known to catalogue, engine and diagnosis."""

import re

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.plant import second_order
from camid.diagnosis.search.screening import screen
from camid.effects import known_effects
from camid.effects.own_effects import own_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.linear import LinearPlant
from camid.fitting.problem import Problem
from camid.identification.experiment import Experiment
from camid.identification.structure import Structure
from tests.support import ROOT
from tests.support.adaptive_integration import Reference, pieces_of

PAGE = ROOT / "docs" / "adding_an_effect.md"
PLANT = second_order(1.0, 10.0, 0.1)
PERIOD = 0.02


def text_of_the_page():
    return re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL).group(1)


@pytest.fixture
def flung(tmp_path):
    """The class of the page; the catalogue is as before when the test is over."""
    path = tmp_path / "flung.py"
    path.write_text(text_of_the_page(), encoding="utf-8")
    with own_effects(path) as (kind,):
        yield kind


def excitation(count):
    return np.repeat(np.random.default_rng(2).choice([-1.0, -0.5, 0.3, 1.0], count // 4), 4)


def test_the_engine_runs_it(flung):
    signal, time = excitation(60), PERIOD * np.arange(60)
    found = run(Chain(PLANT, Acquisition(PERIOD), (flung(coefficient=0.002),)), signal, time)
    reference = Reference(PLANT.numerator, PLANT.denominator, force=lambda t, y, v, u, m: 0.002 * y * v * v).run(
        pieces_of(signal, PERIOD, "zoh")
    )
    expected = reference.mean(time - PERIOD, time)
    assert np.max(np.abs(found - expected)) < 1e-4 * np.std(expected)


def test_the_diagnosis_finds_it(flung):
    count = 1000
    signal, time = excitation(count), PERIOD * np.arange(count)
    acquisition = Acquisition(PERIOD)
    output = run(Chain(PLANT, acquisition, (flung(coefficient=0.001),)), signal, time)
    output = output + 0.02 * np.std(output) * np.random.default_rng(3).standard_normal(count)
    structure = Structure(
        np.array([105.0]), np.array([1.0, 2.1, 97.0]), np.array([True]), np.array([False, True, True])
    )
    experiment = Experiment(signal, output, acquisition, np.ones(count, bool))
    problem = Problem(structure, [experiment], [time], LinearPlant(), 0.1)
    base = problem.kind.refit(problem, Model(structure.coefficients(), (), (None,)))
    assert screen(problem, base)[0].effect.identifier == "flung-outward"


def test_without_it_the_catalogue_does_not_know_it():
    assert "flung-outward" not in known_effects()


def test_the_page_on_own_effects_shows_the_file_of_the_example():
    page = (ROOT / "docs" / "own_effects.md").read_text(encoding="utf-8")
    text = re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1)
    assert (ROOT / "examples" / "magnet_effect.py").read_text(encoding="utf-8").endswith(f'"""\n\n{text}')
