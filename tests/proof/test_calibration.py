"""Constants of the weights, from comparisons whose truth is drawn from weights that are known."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from camid.diagnosis.weights import Comparison, Constants, Member, log_likelihood, weights
from camid.proof import calibration
from camid.proof.calibration import calibrate, outside_stated_and_true, read_comparisons, stated_and_true
from camid.proof.concealed.generator import plan

TRUE = Constants(0.4, 0.1, 20.0, -0.5, 0.3, -0.3, 0.8, -2.0, 1.5)


def drawn(count, seed):
    """Comparisons of all kinds, with a truth that is drawn by their weights."""
    generator = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        members = [Member("a", 0.0, 0.0)]
        members += [
            Member(name, generator.exponential(8.0), generator.exponential(0.1), bool(generator.random() < 0.2))
            for name in ("b", "c")[: generator.integers(0, 3)]
        ]
        comparison = Comparison(
            tuple(members),
            share=float(generator.uniform(0.01, 1.0)),
            left=float(generator.choice([0.0, 0.01, 0.1])),
            gain=float(10.0 ** generator.uniform(1.5, 5.0)),
            strongest=bool(generator.random() < 0.7),
            linear=bool(generator.random() < 0.3),
            noise=bool(generator.random() < 0.1),
        )
        names, unlisted = weights(comparison, TRUE)
        choices = [*(name for name, _ in names), ""]
        truth = str(generator.choice(choices, p=[*(weight for _, weight in names), unlisted]))
        found.append((comparison, {truth} - {""}))
    return found


@pytest.mark.slow
def test_the_weights_become_reliable():
    comparisons = drawn(400, 1)
    constants = calibrate(comparisons)
    assert log_likelihood(comparisons, constants) >= log_likelihood(comparisons, TRUE) - 0.002
    table = stated_and_true(drawn(2000, 2), constants)
    many = table[table["members"] >= 100]
    assert len(many) >= 4
    assert np.all(np.abs(many["weight"] - many["share"]) < 0.12)


def test_nothing_to_learn_from_is_refused():
    with pytest.raises(ValueError, match="no effect was named"):
        calibrate([])


def test_comparisons_go_through_json():
    comparisons = drawn(5, 3)
    rows = [{"index": 0, "truth": sorted(truth), "comparison": asdict(c)} for c, truth in comparisons]
    assert read_comparisons(json.loads(json.dumps(rows))) == comparisons


@pytest.mark.slow
def test_a_rig_with_a_strong_effect_is_compared():
    case = next(c for c in plan(13, 60) if c.effects == ("cubic-stiffness",))
    (row,) = calibration.comparisons_of([case])
    assert (row["index"], row["truth"]) == (case.index, ["cubic-stiffness"])
    ((comparison, _),) = read_comparisons([row])
    assert comparison.members[0].identifier == "cubic-stiffness"
    assert comparison.strongest


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "seed", "number", "chances"), [("cubic-stiffness", 13, 60, 2), ("actuator-lag", 19, 480, 1)]
)
def test_two_recordings_are_two_chances_for_a_law_and_one_for_linear_dynamics(effect, seed, number, chances):
    case = next(c for c in plan(seed, number) if c.effects == (effect,))
    ((comparison, _),) = read_comparisons(calibration.comparisons_of_two([case]))
    assert effect in {member.identifier for member in comparison.members}
    assert comparison.chances == chances


def test_what_is_outside_the_catalogue_is_counted_beside_what_is_stated():
    one = Comparison((Member("a", 0.0, 0.0),), share=0.5, left=0.0)
    two = Comparison((Member("a", 0.0, 0.0),), share=0.5, left=0.2, experiments=2)
    noise = Comparison((Member("outliers", 0.0, 0.0),), share=0.0, left=0.0, noise=True)
    rows = [(one, {"a"}), (one, {"b"}), (one, {"a"}), (two, set()), (noise, set())]
    table = outside_stated_and_true(rows, TRUE)
    rows = table.set_index(["left", "experiments"])
    assert rows.loc[("nothing", 1), ["effects", "true"]].tolist() == [3, 1]
    assert rows.loc[("something", 2), ["effects", "true"]].tolist() == [1, 1]
    assert rows.loc[("something", 2), "stated"] > rows.loc[("nothing", 1), "stated"]
    assert rows.loc[("nothing", 1), "from"] < 1 / 3 < rows.loc[("nothing", 1), "to"]
