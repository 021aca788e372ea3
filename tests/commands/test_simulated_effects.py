"""What `simulate` makes of the effects that a simulation declares, and what it says of those that do not show."""

import numpy as np
import pytest

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig


def test_an_effect_without_parameters_needs_none():
    table = rig.recording(200)
    short, long = (rig.simulation(effects=[{"id": "absolute-value", **more}]) for more in ({}, {"parameters": {}}))
    simulated = camid.simulate(table, short)["simulated"]
    assert simulated.min() >= 0.0
    np.testing.assert_array_equal(simulated, camid.simulate(table, long)["simulated"])
    with pytest.raises(InputError, match="needs the parameter 'force'"):
        camid.simulate(table, rig.simulation(effects=[{"id": "coulomb-friction"}]))


def test_simulate_says_which_effects_do_not_show_in_the_expected_output():
    table = rig.recording(200)
    rounded = [{"id": "quantisation", "parameters": {"step": 0.1}}]
    simulated, without = camid.simulate(table, rig.simulation(effects=rounded)), camid.simulate(table, rig.simulation())
    np.testing.assert_allclose(simulated["simulated"], without["simulated"], atol=1e-9)
    assert simulated.attrs["warnings"] == [
        "the simulated output is the expected one: quantisation changes only what is scattered around it"
    ]
    assert "warnings" not in without.attrs
