"""What a simulation says of a recording's file: units, contradictions, and that it is written back."""

import numpy as np
import pytest

import camid
from camid.simulation.file import load_simulation
from tests.identification.test_from_recordings import believed, load, refusal, table


@pytest.mark.parametrize(
    ("unit", "factor", "base"),
    [
        *[
            ("mm", 1e-3, 0),
            ("deg", np.pi / 180, 0),
            ("mV", 1e-3, 0),
            ("kN", 1e3, 0),
            ("m/s^2", 1, 0),
            ("rpm", np.pi / 30, 0),
        ],
        *[("px", 1, 0), ("pixel", 1, 0), ("N*m", 1, 0), ("°/s", np.pi / 180, 0), ("µm", 1e-6, 0), ("%", 0.01, 0)],
        ("degC", 1, 273.15),
    ],
)
def test_everything_behind_loading_is_in_si(unit, factor, base):
    recorded = table()
    (found,) = load(recorded, sensor={"unit": unit}, input={"unit": "mV", "scale": -35.15, "offset": 2.0})
    np.testing.assert_allclose(found.columns["y"], factor * recorded["y"] + base, rtol=1e-12)
    np.testing.assert_allclose(found.columns["u"], -35.15e-3 * recorded["u"] + 2.0, rtol=1e-12)


def test_milliseconds():
    recorded = table()
    expected = camid.simulate(recorded, believed())
    shifted = camid.simulate(recorded.assign(t=1e3 * recorded["t"]), believed(time={"unit": "ms"}))
    np.testing.assert_allclose(shifted, expected, rtol=1e-9, atol=1e-12)
    (slow,) = load(recorded.assign(t=1e3 * recorded["t"]))
    assert "the period is 50 s: if the times are milliseconds, say unit: ms under time" in slow.warnings[0]


def test_simulate_writes_si():
    recorded = table()
    content = believed(sensor={"unit": "mm", "offset": 0.5}, input={"unit": "V", "scale": 2.0})
    result = camid.simulate(recorded, content)
    np.testing.assert_allclose(result["y"], 1e-3 * recorded["y"])
    twice = camid.simulate(recorded.assign(u=2.0 * recorded["u"]), believed())
    np.testing.assert_allclose(result["simulated"], twice["simulated"] + 0.5, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"sensor": {"unit": "milimeter"}},
            "simulation, sensor.unit: unknown unit 'milimeter'; did you mean 'millimeter'?",
        ),
        ({"sensor": {"unit": "inhc"}}, "unknown unit 'inhc'; did you mean 'inch'?"),
        ({"sensor": {"unit": "3 mm"}}, "'3 mm' is not a unit"),
        ({"time": {"unit": "mm"}}, "time.unit: 'mm' is not a unit of time"),
        ({"time": {"unit": "Hz"}}, "'Hz' is not a unit of time"),
        ({"time": {"period": 0.1}}, "simulation, time: period and column are both given; keep one of them"),
        ({"sensor": {"scale": 0.0}}, "sensor.scale: a scale of zero makes every number zero"),
        ({"input": {"scale": 1e-320, "unit": "nV"}}, "simulation, input: scale = 9.99989e-321 makes every number zero"),
        ({"sensor": {"scale": 1e308, "unit": "km"}}, "makes numbers that are not finite"),
        ({"recording": {"columns": ["t"]}}, "recording.columns: columns are named for a file without a header line"),
        ({"recording": {"header": False}}, "recording.header: without a header line the columns have no names"),
        ({"recording": {"header": False, "columns": ["t", "t"]}}, "recording.columns: a name appears twice"),
        ({"recording": {"start": 3, "end": 2}}, "recording: start is not before end"),
        ({"recording": {"begin": 3}}, "unknown key 'begin'; did you mean"),
        ({"recording": {"separator": ", "}}, "recording.separator"),
        ({"recording": {"gaps": "fill"}}, "recording.gaps: 'fill' is not known here; it must be refuse or hold"),
        ({"recording": {"missing": True}}, "recording.missing: 'True' is not known here"),
        ({"recording": {"leave_out": -1}}, "recording.leave_out: -1 is less than 0"),
        (
            {"recording": {"experiment": "run"}},
            "recording.experiment: 'run' is not a mapping of keys to values; expected: {col",
        ),
        ({"recording": {"start": 9.0}}, "recording: no row lies between 9 s and the end"),
        ({"recording": {"end": 0.07}}, "recording: 2 rows"),
        ({"recording": {"experiment": {"column": "run"}}}, "no column 'run'"),
        ({"recording": {"experiment": {"column": "u"}}}, "input and experiment are the same column 'u'"),
    ],
)
def test_what_a_simulation_may_not_say_of_a_recording(changes, said):
    assert said in refusal(table(), **changes)


def test_what_is_said_of_a_recording_is_written_back(tmp_path):
    content = believed(
        recording={
            "separator": ";",
            "decimal": ",",
            "header": False,
            "columns": ["t", "u", "y", "run"],
            "group": "a/b",
            "experiment": {"column": "run"},
            "start": -1.5,
            "end": 60,
            "leave_out": 0.2,
            "gaps": "hold",
            "missing": "leave-out",
        },
        time={"unit": "ms"},
        input={"unit": "V", "scale": 35.15, "offset": -1e-9},
        sensor={"unit": "mm", "scale": -2.0},
    )
    for variant in (content, content | {"time": {"period": 1e-3}}, believed()):
        first = load_simulation(variant)
        camid.write_simulation(first, tmp_path / "model.yaml")
        second = load_simulation(tmp_path / "model.yaml")
        assert second.reading == first.reading
        written = second.to_mapping()
        assert {k: written.get(k) for k in ("recording", "time", "input")} == {
            k: variant.get(k) for k in ("recording", "time", "input")
        }
        assert variant["sensor"].items() <= written["sensor"].items()
