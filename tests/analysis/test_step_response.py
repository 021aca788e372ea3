"""Step responses: linear plants against scipy, nonlinear ones against what they must do at rest."""

import numpy as np
import pytest
from scipy.signal import step as scipy_step

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig


def test_a_linear_response_is_that_of_scipy():
    (curve,) = camid.step(rig.simulation(), amplitude=2.0, duration=3.0).curves
    _, expected = scipy_step((rig.NUMERATOR, rig.DENOMINATOR), T=curve.time)
    np.testing.assert_allclose(curve.output, 2.0 * expected, atol=1e-8)
    assert curve.linear
    assert curve.deviation is None


def test_characteristics_of_a_second_order_plant():
    """Natural frequency 10 rad/s, damping ratio 0.15, static gain 1.5, by their formulas."""
    (curve,) = camid.step(rig.simulation()).curves
    found = {name: value for name, (value, _) in curve.characteristics.items()}
    damped = 10.0 * np.sqrt(1.0 - 0.15**2)
    assert found["final_value"] == pytest.approx(1.5)
    assert found["overshoot"] == pytest.approx(np.exp(-np.pi * 0.15 / np.sqrt(1.0 - 0.15**2)), rel=1e-5)
    assert found["peak_time"] == pytest.approx(np.pi / damped, rel=1e-5)
    fine = np.linspace(0.0, 8.0, 400001)
    exact = 1.0 - np.exp(-1.5 * fine) * (np.cos(damped * fine) + 1.5 / damped * np.sin(damped * fine))
    crossed = [fine[np.argmax(exact >= level)] for level in (0.1, 0.9)]
    assert found["rise_time"] == pytest.approx(crossed[1] - crossed[0], abs=4e-5)
    assert found["settling_time"] == pytest.approx(fine[np.flatnonzero(np.abs(exact - 1.0) > 0.02)[-1]], abs=4e-5)


def test_the_band_is_the_spread_of_models_drawn_from_the_covariance(identified):
    simulation = identified.simulation
    (curve,) = camid.step(identified, duration=2.0).curves
    mean = np.array([*simulation.plant.numerator, *simulation.plant.denominator[1:]])
    drawn = np.random.default_rng(0).multivariate_normal(mean, simulation.covariance, 400)
    lead = simulation.plant.denominator[0]
    every = [scipy_step(([b], [lead, a1, a0]), T=curve.time)[1] for b, a1, a0 in drawn]
    rows = slice(20, None)  # before, nothing has moved
    np.testing.assert_allclose(curve.deviation[rows], np.std(every, axis=0)[rows], rtol=0.2)
    overshoots = [np.max(y) / (b / a0) - 1.0 for y, (b, _, a0) in zip(every, drawn, strict=True)]
    assert curve.characteristics["overshoot"][1] == pytest.approx(np.std(overshoots), rel=0.15)
    finals = drawn[:, 0] / drawn[:, 2]
    assert curve.characteristics["final_value"][1] == pytest.approx(np.std(finals), rel=0.15)


def test_friction_holds_the_plant_where_it_sticks():
    """With dry friction of 0.4 a step of 0.3 moves nothing, and one of 1 stops within the friction of the balance."""
    model = rig.simulation(effects=[{"id": "coulomb-friction", "parameters": {"force": 0.4}}])
    (still,) = camid.step(model, amplitude=0.3, duration=3.0).curves
    assert not np.any(still.output)  # the engine creeps by some 1e-15
    assert still.characteristics == {"final_value": (0.0, None)}
    assert "does not move it" in " ".join(camid.step(model, amplitude=0.3, duration=3.0).remarks)
    view = camid.step(model, amplitude=1.0, duration=5.0)
    (moved,) = view.curves
    final = moved.characteristics["final_value"][0]
    assert abs(final - 1.5) <= 1.5 * 0.4 + 1e-6
    assert abs(final - 1.5) > 1e-3
    assert not moved.linear
    assert any("another amplitude has another shape" in sentence for sentence in view.said())


def test_parameters_of_effects_widen_the_band():
    friction = {"id": "coulomb-friction", "parameters": {"force": 0.2}, "standard_deviations": {"force": 0.02}}
    (curve,) = camid.step(rig.simulation(effects=[friction]), duration=4.0).curves
    assert curve.deviation[-1] > 0.01
    (known,) = camid.step(rig.simulation(effects=[{**friction, "standard_deviations": {"force": 1e-6}}])).curves
    assert known.deviation[-1] < 1e-4


def test_a_pendulum_is_pushed_to_where_its_weight_balances():
    """sin y = gain · u at rest, wherever it hangs still."""
    for rest in (0.0, np.pi):
        model = {
            "schema": 1,
            "time": {"column": "t"},
            "input": {"column": "u", "hold": "zoh"},
            "plant": {"pendulum": {"natural_frequency": 5.0, "damping": 0.4, "gain": 0.5, "rest": rest}},
            "sensor": {"column": "angle", "kind": "instant"},
        }
        (curve,) = camid.step(model, amplitude=1.6, duration=6.0).curves
        assert curve.characteristics["final_value"][0] == pytest.approx(np.arcsin(0.8), abs=2e-3)


def test_a_mode_in_series_is_linear_and_a_sensor_is_not_seen():
    effects = [
        {"id": "extra-mode", "parameters": {"natural_frequency": 40.0, "damping": 0.02}},
        {"id": "lens-distortion", "parameters": {"k1": 0.1}},
    ]
    (curve,) = camid.step(rig.simulation(effects=effects), duration=2.0).curves
    both = np.polymul(rig.DENOMINATOR, [1.0, 1.6, 1600.0])
    _, expected = scipy_step((1600.0 * np.array(rig.NUMERATOR), both), T=curve.time)
    np.testing.assert_allclose(curve.output, expected, atol=1e-7)
    assert curve.linear


def test_a_mode_that_rings_for_long_is_not_aliased():
    """A damping ratio of 0.002: a thousand cycles, whose extremes have to be met."""
    view = camid.step(rig.simulation(plant=rig.plant([100.0], [1.0, 0.04, 100.0])))
    (curve,) = view.curves
    assert curve.output.max() == pytest.approx(1.0 + np.exp(-np.pi * 0.002), abs=0.01)
    envelope = 1.0 + np.exp(-0.02 * curve.time)
    blocks = np.array_split(np.arange(len(curve.time)), 100)
    assert all(curve.output[b].max() > envelope[b[-1]] - 0.02 for b in blocks)


@pytest.mark.parametrize(
    ("first", "second"), [((0.6,), (1.0, 2.2, 110.0)), ((3.0,), (1.0, 6.0)), ((2.0,), (1.0, 401.0, 400.0))]
)
@pytest.mark.parametrize("effects", [[], [{"id": "dead-zone", "parameters": {"half_width": 1e-9}}]])
def test_a_long_duration_changes_nothing_that_is_read_off(first, second, effects):
    model = rig.simulation(plant=rig.plant([*first], [*second]), effects=effects)
    short, long = (
        camid.step(model, duration=duration).curves[0].characteristics for duration in (10.0, 2e3 if effects else 3e6)
    )
    assert short.keys() == long.keys() >= {"rise_time", "settling_time"}
    for name, (value, _) in short.items():
        assert long[name][0] == pytest.approx(value, rel=2e-2 if effects else 1e-3), name


def test_more_cycles_than_can_be_shown_are_refused_with_the_longest_duration():
    ringing = rig.simulation(plant=rig.plant([100.0], [1.0, 1e-4, 100.0]))
    with pytest.raises(InputError, match=r"cycles of the mode at 10 rad/s.* give a duration of at most 1600 s"):
        camid.step(ringing, duration=3e4)
    assert len(camid.step(ringing, duration=1550.0).curves[0].time) > 19000


def test_an_integrator_comes_to_no_rest():
    view = camid.step(rig.simulation(plant=rig.plant([1.0], [1.0, 2.0, 0.0])))
    assert view.curves[0].characteristics == {}
    assert "has not come to rest" in str(view.short_table().rows)
    assert view.figure() is not None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"amplitude": 0.0}, "a step of 0; give a number other than zero"),
        ({"amplitude": float("nan")}, "a step of nan"),
        ({"duration": 0.0}, "a duration of 0 s"),
        ({"duration": float("inf")}, "a duration of inf s"),
    ],
)
def test_no_step_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        camid.step(rig.simulation(), **options)


def test_a_plant_that_moves_by_itself_has_no_step_from_rest():
    content = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {
            "physical": {
                "parameters": {"stiffness": 16.0},
                "equations": {"states": {"x": "v", "v": "u - stiffness*x - v"}, "output": "x", "start": {"x": 80.0}},
            }
        },
        "sensor": {"column": "y", "kind": "instant"},
    }
    with pytest.raises(InputError, match="a step is from rest, and the plant does not rest where its equations start"):
        camid.step(content)
