"""The Python interface: identification from recordings that camid did not make, and what it refuses."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.errors import InputError
from tests.support import linear_rig as rig

TRUTH = np.array([*rig.NUMERATOR, *rig.DENOMINATOR])


def sensor(exposure=1.0, latency=0.0):
    content = {"column": "y", "kind": "camera" if exposure else "instant", "latency": latency * rig.PERIOD}
    return content if exposure in {0.0, 1.0} else content | {"exposure": exposure * rig.PERIOD}


def believed(numerator=(200.0,), denominator=(2.0, 9.0, 260.0), **changes):
    """A simulation that is wrong in every coefficient but the leading one."""
    more = changes.pop("plant", {})
    return rig.simulation(plant=rig.plant([*numerator], [*denominator], **more), **changes)


def refusal(table, simulation, command=camid.identify, **options):
    with pytest.raises(InputError) as caught:
        command(table, simulation, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def assert_recovered(result, deviations=4.0, free=(True, True, True)):
    """The free coefficients lie within their standard deviations, and these are worth something."""
    model = result.simulation
    assert result.converged
    found = np.array([*model.plant.numerator, *model.plant.denominator])
    stated = np.array([*model.standard_deviations["numerator"], *model.standard_deviations["denominator"]])
    free = np.array([free[0], False, *free[1:]])
    assert np.all((stated > 0.0) == free)
    assert np.all(stated[free] < 0.06 * TRUTH[free])
    assert np.all(np.abs(found - TRUTH)[free] < deviations * stated[free])
    return found


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize(("exposure", "latency"), [(1.0, 0.0), (0.4, 1.3), (0.0, 0.6)])
@pytest.mark.parametrize("moving", [False, True])
def test_identify_recovers_the_plant(hold, exposure, latency, moving):
    """20 dB of noise; where the rig moves at the start, its past is cut off and only estimating its state will do."""
    before = 9 if moving else 0
    table = rig.recording(600, before=before, hold=hold, exposure=exposure, latency=latency)
    assert not moving or abs(table["y"][0]) > 0.3
    content = believed(
        input={"column": "u", "hold": hold},
        sensor=sensor(exposure, latency),
        initial_state="estimate" if moving else "zero",
    )
    result = camid.identify(table, content)
    assert_recovered(result)
    assert result.nrmse == pytest.approx(0.1, rel=0.1)
    if moving:
        at_rest = camid.identify(table, content | {"initial_state": "zero"})
        assert at_rest.nrmse > 1.05 * result.nrmse


def test_the_standard_deviations_are_those_of_repeated_runs():
    errors = []
    for seed in range(20):
        result = camid.identify(rig.recording(200, seed=seed), believed(initial_state="estimate"))
        deviations = result.simulation.standard_deviations
        stated = np.array([*deviations["numerator"], *deviations["denominator"][1:]])
        found = np.array([*result.simulation.plant.numerator, *result.simulation.plant.denominator[1:]])
        errors.append((found - TRUTH[[0, 2, 3]]) / stated)
    scatter = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all((scatter > 0.6) & (scatter < 1.5))  # χ² with 20 degrees of freedom


@pytest.mark.parametrize("method", ["srivc", "output-error"])
def test_methods(method):
    assert_recovered(camid.identify(rig.recording(), believed(), method=method))


def test_the_wrong_chain_is_found_wrong():
    """The check of the checks: what recovers the coefficients above does not do so with a wrong declaration."""
    result = camid.identify(rig.recording(600, exposure=0.4, latency=1.3), believed())
    with pytest.raises(AssertionError):
        assert_recovered(result)


def test_several_recordings_of_a_rig():
    tables = [rig.recording(200, seed=1), rig.recording(300, seed=5, start=100.0)]
    result = camid.identify(tables, believed())
    assert_recovered(result)
    assert result.rows_fitted == 500


def test_times_need_not_begin_at_zero_nor_be_exact():
    table = rig.recording()
    expected = camid.identify(table, believed()).simulation.plant.denominator
    for time in (table["t"] + 1.7e9, table["t"] - 7.0):
        result = camid.identify(table.assign(t=time), believed())
        np.testing.assert_allclose(result.simulation.plant.denominator, expected, rtol=1e-5)


def test_rounded_times_and_an_exposure_of_a_whole_period(tmp_path):
    """30 frames/s with three decimals: the declared exposure of 1/30 s is not longer than the period."""
    table = pd.DataFrame({"t": np.arange(200) / 30.0, "u": rig.steps(200)})
    content = rig.simulation(sensor={"column": "y", "kind": "camera", "exposure": 1.0 / 30.0})
    exact = camid.simulate(table, content)["simulated"]
    assert np.ptp(exact) > 1.0
    for decimals in (2, 3, 4):
        rounded = table.assign(t=table["t"].map(f"{{:.{decimals}f}}".format))
        rounded.to_csv(tmp_path / "recording.csv", index=False)
        np.testing.assert_allclose(camid.simulate(tmp_path / "recording.csv", content)["simulated"], exact, atol=2e-3)
    longer = rig.simulation(sensor={"column": "y", "kind": "camera", "exposure": 1.001 / 30.0})
    assert "is longer than the period" in refusal(tmp_path / "recording.csv", longer, camid.simulate)


def decay(noise=0.02):
    output = rig.film(np.zeros(200), initial_state=[3.0, 0.2])[3:]
    output = output + noise * np.std(output) * np.random.default_rng(2).standard_normal(197)
    return pd.DataFrame({"t": rig.PERIOD * np.arange(197), "y": output})


def test_free_decay(tmp_path):
    table = decay()
    content = believed(numerator=rig.NUMERATOR, input=None, initial_state="estimate")
    result = camid.identify(table, content)
    assert_recovered(result, free=(False, True, True))
    assert result.simulation.plant.numerator == tuple(rig.NUMERATOR)
    assert result.nrmse < 0.03
    # The numerator was not fitted, but the model may still be fitted to a recording with an input.
    camid.write_simulation(result.simulation, tmp_path / "model.yaml")
    assert camid.load_simulation(tmp_path / "model.yaml").free_numerator.tolist() == [True]
    simulated = camid.simulate(table, tmp_path / "model.yaml")
    assert np.std(simulated["simulated"] - table["y"]) < 0.03 * np.std(table["y"])
    assert "nothing moves" in refusal(table, content | {"initial_state": "zero"})
    assert "no column 'y'" in refusal(table[["t"]], content, camid.simulate)
    assert "does not determine the numerator" in refusal(table, content, structure=(2, 0))


def test_simulate_fits_the_initial_state_to_the_recorded_output():
    table = rig.recording(noise=0.0, before=9, latency=0.5)
    content = rig.simulation(sensor=sensor(latency=0.5), initial_state="estimate")
    simulated = camid.simulate(table, content)["simulated"]
    assert len(simulated) == len(table)
    np.testing.assert_allclose(simulated[2:], table["y"][2:], atol=1e-5)  # two frames saw what was before the recording
    at_rest = camid.simulate(table, content | {"initial_state": "zero"})["simulated"]
    assert np.max(np.abs(at_rest - table["y"])) > 0.3
    assert "no column 'y'" in refusal(table[["t", "u"]], content, camid.simulate)
    assert "fewer than needed for 2 initial states" in refusal(table[:4], content, camid.simulate)


@pytest.mark.parametrize("fixed", [0, 2, 3])
def test_fixed_coefficients_keep_their_value(fixed):
    values = 1.2 * TRUTH
    values[1], values[fixed] = TRUTH[1], TRUTH[fixed]
    free = np.arange(4) != fixed
    # The leading coefficient stands for the units: it is never estimated, whatever the file says of it.
    more = {"free": {"numerator": free[:1].tolist(), "denominator": free[1:].tolist()}}
    result = camid.identify(rig.recording(600), believed(values[:1].tolist(), values[1:].tolist(), plant=more))
    found = assert_recovered(result, free=tuple(free[[0, 2, 3]]))
    assert found[fixed] == pytest.approx(TRUTH[fixed], rel=1e-14)
    assert not np.any(np.array(result.simulation.covariance)[[0, None, 1, 2][fixed]])
    nothing = {"free": {"numerator": [False], "denominator": [True, False, False]}}
    assert "no coefficient is free" in refusal(rig.recording(), believed(plant=nothing))
    assert "no coefficient is free" in refusal(rig.recording(), believed(plant=nothing, initial_state="estimate"))


@pytest.mark.parametrize("lead", [1.0, 7.0, -2.0])
def test_the_leading_coefficient_stays(tmp_path, lead):
    result = camid.identify(rig.recording(), believed([100.0 * lead], [lead, 3.0 * lead, 90.0 * lead]))
    assert result.simulation.plant.denominator[0] == lead
    np.testing.assert_allclose(np.array(result.simulation.plant.denominator) / lead, [1.0, 3.0, 100.0], rtol=0.03)
    camid.write_simulation(result.simulation, tmp_path / "model.yaml")
    model = camid.load_simulation(tmp_path / "model.yaml")
    assert model.standard_deviations == result.simulation.standard_deviations
    assert min(model.standard_deviations["denominator"][1:]) > 0.0


def test_validation_rows_are_not_fitted():
    table = rig.recording(400)
    spoilt = table.copy()
    rows = (spoilt["t"] >= 10.0) & (spoilt["t"] <= 15.0)
    spoilt.loc[rows, "y"] += 5.0
    content = believed(validation={"start": 10.0, "end": 15.0})
    clean, result = (camid.identify(one, content) for one in (table, spoilt))
    assert result.rows_fitted == 299
    np.testing.assert_allclose(result.simulation.plant.denominator, clean.simulation.plant.denominator, rtol=1e-6)
    assert clean.nrmse_validation == pytest.approx(0.1, rel=0.3)
    assert result.nrmse_validation > 2.0
    outside = believed(validation={"start": 20.0, "end": 40.0})
    assert "no row of the recording lies between 20 s and 40 s" in (message := refusal(table, outside))
    assert "from 0 s to 19.95 s" in message
    everything = believed(validation={"start": -1.0, "end": 40.0})
    assert "leave no row to fit" in refusal(table, everything)


def test_too_little_to_identify_from():
    table = rig.recording(40)
    assert "3 samples are fewer than needed for 3 parameters" in refusal(table[:3], believed())
    assert "4 samples are fewer than needed for 5 par" in refusal(table[:5], believed(initial_state="estimate"))
    assert "column 'y' is constant" in refusal(table.assign(y=1.0), believed())
    several = [table, table.assign(u=0.0)]
    assert "column 'u' is zero throughout; for a free decay among others" in refusal(several, believed())
    assert "no recording" in refusal([], believed())
    assert "the plant has no dynamics" in refusal(table, believed([1.0], [1.0]))
    assert "order 2 3 is improper" in refusal(table, believed(), structure=(2, 3))
    assert "method 'magic' is not known" in refusal(table, believed(), method="magic")


@pytest.mark.parametrize("state", ["zero", "estimate"])
def test_a_plant_without_dynamics_is_a_gain(state):
    table = pd.DataFrame({"t": rig.PERIOD * np.arange(20), "u": rig.steps(20), "y": 0.0})
    content = rig.simulation(plant=rig.plant([3.0], [1.5]), sensor=sensor(0.0), initial_state=state)
    np.testing.assert_allclose(camid.simulate(table, content)["simulated"], 2.0 * table["u"], rtol=1e-12)


def test_numbers_that_overflow_are_not_written():
    table = pd.DataFrame({"t": rig.PERIOD * np.arange(20), "u": np.full(20, 1e60)})
    content = rig.simulation(plant=rig.plant([1e300], [1.0, 1.0]))
    assert "exceeds every floating-point number" in refusal(table, content, camid.simulate)


def test_another_offset_than_declared_is_warned_of_and_noise_is_not():
    table = rig.recording(noise=0.05)
    known = believed(sensor=sensor() | {"offset": 0.0})
    assert camid.identify(table, known).warnings() == []
    shifted = table.assign(y=table["y"] + 0.3)
    (sentence,) = camid.identify(shifted, known).warnings()
    assert "offset" in sentence
    assert camid.identify(shifted, believed()).warnings() == []


def test_several_moving_recordings_with_a_known_delay_and_a_known_coefficient():
    """All at once: each recording starts in motion of its own, the delay and the damping are known."""
    tables = [rig.recording(300, seed=s, before=9 + s, latency=1.3, start=10.0 * s) for s in (1, 5, 9)]
    content = believed(
        (200.0,),
        (2.0, 6.0, 260.0),
        plant={"free": {"numerator": [True], "denominator": [False, False, True]}},
        sensor=sensor(latency=1.3),
        initial_state="estimate",
    )
    result = camid.identify(tables, content)
    assert_recovered(result, free=(True, False, True))
    assert result.simulation.plant.denominator[1] == pytest.approx(6.0, rel=1e-12)
    assert result.rows_fitted == 3 * 300 - 3 * 3  # frames that saw what was before the recordings are left out
    assert result.warnings() == []
    assert result.nrmse == pytest.approx(0.1, rel=0.1)
    alone = camid.identify(tables[:1], content).simulation.standard_deviations["denominator"][2]
    assert result.simulation.standard_deviations["denominator"][2] < 0.8 * alone
    # The delay counts: without it the plant is another one, and the residual says so.
    assert camid.identify(tables, content | {"sensor": sensor()}).residual_analysis.contradicts


def test_a_right_declaration_is_not_warned_of():
    result = camid.identify(rig.recording(), believed())
    assert result.alternatives == []
    assert result.residual_analysis.whiteness_p > 1e-3
    assert result.residual_analysis.independence_p > 1e-3
    summary = result.to_mapping()["residual_analysis"]
    assert summary["lags"] == 25
    assert summary["alternatives"] == []
    assert result.residual_analysis.summary().startswith("residual: white (p = ")


@pytest.mark.parametrize(
    ("truth", "changes", "said", "right"),
    [
        ({"hold": "foh"}, {}, "hold foh", {"hold": "foh"}),
        ({"exposure": 0.4}, {}, "an exposure of ", {"exposure": 0.4 * rig.PERIOD}),
        ({"exposure": 0.0}, {}, "an instant sensor", {"sensor": "instant"}),
        ({}, {"sensor": sensor(0.0)}, "a camera with an exposure of 50 ms", {"sensor": "camera"}),
        ({"latency": 0.6}, {}, "a latency of ", {"latency": 0.6 * rig.PERIOD}),
        ({}, {"sensor": sensor(latency=0.6)}, "a latency of 0 ms", {"latency": 0.0}),
        (
            {"hold": "foh", "exposure": 0.0},
            {},
            "hold foh and an instant sensor",
            {"hold": "foh", "sensor": "instant"},
        ),
    ],
)
def test_a_wrong_declaration_is_named(truth, changes, said, right):
    result = camid.identify(rig.recording(600, noise=0.03, **truth), believed(**changes))
    (sentence,) = result.warnings()
    assert sentence.startswith("the residual depends on the input (p ")
    assert said in sentence
    assert "contradict" in sentence
    mapping = result.to_mapping()["residual_analysis"]
    assert mapping["independence_p"] < 1e-3
    (named,) = [a for a in mapping["alternatives"] if a["changed"] == list(right)]
    assert named["passes"]
    for key, value in right.items():
        assert named[key] == (value if isinstance(value, str) else pytest.approx(value, rel=0.05))


def test_what_no_declaration_explains_is_said():
    result = camid.identify(rig.recording(600, noise=0.03), believed(), structure=(1, 0))
    (sentence,) = result.warnings()
    assert "no hold, exposure or latency explains it" in sentence
    assert "order too low" in sentence


def systems():
    import control

    transfer_function = control.tf([200.0], [2.0, 9.0, 260.0])
    return {"transfer function": transfer_function, "state space": control.ss(transfer_function)}


@pytest.mark.parametrize("kind", ["transfer function", "state space"])
@pytest.mark.parametrize("nested", [False, True])
def test_python_control_goes_in_and_comes_out(kind, nested):
    import control

    system = systems()[kind]
    content = rig.simulation(plant={"transfer_function": system} if nested else system)
    table = rig.recording()
    result = camid.identify(table, content)
    expected = camid.identify(table, believed())
    found, monic = result.simulation.plant.monic, expected.simulation.plant.monic
    np.testing.assert_allclose(found.denominator, monic.denominator, rtol=1e-6)
    np.testing.assert_allclose(found.numerator, monic.numerator, rtol=1e-6)
    returned = result.to_control()
    assert isinstance(returned, control.TransferFunction)
    np.testing.assert_allclose(returned.den[0][0], result.simulation.plant.denominator)
    simulated = camid.simulate(table, content)["simulated"]
    np.testing.assert_allclose(simulated, camid.simulate(table, believed())["simulated"], rtol=1e-6, atol=1e-9)


def test_python_control_systems_that_are_no_plant_are_refused():
    import control

    table = rig.recording()
    refused = {
        "discrete time": control.tf([1.0], [1.0, -0.5], rig.PERIOD),
        "one pair": control.ss([[-1.0]], [[1.0, 2.0]], [[1.0]], [[0.0, 0.0]]),
        "is not a plant": control.frd([1.0, 2.0], [1.0, 2.0]),
        "improper": control.tf([1.0, 0.0, 0.0], [1.0, 1.0]),
        "unstable": control.tf([1.0], [1.0, -1.0]),
    }
    for said, system in refused.items():
        for command in (camid.identify, camid.simulate):
            assert said in refusal(table, rig.simulation(plant=system), command)
        assert said in refusal(table, rig.simulation(plant={"transfer_function": system}))
    assert "nothing about input and sensor" in refusal(table, control.tf([1.0], [1.0, 1.0]))
    model = camid.Simulation("t", "u", "y", control.tf([3.0], [1.0, 2.0]))
    assert model.plant.numerator == (3.0,)
    with pytest.raises(InputError, match="discrete time"):
        camid.Simulation("t", "u", "y", control.tf([1.0], [1.0, -0.5], rig.PERIOD))


def test_state_space_leaves_no_coefficients_at_rounding_level():
    import control

    rotation = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    for numerator, denominator in (([2.0], [1.0, 3.0, 0.0, 0.0]), ([1.0, 0.0], [1.0, 2.0, 3.0, 4.0])):
        plain = control.ss(control.tf(numerator, denominator))
        turned = control.ss(rotation @ plain.A @ rotation.T, rotation @ plain.B, plain.C @ rotation.T, plain.D)
        plant = camid.Simulation("t", "u", "y", turned).plant
        np.testing.assert_allclose(plant.numerator, numerator, rtol=1e-9, atol=0.0)
        np.testing.assert_allclose(plant.denominator, denominator, rtol=1e-9, atol=0.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"input": {"column": ["u", "v"], "hold": "zoh"}},
        {"input": [{"column": "u", "hold": "zoh"}, {"column": "v", "hold": "zoh"}]},
        {"sensor": {"column": ["y", "z"], "kind": "camera"}},
    ],
)
def test_several_inputs_or_outputs_are_refused(tmp_path, changes):
    content = rig.simulation(**changes)
    for source in (content, rig.write_yaml(content, tmp_path / "S.yaml")):
        message = refusal(rig.recording(), source)
        assert "camid identifies one input and one output" in message
        assert "name one column" in message


def test_select_order():
    from camid.commands.order import select_order

    told = []
    result = select_order(rig.recording(), believed(), largest=2, progress=told.append)
    assert (result.poles, result.zeros) == (2, 0)
    assert len(result.table) == 3
    assert told[-1] == "order 2 1 (3 of 3)"
    assert "at least one pole" in refusal(rig.recording(), believed(), select_order, largest=0)
    free_decay = believed(numerator=rig.NUMERATOR, input=None, initial_state="estimate")
    assert "does not determine the zeros" in refusal(decay(), free_decay, select_order)
    assert "no order can be estimated" in refusal(rig.recording(3), believed(), select_order)
