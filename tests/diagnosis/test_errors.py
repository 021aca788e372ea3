"""What errors are measured by, and that of the simulation as given, which errs as much as ``camid simulate`` shows."""

from types import SimpleNamespace

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.commands.diagnose import _judged
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.report.page import render
from camid.diagnosis.report.summary import verdict_words
from camid.number_text import SPACE
from tests.support.mass_on_spring import COUNT, PERIOD, effect, record, simulation

SWING = TransferFunction((1.0,), (1.0, 0.12, 16.8))
AMPLITUDE = 300.0


def test_a_decay_with_a_declared_effect_begins_as_it_is_simulated():
    """The motion never forgets where it began, and the state that suits the plant without the effect is another."""
    gravity = effect("pendulum-gravity", amplitude=AMPLITUDE)
    state = np.array([0.0, 3600.0])
    table = record(gravity, plant=SWING, state=state, signal=np.zeros(500), count=500, noise=0.3)
    believed = {
        "schema": 1,
        "time": {"column": "t"},
        "input": None,
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.12, 16.8]}},
        "sensor": {"column": "y", "kind": "camera", "exposure": PERIOD},
        "initial_state": "estimate",
        "effects": [{"id": "pendulum-gravity", "parameters": {"amplitude": AMPLITUDE}}],
    }
    simulated = camid.simulate(table, believed)
    diagnosis = camid.diagnose(table, believed)
    held_out = diagnosis.signals.validates
    left = (table["y"] - simulated["simulated"])[held_out]
    assert np.ptp(table["y"]) > AMPLITUDE
    expected = np.sqrt(np.mean(left**2)) / np.std(table["y"][held_out])
    assert diagnosis.fit.nominal < 1.1 * expected
    np.testing.assert_allclose(diagnosis.signals.nominal, simulated["simulated"], atol=1.0)


def test_errors_in_rows_at_rest_are_measured_by_the_whole_recording():
    """There the spread of the output is that of the noise, of which nobody can explain anything."""
    table = record(effect("coulomb-friction", force=0.15), signal=np.ones(COUNT), noise=0.002)
    fit = camid.diagnose(table, simulation()).fit
    assert fit.at_rest
    assert fit.improved < 0.03
    assert fit.noise_floor < 0.03
    assert not fit.explains_nothing
    assert fit.to_mapping()["reference"] == "whole-recording"


@pytest.mark.slow
def test_errors_in_rows_that_move_are_measured_by_them():
    table = record(effect("coulomb-friction", force=0.15))
    diagnosis = camid.diagnose(table, simulation())
    signals, fit = diagnosis.signals, diagnosis.fit
    left = (signals.recorded - signals.improved)[signals.validates]
    assert fit.improved == np.sqrt(np.mean(left**2)) / np.std(signals.recorded[signals.validates])
    assert fit.to_mapping()["reference"] == "validation"


def test_an_output_of_noise_says_nothing_of_the_structure():
    """Nothing structured is left of it, with coefficients that make the simulation rest."""
    random = np.random.default_rng(np.random.SeedSequence(5))
    table = record().assign(y=0.05 * random.standard_normal(COUNT))
    diagnosis = camid.diagnose(table, simulation())
    assert diagnosis.to_mapping()["fit"]["explains_output"] is False
    assert "nothing can be said of its structure" in diagnosis.explanation
    assert verdict_words(diagnosis)[:2] == ("?", "Nothing explained")
    page = render(diagnosis)
    for text in (diagnosis.explanation, page, repr(diagnosis)):
        assert "structure is right" not in text
        assert "structure of the simulation holds" not in text
        assert "dequate" not in text.partition("<style>")[0]
    assert "Nothing can be said of the structure" in page


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([False, False, True], "run 3"),
        ([True, True, True], "the first of 3 recordings, and likewise of the others"),
    ],
)
def test_of_several_runs_the_one_that_judges_is_named(rows, said):
    runs = [SimpleNamespace(experiment=str(i + 1), source="runs.csv") for i in range(3)]
    assert _judged(runs, [0, 1, 2], [np.array([judges]) for judges in rows]) == said
    assert _judged(runs[:1], [0, 0], [np.array([True])] * 2) == ""
    fit = NormalisedErrors(1.0, 0.1, 0.1, 0.1, (0.0, 9.94), of_recording=said)
    assert fit.rows == f"0 to 9.94{SPACE}s of {said}"
    assert fit.to_mapping()["validation"]["recording"] == said
