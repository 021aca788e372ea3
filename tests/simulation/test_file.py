"""The simulation contract: what the YAML file may say, how it is refused, and that simulate computes what it says."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import tf2ss

import camid
from camid.errors import InputError
from camid.simulation.file import load_simulation, write_simulation
from tests.support import linear_rig as rig

GOOD = """\
schema: 1
time: {column: t}
input:
  column: u
  hold: zoh
plant:
  transfer_function:
    numerator: [100.0]
    denominator: [1.0, 2.0, 100.0]
sensor:
  column: y
  kind: camera
  exposure: 0.02
  latency: 0.0
initial_state: zero
validation: {start: 20.0, end: 40.0}
effects: []
"""


def refusal(source):
    with pytest.raises(InputError) as caught:
        load_simulation(source)
    message = str(caught.value)
    assert "\n" not in message
    return message


def edited(folder, *changes):
    text = GOOD
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in text
        text = text.replace(old, new)
    path = folder / "simulation.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_the_file_says_is_what_is_loaded(tmp_path):
    loaded = load_simulation(edited(tmp_path))
    assert (loaded.time_column, loaded.input_column, loaded.output_column) == ("t", "u", "y")
    assert (loaded.hold, loaded.sensor, loaded.exposure, loaded.latency) == ("zoh", "camera", 0.02, 0.0)
    assert (loaded.initial_state, loaded.validation) == ("zero", (20.0, 40.0))
    assert (loaded.plant.numerator, loaded.plant.denominator) == ((100.0,), (1.0, 2.0, 100.0))


def test_defaults():
    loaded = load_simulation(rig.simulation())
    assert (loaded.exposure, loaded.latency, loaded.initial_state, loaded.validation) == (None, 0.0, "zero", None)
    assert loaded.acquisition(0.04).exposure == 0.04


def test_a_file_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "simulation.yaml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert load_simulation(path).exposure == 0.02


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("validation:", "validaton:", "line 16, validaton: unknown key 'validaton'; did you mean 'validation'?"),
        ("time: {column", "time: {colum", "line 2, time.colum: unknown key 'colum'; did you mean 'column'?"),
        ("  hold", "  holt", "line 5, input.holt: unknown key 'holt'; did you mean 'hold'?"),
        ("  transfer_f", "  transferf", "line 7, plant.transferfunction: unknown key"),
        ("    numerator", "    numerater", "line 8, plant.transfer_function.numerater: unknown key"),
        (
            "  exposure",
            "  exposition",
            "line 13, sensor.exposition: unknown key 'exposition'; did you mean 'exposure'?",
        ),
        ("{start", "{begin: 1, start", "line 16, validation.begin: unknown key"),
        ("[]", "[{id: x, parameters: {}, std: 1}]", "line 17, effects.0.std: unknown key 'std'"),
        ("sensor:", "1: 2\nsensor:", "line 10, 1: unknown key '1'"),
    ],
)
def test_unknown_keys_are_named_with_line_and_nearest_match(tmp_path, old, new, said):
    assert said in refusal(edited(tmp_path, old, new))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("schema: 1\n", "", "the key 'schema' is missing"),
        ("time: {column: t}", "time: {}", "line 2, time: the key 'column' is missing"),
        ("  hold: zoh\n", "", "line 3, input: the key 'hold' is missing"),
        (
            "    denominator: [1.0, 2.0, 100.0]\n",
            "",
            "line 7, plant.transfer_function: the key 'denominator' is missing",
        ),
        ("  kind: camera\n", "", "line 10, sensor: the key 'kind' is missing"),
        (", end: 40.0", "", "line 16, validation: the key 'end' is missing"),
        ("schema: 1", "schema: 2", "line 1, schema: version 2 is not known; this camid reads schema: 1"),
        ("schema: 1", 'schema: "1"', "line 1, schema: version '1' is not known"),
        ("schema: 1", "schema: true", "line 1, schema: version True is not known"),
        (
            "hold: zoh",
            "hold: spline",
            "line 5, input.hold: 'spline' is not known here; it must be zoh, foh or band-limited",
        ),
        ("kind: camera", "kind: webcam", "line 12, sensor.kind: 'webcam' is not known here"),
        ("initial_state: zero", "initial_state: 0", "line 15, initial_state: '0' is not known here"),
        (
            "time: {column: t}",
            "time: t",
            "line 2, time: 't' is not a mapping of keys to values; expected: The time",
        ),
        (
            "time: {column: t}",
            "time: {column: 3}",
            "line 2, time.column: 3 is not text; expected: Name of the time column",
        ),
        (
            "[100.0]",
            "100.0",
            "line 8, plant.transfer_function.numerator: 100.0 is not a list; expected: a list in brackets, such as "
            "[1.0, 2.0]: Coefficients of B",
        ),
        ("[100.0]", "[]", "line 8, plant.transfer_function.numerator: [] is empty"),
        (
            "column: y",
            "columns: {y: position}",
            "has 1 of at least 2 entries; expected: one column is column: name; columns are two or more",
        ),
        ("[100.0]", '["100"]', "line 8, plant.transfer_function.numerator.0: '100' is not a finite number"),
        ("2.0, 100.0", "yes, 100.0", "line 9, plant.transfer_function.denominator.1: 'yes' is not a finite number"),
        ("2.0, 100.0", "true, 100.0", "line 9, plant.transfer_function.denominator.1: True is not a finite number"),
        ("exposure: 0.02", "exposure: &a true", "line 13, sensor.exposure"),
        ("2.0, 100.0", ".nan, 100.0", "line 9, plant.transfer_function.denominator.1: nan is not a finite number"),
        ("[100.0]", "[.inf]", "inf is not a finite number"),
        ("[100.0]", f"[1{400 * '0'}]", "is not a finite number"),
        (
            "exposure: 0.02",
            "exposure: .nan",
            "line 13, sensor.exposure: nan is not a finite number; expected: τ in",
        ),
        ("exposure: 0.02", "exposure: 0,02", "line 13, sensor.exposure: '0,02' is not a finite number"),
        ("exposure: 0.02", "exposure: null", "line 13, sensor.exposure: None is not a finite number"),
        ("exposure: 0.02", "exposure: 0", "line 13, sensor.exposure: 0 is not greater than 0; expected: τ in"),
        ("exposure: 0.02", "exposure: -0.02", "line 13, sensor.exposure: -0.02 is not greater than 0"),
        ("latency: 0.0", "latency: -0.001", "line 14, sensor.latency: -0.001 is less than 0"),
        ("latency: 0.0", "latency: .inf", "line 14, sensor.latency: inf is not a finite number"),
        ("kind: camera", "kind: instant", "line 13, sensor.exposure: an instant sensor has no exposure"),
        ("start: 20.0", "start: 40.0", "line 16, validation: start is not before end"),
        ("start: 20.0", "start: .nan", "line 16, validation.start: nan is not a finite number"),
        ("2.0, 100.0", "-2.0, 100.0", "line 9, plant.transfer_function.denominator: the transfer function is unstable"),
        ("[100.0]", "[1, 2, 3, 4]", "line 7, plant.transfer_function: the transfer function is improper"),
        ("[100.0]", "[0, 0]", "line 7, plant.transfer_function: the numerator is zero"),
        (
            "[1.0, 2.0, 100.0]",
            "[0.0, 2.0, 100.0]",
            "line 9, plant.transfer_function.denominator: the first coefficient",
        ),
        ("[1.0, 2.0, 100.0]", "[0]", "the first coefficient is zero; remove it"),
        ("[1.0, 2.0, 100.0]", "[1e-307, 2.0, 100.0]", "line 7, plant.transfer_function: the numerator has a coeff"),
        ("effects: []", "effects: [{parameters: {}}]", "line 17, effects.0: the key 'id' is missing"),
        (
            "sensor:\n",
            "  pendulum: {natural_frequency: 3, damping: 0}\nsensor:\n",
            "line 6, plant: the plant is declared twice",
        ),
        ("plant:\n", "plant:\n  free: {numerator: [true]}\n", "plant.free: the key 'denominator' is missing"),
        (
            "plant:\n",
            "plant:\n  covariance: [[1.0, 2.0], [2.0, 1.0]]\n",
            "line 7, plant.covariance: this is not a table of 3",
        ),
        ("plant:\n", "plant:\n  covariance: [[1], [2], [.nan]]\n", "plant.covariance.2.0: nan is not a finite number"),
        (
            "plant:\n",
            "plant:\n  free: {numerator: [true], denominator: [false, true]}\n",
            "line 7, plant.free: 'denominator' does not have the 3 entries",
        ),
        (
            "plant:\n",
            "plant:\n  free: {numerator: [true], denominator: [false, true, true], denominators: [true]}\n",
            "line 7, plant.free.denominators: unknown key 'denominators'; did you mean 'denominator'?",
        ),
        (
            "plant:\n",
            "plant:\n  standard_deviations: {numerator: [-1], denominator: [0, 1, 1]}\n",
            "line 7, plant.standard_deviations.numerator",
        ),
        ("hold: zoh", "hold: zoh\n  hold: foh", 'line 6: not valid YAML: found duplicate key "hold"'),
        ("  column: u", "\tcolumn: u", "line 4: not valid YAML"),
        ("{column: t}", "{column: t", "not valid YAML"),
        ("column: u", "column: 2024-13-45", "not valid YAML: month must be in 1..12"),
        ("sensor:", "---\nsensor:", "not valid YAML"),
        ("column: u", "column: *nowhere", "line 4: not valid YAML: found undefined alias"),
    ],
)
def test_wrong_values_are_named_with_line_and_key(tmp_path, old, new, said):
    message = refusal(edited(tmp_path, old, new))
    assert message.startswith(str(tmp_path / "simulation.yaml"))
    assert said in message


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "not a mapping"),
        (b"# nothing\n", "not a mapping"),
        (b"- schema: 1\n", "not a mapping"),
        (b"just words\n", "not a mapping"),
        (b"\xff\xfe\x00\x01", "not valid YAML"),
        (b"\x00\x01\x02", "not valid YAML"),
        (b"[" * 400, "more than 50 brackets are open"),
        (b"a: &a [*a]\n", "unknown key 'a'"),
        (b"a: !!int word\n", "not valid YAML"),
    ],
)
def test_files_that_are_no_simulations(tmp_path, content, said):
    path = tmp_path / "simulation.yaml"
    path.write_bytes(content)
    assert said in refusal(path)


def test_missing_file_and_folder(tmp_path):
    assert "no such file" in refusal(tmp_path / "none.yaml")
    assert "this is a folder" in refusal(tmp_path)


@pytest.mark.parametrize(
    ("numerator", "hint"), [([0, 6], "remove it; or is 0.6 meant, with a point?"), ([0.0, -2.5], "remove it")]
)
def test_a_numerator_that_begins_with_zero_may_hold_a_decimal_comma(numerator, hint):
    with pytest.raises(InputError) as refused:
        load_simulation(rig.simulation(plant=rig.plant(numerator, [1.0, 2.2, 110.0])))
    assert str(refused.value).endswith(f"transfer_function.numerator: the first coefficient is zero; {hint}")


def test_leading_zeros_of_the_numerator_count_for_nothing():
    more = {
        "free": {"numerator": [False, True], "denominator": [False, True, False]},
        "standard_deviations": {"numerator": [0.0, 3.0], "denominator": [0.0, 4.0, 0.0]},
        "covariance": [[0, 0, 0, 0], [0, 9, 1, 0], [0, 1, 16, 0], [0, 0, 0, 0]],
    }
    loaded = load_simulation(rig.simulation(plant=rig.plant([0, 100], [1, 2, 100], **more)))
    assert loaded.plant.numerator == (100.0,)
    assert loaded.free_numerator.tolist() == [True]
    assert loaded.free_denominator.tolist() == [False, True, False]
    assert loaded.standard_deviations == {"numerator": [3.0], "denominator": [0.0, 4.0, 0.0]}
    assert loaded.covariance == [[9, 1, 0], [1, 16, 0], [0, 0, 0]]


@pytest.mark.parametrize("column", ["y", "yes", "1", "1e3", "null", "a: b", "# c", "", "déjà 'vu'", "two\nlines"])
def test_what_is_written_is_read_back(tmp_path, column):
    content = rig.simulation(
        input=None,
        plant=rig.plant([-1e-30], [-2e20, -1.0, -0.1 - 0.2], covariance=[[1e-9] * 3] * 3),
        sensor={"column": column, "kind": "camera", "exposure": 1e-5, "latency": 1 / 3},
        validation={"start": -1, "end": 1e9},
        initial_state="estimate",
    )
    first = load_simulation(content)
    write_simulation(first, tmp_path / "model.yaml", "two\nlines")
    second = load_simulation(tmp_path / "model.yaml")
    assert second.to_mapping() == first.to_mapping()
    assert second.output_column == column


# -- what simulate computes, against an integrator with error control and quadrature ----------------------------------


def filmed(signal, hold, exposure, latency):
    """Sensor samples by ``solve_ivp`` from sample to sample and Gauss–Legendre quadrature over the exposure."""
    a, b, c, d = tf2ss(rig.NUMERATOR, rig.DENOMINATOR)
    pieces, state = [], np.zeros(2)
    for k in range(len(signal) - 1):
        slope = (signal[k + 1] - signal[k]) / rig.PERIOD if hold == "foh" else 0.0

        def derivative(t, x, k=k, slope=slope):
            return a @ x + b[:, 0] * (signal[k] + slope * (t - k * rig.PERIOD))

        span = (k * rig.PERIOD, (k + 1) * rig.PERIOD)
        solution = solve_ivp(derivative, span, state, "DOP853", rtol=1e-11, atol=1e-13, dense_output=True)
        pieces.append(solution.sol)
        state = solution.y[:, -1]

    def motion(t):
        if t <= 0.0:
            return 0.0
        return float((c @ pieces[min(int(t / rig.PERIOD), len(pieces) - 1)](t))[0])

    assert d[0, 0] == 0.0
    nodes, weights = np.polynomial.legendre.leggauss(8)
    samples = []
    for k in range(len(signal)):
        end = (k - latency) * rig.PERIOD
        if exposure == 0.0:
            samples.append(motion(end))
            continue
        begin = end - exposure * rig.PERIOD
        inside = [j * rig.PERIOD for j in range(-3, len(signal)) if begin < j * rig.PERIOD < end]
        edges = [begin, *inside, end]
        total = 0.0
        for left, right in pairwise(edges):
            points = 0.5 * (left + right) + 0.5 * (right - left) * nodes
            total += 0.5 * (right - left) * sum(w * motion(t) for w, t in zip(weights, points, strict=True))
        samples.append(total / (end - begin))
    return np.array(samples)


@pytest.mark.parametrize("hold", ["zoh", "foh"])
@pytest.mark.parametrize(
    ("exposure", "latency"),
    [(1.0, 0.0), (0.4, 0.0), (0.4, 1.3), (1.0, 1.3), (0.7, 2.0), (0.0, 0.0), (0.0, 0.6), (0.0, 1.0)],
)
def test_simulate_agrees_with_an_integrator(hold, exposure, latency):
    signal = rig.steps(40)
    sensor = {"column": "y", "kind": "camera" if exposure else "instant", "latency": latency * rig.PERIOD}
    if 0.0 < exposure < 1.0:
        sensor["exposure"] = exposure * rig.PERIOD
    table = pd.DataFrame({"t": 3.0 + rig.PERIOD * np.arange(40), "u": signal})
    result = camid.simulate(table, rig.simulation(input={"column": "u", "hold": hold}, sensor=sensor))
    assert list(result.columns) == ["t", "simulated"]
    expected = filmed(signal, hold, exposure, latency)
    assert np.ptp(expected) > 0.5
    np.testing.assert_allclose(result["simulated"], expected, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(result["t"], table["t"])
    # The camera that the reference of the other tests uses agrees, too, and another chain does not.
    np.testing.assert_allclose(rig.film(signal, hold, exposure, latency), expected, rtol=0.0, atol=1e-5)
    assert np.max(np.abs(filmed(signal, hold, exposure, latency + 0.01) - expected)) > 1e-3
