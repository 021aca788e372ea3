"""A diagnosis is of the rig: units, signs, clocks, names of columns and declarations that hold do not change it."""

import json

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.diagnosis.results_folder import residuals
from tests.support import mass_on_spring
from tests.support.mass_on_spring import PERIOD, command, effect, simulation

COUNT = 400

FORCE = 0.2
FRICTION = effect("coulomb-friction", force=FORCE)
DEAD_ZONE = effect("dead-zone", half_width=0.3)


def record(*effects, count=COUNT, **options):
    """A shorter recording: what is asked here does not depend on the length."""
    return mass_on_spring.record(*effects, count=count, **options)


def names(diagnosis):
    return [f.identifier for f in diagnosis.findings]


def value(diagnosis, identifier, parameter):
    """Value and standard deviation of a parameter."""
    found = next(f for f in diagnosis.findings if f.identifier == identifier).parameters[parameter]
    return found.value, found.standard_deviation


def agrees(diagnosis, identifier, parameter, true):
    found, spread = value(diagnosis, identifier, parameter)
    assert 0.0 < spread < 0.1 * abs(true)
    assert abs(found - true) < 4.5 * spread


def scaled_plant(gain):
    content = simulation()["plant"]["transfer_function"]
    return {
        "transfer_function": {
            "numerator": [gain * b for b in content["numerator"]],
            "denominator": content["denominator"],
        }
    }


@pytest.fixture(scope="module")
def recording():
    return record(FRICTION)


@pytest.fixture(scope="module")
def diagnosis(recording):
    return camid.diagnose(recording, simulation())


# Large and small units and the other sign of either signal.
@pytest.mark.parametrize(
    ("of_input", "of_output"), [(-1e6, 1e-6), (1e-6, -1.0), pytest.param(1.0, 1e6, marks=pytest.mark.slow)]
)
def test_units_and_signs_scale_the_parameters(recording, diagnosis, of_input, of_output):
    changed = recording.assign(u=of_input * recording["u"], y=of_output * recording["y"])
    again = camid.diagnose(changed, simulation(plant=scaled_plant(of_output / of_input)))
    assert again.verdict == diagnosis.verdict == "explained"
    assert names(again) == names(diagnosis) == ["coulomb-friction"]
    assert again.fit.improved == pytest.approx(diagnosis.fit.improved, rel=1e-3)
    was, spread = value(diagnosis, "coulomb-friction", "force")
    now, its_spread = value(again, "coulomb-friction", "force")
    assert abs(now / abs(of_input) - was) < 0.05 * spread
    assert its_spread / abs(of_input) == pytest.approx(spread, rel=0.02)


def test_the_clock_may_begin_anywhere(recording, diagnosis):
    again = camid.diagnose(recording.assign(t=recording["t"] + 1000.0), simulation())
    assert names(again) == names(diagnosis)
    was, spread = value(diagnosis, "coulomb-friction", "force")
    assert abs(value(again, "coulomb-friction", "force")[0] - was) < 0.05 * spread
    assert again.fit.validation[0] == pytest.approx(diagnosis.fit.validation[0] + 1000.0)


def test_times_of_disturbances_are_those_of_the_clock():
    recording = record(effect("step-disturbance", size=0.3, time=4.5))
    again = camid.diagnose(recording.assign(t=recording["t"] + 1000.0), simulation())
    assert names(again)[:1] == ["step-disturbance"]
    assert abs(value(again, "step-disturbance", "time")[0] - 1004.5) < PERIOD


@pytest.mark.slow
def test_columns_may_have_any_name(recording, diagnosis):
    called = {"t": "time [s]", "u": "motor, V", "y": "Ort: \u00b5m <b>"}
    content = simulation(
        time={"column": called["t"]},
        input={"column": called["u"], "hold": "zoh"},
        sensor={"column": called["y"], "kind": "camera"},
    )
    again = camid.diagnose(recording.rename(columns=called)[list(called.values())[::-1]], content)
    said = json.dumps(again.to_mapping(), ensure_ascii=False)
    for symbol, name in called.items():  # a unit that nothing declares bears the column's name
        said = said.replace(f"[{name}]", symbol).replace(name, symbol)
    said, before = json.loads(said), diagnosis.to_mapping()
    for mapping in (said, before):  # experiments name the columns in sentences
        for found in mapping["effects"]:
            del found["separating_experiment"]
    assert said == json.loads(json.dumps(before))


@pytest.mark.slow
def test_irregularly_rounded_times(recording, diagnosis):
    """30 frames a second, written with three decimals: 0.033, 0.067, 0.1."""
    rounded = recording.assign(t=np.round(np.arange(COUNT) / 30.0, 3))
    exact = recording.assign(t=np.arange(COUNT) / 30.0)
    first, second = camid.diagnose(rounded, simulation()), camid.diagnose(exact, simulation())
    assert names(first) == names(second) == names(diagnosis)
    found, spread = value(second, "coulomb-friction", "force")
    assert abs(value(first, "coulomb-friction", "force")[0] - found) < 0.1 * spread


def test_validation_rows_have_no_influence(recording):
    content = simulation(validation={"start": 5.0, "end": 6.5})
    first = camid.diagnose(recording, content)
    rows = recording["t"].between(5.0, 6.5)
    random = np.random.default_rng(np.random.SeedSequence(5))
    changed = recording.assign(y=recording["y"].where(~rows, recording["y"] + 0.01 * random.standard_normal(COUNT)))
    second = camid.diagnose(changed, content)
    assert (first.fit.validation, first.fit.chosen) == ((5.0, 6.5), False)
    assert names(first) == names(second) == ["coulomb-friction"]
    assert second.fit.improved > 1.5 * first.fit.improved
    # The fit is scaled by the whole recording's size, so the last digits may differ, and nothing else.
    np.testing.assert_allclose(first.improved.plant.denominator, second.improved.plant.denominator, rtol=1e-8)
    assert value(first, "coulomb-friction", "force") == pytest.approx(
        value(second, "coulomb-friction", "force"), rel=1e-7
    )


@pytest.mark.slow
def test_several_recordings_are_fitted_together_and_a_fifth_of_each_validates():
    recordings = [record(DEAD_ZONE, seed=seed, count=300) for seed in (1, 2, 3)]
    found = camid.diagnose(recordings, simulation())
    assert (found.verdict, names(found)) == ("explained", ["dead-zone"])
    # The last row of each is not compared: nobody knows what the input did after it.
    assert 3 * 239 <= found.rows_fitted <= 3 * 240
    assert found.conditions.experiments == 3
    agrees(found, "dead-zone", "half_width", 0.3)
    alone = camid.diagnose(recordings[0], simulation())
    table = pd.DataFrame(residuals(found))
    assert list(table.columns) == ["recording", *residuals(alone)]
    for number, recorded in enumerate(recordings, 1):
        rows = table[table["recording"] == number]
        np.testing.assert_array_equal(rows["recorded"], recorded["y"])
        np.testing.assert_allclose(rows["improved"], camid.simulate(recorded, found.improved)["simulated"], atol=1e-6)
        # Nobody knows the input of a last row whose clock runs fast.
        assert (rows["fitted"] == 1).sum() in (239, 240)
        assert (rows["fitted"] == -1).sum() == 1
        assert np.std(rows["residual_improved"]) < np.std(rows["residual_refitted"])
    assert value(found, "dead-zone", "half_width")[1] < value(alone, "dead-zone", "half_width")[1]
    # What validates may say anything without moving what is fitted.
    judging = table[(table["recording"] == 3) & (table["fitted"] == 0)].index - 600
    changed = recordings[2].copy()
    changed.loc[judging, "y"] += 0.01 * np.sin(changed["t"])
    again = camid.diagnose([*recordings[:2], changed], simulation())
    assert value(again, "dead-zone", "half_width") == pytest.approx(value(found, "dead-zone", "half_width"), rel=1e-6)


def moving(*effects, cut=100, **options):
    """A recording that begins while the rig moves."""
    table = record(*effects, count=COUNT + cut, **options).iloc[cut:].reset_index(drop=True)
    return table.assign(t=PERIOD * np.arange(COUNT))


@pytest.mark.slow
def test_a_rig_that_moves_when_the_recording_begins():
    found = camid.diagnose(moving(DEAD_ZONE), simulation(initial_state="estimate"))
    assert (found.verdict, names(found)) == ("explained", ["dead-zone"])
    agrees(found, "dead-zone", "half_width", 0.3)
    nothing = camid.diagnose(moving(), simulation(initial_state="estimate"))
    assert (nothing.verdict, names(nothing)) == ("adequate", [])


def decay(force):
    """A free decay of a lightly damped rig, and what is believed of it."""
    table = record(
        *([effect("coulomb-friction", force=force)] if force else []),
        plant=TransferFunction((100.0,), (1.0, 0.2, 100.0)),
        state=np.array([0.0, 1.0]),
        signal=np.zeros(COUNT),
        noise=0.002,
    )
    plant = {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 0.25, 104.0]}}
    return table.drop(columns="u"), simulation(input=None, initial_state="estimate", plant=plant)


@pytest.mark.slow
def test_friction_in_a_free_decay():
    table, content = decay(0.01)
    found = camid.diagnose(table, content)
    assert names(found)[:1] == ["coulomb-friction"]


def test_a_linear_free_decay_is_adequate():
    table, content = decay(0.0)
    found = camid.diagnose(table, content)
    assert (found.verdict, names(found)) == ("adequate", [])


@pytest.mark.parametrize(
    ("acquisition", "content"),
    [
        ({"sensor": "instant", "exposure": None}, {"sensor": {"column": "y", "kind": "instant"}}),
        (
            {"hold": "foh", "exposure": 0.007, "latency": 0.013},
            {
                "input": {"column": "u", "hold": "foh"},
                "sensor": {"column": "y", "kind": "camera", "exposure": 0.007, "latency": 0.013},
            },
        ),
    ],
    ids=["instant-sensor", "first-order-hold-short-late-exposure"],
)
@pytest.mark.slow
def test_what_is_declared_rightly_is_no_mismatch(acquisition, content):
    nothing = camid.diagnose(record(**acquisition), simulation(**content))
    assert (nothing.verdict, names(nothing)) == ("adequate", [])
    found = camid.diagnose(record(FRICTION, **acquisition), simulation(**content))
    assert (found.verdict, names(found)) == ("explained", ["coulomb-friction"])
    agrees(found, "coulomb-friction", "force", FORCE)


@pytest.mark.parametrize(
    "plant",
    [
        TransferFunction((1.0,), (1.0, 0.5)),
        TransferFunction((40.0,), (1.0, 3.0, 0.0)),
        TransferFunction((4.0, 100.0), (1.0, 2.0, 100.0)),
    ],
    ids=["one-pole", "integrator", "with-a-zero"],
)
@pytest.mark.slow
def test_other_plants(plant):
    """Plants that the catalogue's forces act on in different ways."""
    balanced = command(COUNT) - np.mean(command(COUNT))
    table = record(effect("dead-zone", half_width=0.3), plant=plant, signal=balanced)
    believed = {"transfer_function": {"numerator": list(plant.numerator), "denominator": list(plant.denominator)}}
    found = camid.diagnose(table, simulation(plant=believed))
    assert (found.verdict, names(found)) == ("explained", ["dead-zone"])


def test_an_effect_that_is_known_already_is_kept():
    """The simulation declares the friction, and the dead zone is found besides."""
    content = simulation(effects=[{"id": "coulomb-friction", "parameters": {"force": 0.15}}])
    found = camid.diagnose(record(FRICTION, DEAD_ZONE), content)
    assert (found.verdict, names(found)) == ("explained", ["dead-zone"])
    assert [e.identifier for e in found.improved.effects] == ["coulomb-friction", "dead-zone"]
    friction = found.improved.effects[0]
    spread = friction.standard_deviations["force"]
    assert 0.0 < spread < 0.1 * FORCE
    assert abs(friction.parameters["force"] - FORCE) < 4.5 * spread
