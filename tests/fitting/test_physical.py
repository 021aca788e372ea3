"""Named constants: estimated as such, with deviations, together with effects, latency and skew."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.chain.plant import TransferFunction
from camid.effects.known import declarable_effects
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.errors import InputError

PERIOD, ROWS = 0.01, 1200
TRUTH = {"mass": 1.3, "damping": 2.0, "stiffness": 310.0}
SPRING = {
    "parameters": {"mass": 1.0, "damping": 1.5, "stiffness": 250.0},
    "units": {"mass": "kg"},
    "transfer_function": {"numerator": ["1"], "denominator": ["mass", "damping", "stiffness"]},
}
PLANT = TransferFunction((1.0,), (1.3, 2.0, 310.0))


def signal(seed=0):
    return np.repeat(np.random.default_rng(seed).choice([-1.0, 1.0], ROWS // 4), 4)


def recording(effects=(), latency=0.0, skew=0.0, seed=0, noise=0.01):
    u, t = signal(seed), PERIOD * np.arange(ROWS)
    acquisition = Acquisition(PERIOD, "zoh", "camera", PERIOD, latency)
    skewed = (declarable_effects()["clock-skew"](skew=skew),) if skew else ()
    y = run(Chain(PLANT, acquisition, (*effects, *skewed)), u, t) if effects or skew else sample(PLANT, u, acquisition)
    y = y + noise * np.std(y) * np.random.default_rng(seed + 1000).standard_normal(ROWS)
    return pd.DataFrame({"t": t, "u": u, "y": y})


def simulation(physical, **sensor):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"physical": physical},
        "sensor": {"column": "y", "kind": "camera", "exposure": PERIOD, **sensor},
    }


def off(result, truth):
    """Errors in standard deviations, by constant."""
    return {
        p["name"]: (p["value"] - truth[p["name"]]) / p["standard_deviation"]
        for p in result.parameters()
        if p["state"] == "estimated"
    }


def test_constants_and_coefficients_say_the_same():
    table = recording()
    physical = camid.identify(table, simulation(SPRING))
    plain = dict(
        simulation(SPRING), plant={"transfer_function": {"numerator": [1.0], "denominator": [1.0, 1.5, 250.0]}}
    )
    rational = camid.identify(table, plain)
    assert all(abs(z) < 4.0 for z in off(physical, TRUTH).values())
    values = {p["name"]: p["value"] for p in physical.parameters()}
    b0, a1, a0 = rational.simulation.plant.numerator[0], *rational.simulation.plant.denominator[1:]
    np.testing.assert_allclose(list(values.values()), [1.0 / b0, a1 / b0, a0 / b0], rtol=1e-6)
    deviation = rational.simulation.standard_deviations["numerator"][0] / b0**2
    assert physical.parameters()[0]["standard_deviation"] == pytest.approx(deviation, rel=1e-3)
    assert physical.nrmse == pytest.approx(rational.nrmse, rel=1e-9)


def test_a_fixed_constant_keeps_its_value():
    found = camid.identify(recording(), simulation({**SPRING, "parameters": TRUTH, "fixed": ["mass"]}))
    assert found.parameters()[0] == {
        "name": "mass", "value": 1.3, "standard_deviation": None, "unit": "kg", "state": "fixed",
    }  # fmt: skip
    assert found.simulation.free_numerator.tolist() == [False]
    assert all(abs(z) < 4.0 for z in off(found, TRUTH).values())


def test_what_is_not_free_is_fixed():
    content = simulation({**SPRING, "parameters": TRUTH})
    content["plant"]["free"] = {"mass": False, "stiffness": True}
    found = camid.identify(recording(), content)
    assert [p["state"] for p in found.parameters()] == ["fixed", "estimated", "estimated"]
    both = simulation({**SPRING, "fixed": ["mass"]})
    both["plant"]["free"] = {"mass": True}
    with pytest.raises(InputError, match="'mass' is fixed and free; take it out of one of them"):
        camid.identify(recording(), both)
    stranger = simulation(SPRING)
    stranger["plant"]["free"] = {"mess": False}
    with pytest.raises(InputError, match=r"mess.*did you mean 'mass'"):
        camid.identify(recording(), stranger)


def test_fewer_constants_than_coefficients_are_fitted_as_such():
    """The damping and the gain of two dampers of one kind: their coefficients have to agree."""
    physical = {
        "parameters": {"damping": 1.0, "stiffness": 250.0},
        "transfer_function": {"numerator": ["damping/2"], "denominator": ["1.3", "damping", "stiffness"]},
    }
    found = camid.identify(recording(), simulation(physical))
    assert found.converged
    assert all(abs(z) < 4.0 for z in off(found, TRUTH).values())
    assert found.residual_analysis is not None


def test_what_is_not_determined_is_named():
    physical = {**SPRING, "parameters": {**SPRING["parameters"], "gain": 2.0}}
    physical["transfer_function"] = {**SPRING["transfer_function"], "numerator": ["gain"]}
    found = camid.identify(recording(), simulation(physical))
    assert {p["state"] for p in found.parameters()} == {"undetermined"}
    combinations = {row["expression"]: row for row in found.combinations()}
    assert set(combinations) == {"damping/mass", "stiffness/mass", "gain/mass"}
    for text, truth in (("damping/mass", 2.0 / 1.3), ("stiffness/mass", 310.0 / 1.3), ("gain/mass", 1.0 / 1.3)):
        row = combinations[text]
        assert abs(row["value"] - truth) < 4.0 * row["standard_deviation"]
    assert any("determines damping/mass" in sentence for sentence in found.warnings())


def test_what_is_held_moves_where_it_leaves_no_way_to_the_coefficients():
    """With the believed stiffness of the bearing no positive one of the spring makes the recorded stiffness."""
    physical = {
        "parameters": {"bearing": 400.0, "spring": 50.0, "mass": 1.3, "damping": 2.0},
        "transfer_function": {"numerator": ["1"], "denominator": ["mass", "damping", "bearing + spring^2"]},
    }
    found = camid.identify(recording(), simulation(physical))
    values = {p["name"]: p["value"] for p in found.parameters()}
    assert values["bearing"] + values["spring"] ** 2 == pytest.approx(310.0, rel=0.01)
    assert values["bearing"] < 400.0
    assert any(f"given with bearing at {values['bearing']:g}" in sentence for sentence in found.warnings())


def test_the_result_is_a_simulation_again(tmp_path):
    found = camid.identify(recording(), simulation(SPRING))
    camid.write_simulation(found.simulation, tmp_path / "model.yaml")
    again = camid.load_simulation(tmp_path / "model.yaml")
    assert again.physical.parameters == pytest.approx(dict(found.simulation.physical.parameters))
    assert again.physical.standard_deviations == pytest.approx(found.simulation.physical.standard_deviations)
    simulated = camid.simulate(recording(), tmp_path / "model.yaml")
    assert np.std(simulated["simulated"] - simulated["y"]) < 0.02 * np.std(simulated["y"])


@pytest.mark.slow
def test_friction_beside_constants():
    friction = declarable_effects()["coulomb-friction"](force=0.15)
    found = camid.diagnose(recording((friction,)), simulation(SPRING))
    assert found.findings[0].identifier in ("coulomb-friction", "asymmetric-friction")
    coefficients = {c.name: c for c in found.coefficients}
    assert set(coefficients) == set(TRUTH)
    for name, truth in TRUTH.items():
        assert abs(coefficients[name].improved - truth) < 4.0 * coefficients[name].improved_deviation
    assert found.improved.physical.parameters["mass"] == coefficients["mass"].improved


def test_equations_are_identified_from_constants_that_are_wrong_by_a_factor_of_two():
    physical = {
        "parameters": {"mass": 0.7, "damping": 4.0, "stiffness": 600.0},
        "equations": {
            "states": {"position": "speed", "speed": "(u - damping*speed - stiffness*position)/mass"},
            "output": "position",
        },
    }
    found = camid.identify(recording(), simulation(physical))
    assert all(abs(z) < 4.0 for z in off(found, TRUTH).values())
    exact = camid.identify(recording(), simulation(SPRING))
    for one, other in zip(found.parameters(), exact.parameters(), strict=True):
        assert one["standard_deviation"] == pytest.approx(other["standard_deviation"], rel=0.1)


@pytest.mark.parametrize("physical", [SPRING, None], ids=["named constants", "coefficients"])
def test_an_open_latency_is_estimated(physical):
    declared = simulation(SPRING, latency="estimate")
    if physical is None:
        declared["plant"] = {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 1.5, 250.0]}}
    found = camid.identify(recording(latency=0.0137), declared)
    assert abs(found.simulation.latency - 0.0137) < 4.0 * found.simulation.latency_deviation
    assert found.simulation.latency_deviation < 0.02 * PERIOD
    assert [row["name"] for row in found.constants()][-1] == "latency of the sensor"


def test_an_open_skew_is_estimated():
    declared = simulation(SPRING, latency="estimate", skew="estimate")
    found = camid.identify(recording(latency=0.0137, skew=4e-4), declared)
    assert abs(found.simulation.skew - 4e-4) < 4.0 * found.simulation.skew_deviation
    assert abs(found.simulation.latency - 0.0137) < 4.0 * found.simulation.latency_deviation
    assert all(abs(z) < 4.0 for z in off(found, TRUTH).values())
    simulated = camid.simulate(recording(skew=4e-4, latency=0.0137), found.simulation)
    assert np.std(simulated["simulated"] - simulated["y"]) < 0.02 * np.std(simulated["y"])


def test_an_open_latency_is_no_finding():
    declared = simulation(SPRING, latency="estimate")
    found = camid.diagnose(recording(latency=0.0137), declared)
    assert found.verdict in ("adequate", "explained")
    assert not found.findings
    assert any(u.identifier == "delay" and "leaves the latency open" in u.reason for u in found.undetectable)


def test_nothing_is_simulated_before_the_latency_is_known():
    with pytest.raises(camid.InputError, match="the latency is not known yet"):
        camid.simulate(recording(), simulation(SPRING, latency="estimate"))


def test_a_latency_at_zero_is_zero_and_said():
    """Time stamps that are early: no latency explains them."""
    table = recording(latency=0.0)
    table["y"] = table["y"].shift(-1, fill_value=table["y"].iloc[-1])
    found = camid.identify(table, simulation(SPRING, latency="estimate"))
    assert found.simulation.latency == 0.0
    assert any("ended at zero" in sentence for sentence in found.warnings())
