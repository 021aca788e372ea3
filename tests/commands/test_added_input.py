"""A known signal that is added to the input counts like the input in every command."""

import numpy as np
import pytest

import camid
from camid.errors import InputError
from camid.simulation.file import load_simulation
from tests.support import linear_rig as rig

WITH_FORCE = {"column": "u", "hold": "zoh", "added": [{"column": "force", "unit": "mN", "scale": 2.0}]}


@pytest.fixture(scope="module")
def table():
    """The input u of the rig, split into a command and a force in halves of millinewtons."""
    whole = rig.recording()
    force = rig.steps(len(whole), seed=9, length=7)
    return whole.assign(whole=whole["u"], u=whole["u"] - force, force=force / 2.0 * 1e3)


def test_identify_and_simulate_see_the_sum(table):
    believed, reference = rig.simulation(input=WITH_FORCE), rig.simulation(input={"column": "whole", "hold": "zoh"})
    found, expected = (camid.identify(table, s) for s in (believed, reference))
    np.testing.assert_allclose(found.simulation.plant.denominator, expected.simulation.plant.denominator, rtol=1e-9)
    assert found.nrmse == pytest.approx(expected.nrmse, rel=1e-9)
    ignored = camid.identify(table, rig.simulation(input={"column": "u", "hold": "zoh"}))
    assert ignored.nrmse > 2.0 * found.nrmse
    one, other = (camid.simulate(table, s)["simulated"] for s in (believed, reference))
    np.testing.assert_allclose(one, other, atol=1e-12)
    written = found.simulation.to_mapping()["input"]
    assert written["added"] == [{"column": "force", "unit": "mN", "scale": 2.0}]
    assert load_simulation(found.simulation.to_mapping()).reading.added == found.simulation.reading.added


def test_diagnose_finds_nothing_left_out(table):
    assert camid.diagnose(table, rig.simulation(input=WITH_FORCE)).verdict == "adequate"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"input": WITH_FORCE | {"added": [{"column": "u"}]}}, "column 'u' is named twice; scale it instead"),
        ({"input": WITH_FORCE | {"added": "force"}}, "input.added: 'force' is not a list; expected: "),
        ({"input": WITH_FORCE | {"added": [{"column": "y"}]}}, "output and the added y are the same column 'y'"),
        ({"input": WITH_FORCE | {"added": [{"column": "forse"}]}}, "no column 'forse'; did you mean 'force'?"),
        ({"input": WITH_FORCE | {"added": [{"column": "force", "unit": "mn"}]}}, "input, added.0.unit"),
        (
            {"input": WITH_FORCE, "controller": {"reference": "r", "position_gain": 1.0, "velocity_gain": 1.0}},
            "a controller makes the input, and a signal is added to it",
        ),
    ],
)
def test_refusals(table, changes, said):
    with pytest.raises(InputError) as caught:
        camid.identify(table, rig.simulation(**changes))
    assert said.partition(", added")[0] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_runs_rename_only_what_the_simulation_names(table):
    believed = rig.simulation(recording={"runs": [{"v": "u"}]})
    with pytest.raises(InputError, match=r"recording.runs.0: the simulation names no column 'v'"):
        load_simulation(believed)


def test_runs_side_by_side_are_experiments(table):
    other = rig.recording(seed=5)
    both = table.assign(u2=other["u"], y2=other["y"])[["t", "whole", "y", "u2", "y2"]]
    runs = [{"u": "whole"}, {"u": "u2", "y": "y2"}]
    found = camid.identify(both, rig.simulation(recording={"runs": runs}))
    apart = camid.identify([table.assign(u=table["whole"]), other], rig.simulation())
    np.testing.assert_allclose(found.simulation.plant.denominator, apart.simulation.plant.denominator, rtol=1e-9)
    simulated = camid.simulate(both, found.simulation)
    assert list(simulated["experiment"].unique()) == ["whole", "u2, y2"]
    assert load_simulation(found.simulation.to_mapping()).reading.runs == tuple(runs)
