"""Rivals that a diagnosis leaves out, or that fit the earlier recordings with other values nearly as well."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from camid.diagnosis.results_folder import write_diagnosis
from camid.diagnosis.watch import Watch
from camid.errors import InputError
from camid.experiment_design import run
from camid.experiment_design.general_laws import general_laws
from camid.experiment_design.hypothesis import Played, hypothesis_of
from camid.experiment_design.left_out import left_out
from camid.experiment_design.other_values import other_values, own_sums
from camid.experiment_design.prediction import NoiseModel, responses
from camid.experiment_design.refit import Past, left_after_fit, refitted_together
from camid.experiment_design.run import Task, design_for
from camid.experiment_design.separation import pairs_of
from camid.experiment_design.sources import (
    Wishes,
    known_from_diagnosis,
    known_from_folder,
    known_from_simulations,
    limits_of,
    noise_of,
)
from camid.experiment_design.together import Earlier, Recorded
from camid.simulation.file import load_simulation
from tests.experiment_design.test_design import believed
from tests.support.mass_on_spring import PERIOD, effect, record

NOISE = NoiseModel(0.17, np.ones(1))
STOP = {"position": -2.0, "stiffness": 0.1}
"""From where a fit to the first recording finds a stop in the place of the spring."""
LEVELS = (1.0, -1.0, -1.0, 1.0, 1.0, -1.0)


def hypothesis(name, *effects, **known):
    return hypothesis_of(load_simulation(believed(*effects)), name, PERIOD, question="one", **known)


def recorded(table):
    columns = (table[name].to_numpy() for name in ("t", "u", "y"))
    return Earlier((Recorded(*columns, np.ones(len(table), bool)),), NOISE, PERIOD)


@pytest.fixture(scope="module")
def spring():
    """A recording of a quadratic spring, with that and a stop as hypotheses, and the simulation without either."""
    law = effect("quadratic-stiffness", coefficient=-0.02)
    table = record(law, count=300, seed=2, noise=0.17, signal=np.repeat(np.resize(LEVELS, 30), 10))
    known = known_from_simulations([believed(law), believed(effect("end-stop", **STOP)), believed()], [table], None)
    names = ("quadratic-stiffness", "end-stop", "")
    hypotheses = [replace(h, identifier=n, question="one") for h, n in zip(known.hypotheses, names, strict=True)]
    return hypotheses, known.earlier


def next_one():
    return Played(np.repeat(np.resize([1.0, 0.5, -0.5, 0.0, -1.0], 30), 10), PERIOD)


# -- other values ------------------------------------------------------------------------------------------------------


def test_a_stop_may_begin_elsewhere(spring):
    hypotheses, earlier = spring
    sums = own_sums(hypotheses, earlier)
    found = other_values(hypotheses, earlier, sums)
    assert {h.identifier for h in found} == {"end-stop"}
    own = hypotheses[1].effect.values["position"]
    assert all(abs(h.effect.values["position"] - own) > 0.4 and h.beyond < 10.0 for h in found)
    assert all(h.variant and h.held == {"end-stop position"} for h in found)


def test_a_law_with_more_detail_is_no_other_value(spring, monkeypatch):
    """It has more numbers than the name that it would be a value of."""
    hypotheses, earlier = spring
    law = type(hypotheses[1].effect)
    both = law.with_keys(["position", "stiffness", "opposite", "opposite_stiffness"])
    guess = both(position=-3.0, stiffness=0.1, opposite=3.0, opposite_stiffness=0.1)
    monkeypatch.setattr(law, "candidates", classmethod(lambda cls, situation: iter([guess])))
    assert other_values(hypotheses, earlier, own_sums(hypotheses, earlier)) == []


def test_what_is_known_around_other_values_is_the_sum_of_squares_there(spring):
    """The parabola around them, moved by its slope, is what another fit of size and coefficients leaves."""
    hypotheses, earlier = spring
    sums = own_sums(hypotheses, earlier)
    for other in other_values(hypotheses, earlier, sums):
        assert other.beyond >= -1.0
        step = np.linalg.lstsq(other.information, -other.slope, rcond=None)[0]
        assert abs(float(step @ other.slope)) < 1.0


def test_a_fit_to_all_recordings_leaves_less_than_a_parabola_allows(spring):
    hypotheses, earlier = spring
    sums = own_sums(hypotheses, earlier)
    every = [*hypotheses, *other_values(hypotheses, earlier, sums)]
    found = responses(every, next_one(), NOISE)
    own = pairs_of(found[: len(hypotheses)], NOISE)
    pairs = pairs_of(found, NOISE)
    assert all(new.left <= old.left for new, old in zip(pairs, own, strict=True))
    fitted, _ = refitted_together(hypotheses, next_one(), NOISE, pairs, found, Past(earlier, sums))
    stop = next(p for p in fitted if hypotheses[p.rival].identifier == "end-stop")
    parabola = left_after_fit(hypotheses[stop.rival], found[stop.true].output, next_one(), NOISE)
    assert 0.0 <= stop.left < parabola


def test_other_recordings_than_the_diagnosed_ones_are_noticed(spring):
    hypotheses, earlier = spring
    (one,) = earlier.recorded
    assert earlier.agrees(hypotheses)
    other = replace(one, output=one.output + 0.3 * np.roll(one.output, 7))
    assert not replace(earlier, recorded=(other,)).agrees(hypotheses)


# -- left out ----------------------------------------------------------------------------------------------------------


def test_what_a_diagnosis_leaves_out_is_a_rival_of_its_names(first):
    """Of an input with two levels a bias imitates an uneven gain: it is a rival, even if it is not listed."""
    known = known_from_simulations(
        [
            believed(effect("gain-asymmetry", ratio=1.1)),
            believed(effect("cubic-stiffness", coefficient=0.1)),
            believed(),
        ],
        [first],
        None,
    )
    names = ("gain-asymmetry", "cubic-stiffness", "")
    hypotheses = [
        replace(h, identifier=n, question="one", criterion=c)
        for h, n, c in zip(known.hypotheses, names, (0.0, 20.0, 30.0), strict=True)
    ]
    found = left_out(hypotheses, known.earlier, own_sums(hypotheses, known.earlier))
    bias = next(h for h in found if h.identifier == "input-bias")
    assert abs(bias.criterion) < 3.0
    assert bias.rival_only
    assert not {h.identifier for h in found} & set(names)
    true = {p.true for p in pairs_of(responses([*hypotheses, bias], next_one(), NOISE), NOISE)}
    assert true == {0, 1}  # a rival alone is never what is right


def test_general_laws_keep_their_share():
    """What is played tells dry friction from no law that has it for a special case."""
    friction = hypothesis("coulomb-friction", effect("coulomb-friction", force=0.1))
    drag = hypothesis("quadratic-drag", effect("quadratic-drag", coefficient=0.01))
    assert {law.identifier for law in general_laws([friction, drag])} >= {
        "stribeck-friction",
        "position-dependent-friction",
    }
    assert {law.special for law in general_laws([friction, drag])} == {"coulomb-friction"}
    assert general_laws([drag]) == []
    task = Task([friction, drag], None, NOISE, 300)
    pairs = pairs_of(responses([friction, drag], next_one(), NOISE), NOISE)
    assert task.judge.weight(0, pairs, 300) < 0.95 < task.judge.weight(1, pairs, 300)


def test_a_general_law_leaves_no_more_than_its_special_case():
    """A gradient that the first recording hardly determines is no evidence against friction without one."""
    friction = hypothesis("coulomb-friction", effect("coulomb-friction", force=0.1))
    general = hypothesis(
        "position-dependent-friction", effect("position-dependent-friction", force=0.05, gradient=0.3), misfit=-2.0
    )
    found = responses([friction, general], next_one(), NOISE)
    (one, other) = pairs_of(found, NOISE)
    assert found[1].left_of(NOISE.whitened(found[0].output - found[1].output)) > 2.0
    assert one.left == 2.0
    assert other.left > 2.0


def test_a_drift_in_question_is_there_in_the_next_recording_too():
    """The diagnosis of both would hold it against both; one that is not in question belongs to the first alone."""
    drift = effect("parameter-drift", coefficient="stiffness", rate=0.05)
    assert hypothesis("parameter-drift", drift).effect is not None
    assert hypothesis("coulomb-friction", effect("coulomb-friction", force=0.1), drift).model.effects[0].identifier == (
        "coulomb-friction"
    )
    assert len(hypothesis("coulomb-friction", effect("coulomb-friction", force=0.1), drift).model.effects) == 1


# -- a design ----------------------------------------------------------------------------------------------------------


def test_a_design_with_the_recordings_of_its_diagnosis(diagnosis):
    known = known_from_diagnosis(diagnosis)
    wishes = Wishes(duration=4.0)
    task = Task(
        known.hypotheses,
        limits_of(known, wishes),
        noise_of(known, wishes),
        known.rows,
        known.experiments,
        known.earlier,
    )
    assert known.earlier.agrees(known.hypotheses)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = design_for(task, Watch(None, None), simulated_rows=3e5, checked=1)
    listed = {h.identifier for h in diagnosis.hypotheses if h.identifier}
    assert {e.identifier for e in found.expectations} == listed
    assert {h.identifier for h in found.hypotheses} == listed | {""}
    assert set(found.outputs) == listed
    likely = next(e for e in found.expectations if e.identifier == "gain-asymmetry")
    assert likely.weight > 0.9


def test_the_recordings_of_a_folder_are_those_of_its_diagnosis(diagnosis, first, tmp_path):
    write_diagnosis(diagnosis, tmp_path / "diagnosis", report=False)
    known = known_from_folder(tmp_path / "diagnosis", [first])
    assert known.earlier.agrees(known.hypotheses)
    (own,), (written,) = known_from_diagnosis(diagnosis).earlier.recorded, known.earlier.recorded
    for one, other in zip(vars(own).values(), vars(written).values(), strict=True):
        np.testing.assert_allclose(one, other)
    with pytest.raises(InputError, match="not the recordings that were diagnosed"):
        known_from_folder(tmp_path / "diagnosis", [first.assign(y=first["y"] + 0.1)])
    assert known_from_folder(tmp_path / "diagnosis").earlier is None


def test_what_long_recordings_cost_is_bounded(diagnosis, monkeypatch):
    """They are not fitted again: rivals are followed by their information."""
    known = known_from_diagnosis(diagnosis)
    limits, noise = limits_of(known, Wishes(duration=4.0)), noise_of(known, Wishes())
    task = Task(known.hypotheses, limits, noise, known.rows, known.experiments, known.earlier)
    _, past = run._with_rivals(task)
    assert past is not None
    monkeypatch.setattr(run, "MOST_EARLIER_ROWS", known.earlier.rows - 1)
    assert run._with_rivals(task) == (task, None)
