"""Two columns of one sensor: fitted together, weighted by their noise, simulated and diagnosed."""

import numpy as np
import pytest

import camid
from camid.errors import InputError
from camid.identification.from_recordings import experiments_of
from camid.simulation.file import load_simulation, write_simulation
from tests.support.swinging_marker import COLUMNS, PLANT, SIMULATION, TRUTH, swinging_marker


@pytest.fixture(scope="module")
def identified():
    return camid.identify(swinging_marker(), SIMULATION)


def test_constants_of_plant_and_camera_lie_within_their_deviations(identified):
    physical = identified.simulation.physical
    for name, value in TRUTH.items():
        deviation = physical.standard_deviations[name]
        assert abs(physical.parameters[name] - value) < 3.5 * deviation, name
    assert identified.converged
    assert identified.nrmse < 0.01


def test_the_model_is_written_and_read_as_it_is(identified, tmp_path):
    path = tmp_path / "model.yaml"
    write_simulation(identified.simulation, path)
    read = load_simulation(path)
    assert read.output_columns == ("x", "y")
    assert read.physical.equations.readings == tuple(COLUMNS.values())
    table = camid.simulate(swinging_marker(), read)
    for name, noise in (("x", 0.1), ("y", 0.3)):
        error = np.std(table[f"simulated_{name}"] - table[name])
        assert error == pytest.approx(noise, rel=0.1)


def test_columns_are_weighted_by_their_noise():
    _, experiments, _ = experiments_of(swinging_marker(), load_simulation(SIMULATION), None)
    assert [e.same_run_as for e in experiments] == [None, 0]
    assert [e.seen for e in experiments] == [0, 1]
    assert experiments[0].weight == 1.0
    assert experiments[1].weight == pytest.approx(1.0 / 3.0, rel=0.1)
    assert [e.estimate_initial_state for e in experiments] == [True, False]


def test_an_input_and_rest():
    driven = {**SIMULATION, "input": {"column": "u", "hold": "zoh"}, "initial_state": "zero"}
    driven["plant"] = {"physical": {**PLANT["physical"], "equations": {**PLANT["physical"]["equations"], "start": {}}}}
    found = camid.identify(swinging_marker(push=2.0), driven)
    physical = found.simulation.physical
    assert abs(physical.parameters["stiffness"] - 5.7) < 4.0 * physical.standard_deviations["stiffness"]


@pytest.mark.slow
def test_diagnose_names_friction_of_both_columns():
    found = camid.diagnose(swinging_marker(friction=0.12), SIMULATION)
    assert found.findings[0].identifier == "coulomb-friction"
    assert found.findings[0].parameters["force"].value == pytest.approx(0.12, abs=0.01)
    assert len(found.recordings) == 2
    assert found.recordings[1].endswith(", y")
    # In the column's own units.
    table = swinging_marker(friction=0.12)
    np.testing.assert_allclose(found.further_signals[0].recorded, table["y"])


@pytest.mark.slow
def test_diagnose_finds_nothing_where_nothing_is():
    assert camid.diagnose(swinging_marker(seed=3), SIMULATION).verdict == "adequate"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"columns": {"x": "x_rest + sin(angel)", "y": COLUMNS["y"]}}, "unknown name 'angel': did you mean 'angle'"),
        ({"columns": {"x": "abs(angle)", "y": COLUMNS["y"]}}, "has a kink"),
        ({"columns": COLUMNS, "column": "x"}, "column and columns are both given"),
        ({"columns": COLUMNS, "offset": "estimate"}, "an offset of several columns"),
        ({"columns": {"x": COLUMNS["x"], "z": COLUMNS["y"]}}, "no column 'z'"),
        ({"columns": {"x": COLUMNS["x"], "t": COLUMNS["y"]}}, "are the same column 't'"),
        ({}, "no column is named"),
    ],
)
def test_what_columns_cannot_be_is_refused_in_one_line(change, said):
    with pytest.raises(InputError) as refused:
        camid.identify(swinging_marker(), {**SIMULATION, "sensor": {"kind": "camera", **change}})
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_columns_need_equations():
    plant = {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.1, 6.0]}}
    with pytest.raises(InputError, match="several columns read states of a plant of equations"):
        camid.identify(swinging_marker(), {**SIMULATION, "plant": plant})
