"""The linear part of every kind of model, its uncertainty, and what is said of the rest."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig
from tests.support.swinging_marker import SIMULATION as TWO_COLUMNS
from tests.support.swinging_marker import swinging_marker


def model(plant, **changes):
    return rig.simulation(plant=plant, sensor={"column": "y", "kind": "instant"}, **changes)


def frequency_deviation(*models):
    return [r.frequency_deviation for r in camid.poles(*models).roots if r.value.imag > 0.0]


def test_named_constants_have_the_band_of_the_coefficients_that_they_make(tmp_path):
    """As many constants as coefficients, of which only ratios are determined: the plant is as well known either way."""
    recording = rig.recording(count=400)
    physical = {
        "parameters": {"mass": 0.02, "damping": 0.05, "stiffness": 2.0, "force_constant": 3.0},
        "transfer_function": {"numerator": ["force_constant"], "denominator": ["mass", "damping", "stiffness"]},
    }
    found = []
    for name, plant in (("named", {"physical": physical}), ("free", rig.plant([290.0], [2.0, 6.0, 200.0]))):
        camid.write_simulation(camid.identify(recording, rig.simulation(plant=plant)).simulation, tmp_path / name)
        found.append(camid.bode(tmp_path / name, frequencies=(1.0, 100.0)).numbers)
    for column in ("magnitude_db", "magnitude_db_deviation", "phase_deviation"):
        np.testing.assert_allclose(found[0][column], found[1][column], rtol=2e-3)


PENDULUM = {
    "pendulum": {"natural_frequency": 5.0, "damping": 0.1, "gain": 0.5, "rest": 3.1},
    "standard_deviations": {"natural_frequency": 0.02, "damping": 0.003, "gain": 0.01, "rest": 0.1},
    "covariance": np.diag(np.square([0.02, 0.003, 0.01, 0.1])).tolist(),
}


def test_a_pendulum_is_linearised_about_its_rest():
    view = camid.poles(model(PENDULUM))
    (root,) = [r for r in view.roots if r.value.imag > 0.0]
    assert root.natural_frequency == pytest.approx(5.0)
    assert root.frequency_deviation == pytest.approx(0.02, rel=1e-4)
    assert root.damping_deviation == pytest.approx(0.003, rel=1e-4)
    assert "linearised about its rest at 3.1\u00a0rad" in view.said()[0]
    gain = camid.bode(model(PENDULUM), frequencies=(1e-3, 1.0)).numbers.iloc[0]
    assert gain["magnitude"] == pytest.approx(0.5, rel=1e-4)
    assert gain["magnitude_db_deviation"] == pytest.approx(8.686 * 0.01 / 0.5, rel=1e-3)


def equations(start=0.0, **more):
    """A pendulum again: weight/inertia = 25 (rad/s)²."""
    return {
        "physical": {
            "parameters": {"weight": 2.5, "friction": 0.1},
            "equations": {
                "states": {"angle": "speed", "speed": "(u - friction*speed - weight*sin(angle))/0.1"},
                "output": "angle",
                "start": {"angle": start},
            },
        },
        **more,
    }


def test_equations_are_linearised_about_their_start():
    known = {"standard_deviations": {"weight": 0.05, "friction": 0.01}, "covariance": [[0.0025, 0.0], [0.0, 1e-4]]}
    view = camid.poles(model(equations(**known)))
    (root,) = [r for r in view.roots if r.value.imag > 0.0]
    assert root.natural_frequency == pytest.approx(5.0, rel=1e-6)
    assert root.frequency_deviation == pytest.approx(0.5 * 5.0 * 0.05 / 2.5, rel=1e-3)
    assert view.said() == ("model 1: nonlinear equations, linearised about angle = 0, speed = 0, without input",)
    elsewhere = camid.poles(model(equations(start=1.0))).said()[0]
    assert elsewhere.endswith("without input, where it does not rest")


def test_several_columns_see_an_output_of_the_equations():
    driven = TWO_COLUMNS | {"input": {"column": "u", "hold": "zoh"}, "initial_state": "zero"}
    view = camid.bode(driven)
    assert (view.units.text("u"), view.units.text("y")) == ("u", "angle")
    assert any("to the plant's output 'angle'" in sentence for sentence in view.said())
    physical = driven["plant"]["physical"]
    at_rest = {"physical": {**physical, "equations": {**physical["equations"], "start": {}}}}
    assert camid.step(driven | {"plant": at_rest}, duration=5.0).units.output.column == "angle"
    with pytest.raises(InputError, match="a recording shows x, y, and not the plant's output 'angle'"):
        camid.bode(driven, recording=swinging_marker(push=0.4, seconds=6.0))


def test_linear_effects_are_part_of_the_plant_and_others_are_named():
    mode = {"id": "extra-mode", "parameters": {"natural_frequency": 40.0, "damping": 0.02}}
    mode["standard_deviations"] = {"natural_frequency": 0.3, "damping": 0.002}
    drag = {"id": "quadratic-drag", "parameters": {"coefficient": 0.1}}
    view = camid.poles(rig.simulation(effects=[mode, drag]))
    slow, fast = (r for r in view.roots if r.value.imag > 0.0)
    assert (slow.natural_frequency, fast.natural_frequency) == pytest.approx((10.0, 40.0))
    assert fast.frequency_deviation == pytest.approx(0.3, rel=1e-3)
    assert slow.frequency_deviation < 1e-6
    assert "without quadratic-drag (not linear dynamics of the plant)" in view.said()[0]
    assert "without their correlation with the plant" in view.said()[1]


def test_parameters_at_their_bounds_are_not_moved_past_them():
    lag = {"id": "actuator-lag", "parameters": {"time_constant": 0.0}, "standard_deviations": {"time_constant": 0.01}}
    assert len(camid.poles(rig.simulation(effects=[lag])).roots) == 2


@pytest.mark.parametrize(
    ("plant", "said"),
    [
        (rig.plant([1.0], [1.0, 1.0, 4.0]), "without a band, as it states no accuracy"),
        ({k: v for k, v in PENDULUM.items() if k != "covariance"}, "standard deviations and no covariance"),
    ],
)
def test_why_there_is_no_band_is_said(plant, said):
    for view in (camid.bode(model(plant)), camid.poles(model(plant)), camid.step(model(plant))):
        assert said in " ".join(view.said())


def test_a_free_decay_says_nothing_of_the_gain():
    plant = rig.plant([16.0], [1.0, 0.1, 16.0])
    view = camid.bode(model(plant, input=None, initial_state="estimate"))
    assert any("a free decay says nothing of the numerator" in sentence for sentence in view.said())


def test_a_plant_that_is_far_from_sure_has_no_band_where_it_cannot_be_run():
    wide = PENDULUM | {"covariance": np.diag([25.0, 0.25, 0.25, 0.25]).tolist()}
    view = camid.step(model(wide), amplitude=0.2, duration=2.0)
    assert np.all(np.isfinite(view.curves[0].output))
    assert view.curves[0].deviation is None or np.all(np.isfinite(view.curves[0].deviation))


@pytest.mark.parametrize("given", [5, None, [1.0], pd.DataFrame({"t": [0.0]})])
@pytest.mark.parametrize("draw", [camid.bode, camid.poles, camid.step])
def test_what_is_no_model_is_refused(draw, given):
    with pytest.raises(InputError, match="is not a model; give a simulation"):
        draw(given)


def test_equations_that_no_input_drives_have_no_step_response():
    still = {
        "physical": {
            "parameters": {"k": 1.0},
            "equations": {"states": {"x": "-k*x*abs(x)"}, "output": "x", "start": {"x": 1.0}},
        }
    }
    with pytest.raises(InputError, match="a step of it moves nothing"):
        camid.step(model(still, input=None, initial_state="estimate"))
