"""Laws that are another one beside a constant, and names that a diagnosis lists twice."""

import pytest

from camid.experiment_design.hypothesis import hypothesis_of
from camid.experiment_design.separation import Judge, Pair
from camid.experiment_design.sources import known_from_mapping
from camid.experiment_design.sums import laws_that_are_sums, warnings_of, without_sums
from camid.simulation.file import load_simulation
from tests.experiment_design.test_design import believed
from tests.support.mass_on_spring import PERIOD, effect

COULOMB = effect("coulomb-friction", force=0.1)
UNEVEN = effect("asymmetric-friction", forward=0.1, backward=0.09)
KNOWN = {"column": "y", "kind": "camera", "offset": 0.0}


def hypothesis(law, weight=0.5, **changes):
    return hypothesis_of(
        load_simulation(believed(law, **changes)), law.identifier, PERIOD, weight=weight, question="one"
    )


def test_friction_of_two_sizes_is_coulomb_friction_beside_a_constant_that_is_estimated():
    two = [hypothesis(COULOMB), hypothesis(UNEVEN)]
    (law,) = laws_that_are_sums(two)
    assert (law.identifier, law.special) == ("asymmetric-friction", "coulomb-friction")
    assert without_sums(two) == two[:1]
    (said,) = warnings_of(two)
    assert said.startswith("if it is Coulomb friction, Asymmetric Coulomb friction stays possible whatever is played")


def test_with_every_constant_declared_an_experiment_tells_them_apart():
    known = {"sensor": KNOWN, "input": {"column": "u", "hold": "zoh", "bias": 0.0}}
    two = [hypothesis(COULOMB, **known), hypothesis(UNEVEN, **known)]
    assert laws_that_are_sums(two) == warnings_of(two) == []
    assert without_sums(two) == two


def test_what_no_experiment_takes_away_keeps_its_weight():
    """As a diagnosis states it: three to seven, the prior odds of what makes friction uneven."""
    two = [hypothesis(COULOMB), hypothesis(effect("quadratic-drag", coefficient=0.01))]
    pairs = [Pair(0, 1, 1e4, 1e4)]
    without, with_it = Judge(two, 500), Judge(two, 500, sums=laws_that_are_sums(two))
    assert without.weight(0, pairs, 500) > 0.95
    assert with_it.weight(0, pairs, 500) == pytest.approx(0.7 * without.weight(0, pairs, 500), rel=0.01)
    # A search climbs what an experiment can do.
    assert with_it.separation(0, pairs, 500) == without.separation(0, pairs, 500)


def test_a_name_that_a_diagnosis_lists_twice_is_one_hypothesis(diagnosis):
    content = diagnosis.to_mapping()
    first = content["hypotheses"][0]
    again = {**first, "weight": 0.02, "criterion": first["criterion"] + 5.0, "misfit": 7.0}
    known = known_from_mapping({**content, "hypotheses": [*content["hypotheses"], again]}, "here")
    found = [h for h in known.hypotheses if h.identifier == first["id"]]
    assert [h.weight for h in found] == pytest.approx([first["weight"] + 0.02])
    assert found[0].misfit == first["misfit"]
    assert len(known.hypotheses) == len(known_from_mapping(content, "here").hypotheses)
