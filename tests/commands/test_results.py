"""Results draw themselves, and show themselves in a few lines and in a notebook."""

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest

import camid
from camid.identification.identification import Identification
from tests.support import linear_rig as rig


@pytest.fixture(scope="module")
def recording():
    return rig.recording(count=400)


@pytest.fixture(scope="module")
def result(recording):
    return camid.identify(recording, rig.simulation())


@pytest.fixture(scope="module")
def diagnosis(recording):
    return camid.diagnose(recording, rig.simulation(plant=rig.plant([290.0], [2.0, 6.0, 200.0])), time_limit=1.0)


def test_methods_return_what_the_functions_do(result, recording):
    assert isinstance(result, Identification)
    pd.testing.assert_frame_equal(result.compare().fits, camid.compare(recording, result).fits)
    pd.testing.assert_frame_equal(result.bode().numbers, camid.bode(result).numbers)
    pd.testing.assert_frame_equal(result.poles().numbers, camid.poles(result).numbers)
    pd.testing.assert_frame_equal(result.step(duration=1.0).numbers, camid.step(result, duration=1.0).numbers)
    expected = result.residual_analysis.correlations(result.period)
    pd.testing.assert_frame_equal(result.residuals().numbers, expected, rtol=1e-9)
    assert result.bode(recording=True).empirical is not None
    assert result.bode(recording=False).empirical is None
    other = rig.recording(count=300, seed=8)
    assert result.compare(recording=other).fits["fit"][0] != result.compare().fits["fit"][0]
    beside = result.compare(rig.simulation(), held_out=(10.0, 15.0), zoom=(10.0, 12.0))
    assert beside.models == ("identified", "model 2")
    assert beside.has_held_out


def test_of_several_recordings_the_residual_is_that_of_all():
    tables = [rig.recording(count=200, seed=s) for s in (1, 4)]
    found = camid.identify(tables, rig.simulation())
    assert found.residuals().numbers["lag"].max() == 25
    assert found.compare().signals[0].time[-1] == pytest.approx(tables[0]["t"].iloc[-1])


def test_a_diagnosis_stands_beside_what_was_believed(diagnosis):
    found = diagnosis.compare()
    assert found.models == ("model 1", "improved") or found.models[1] == "improved"
    assert found.has_held_out  # which camid chose
    table = found.fits.set_index("model")["fit_held_out"]
    assert table["improved"] == pytest.approx(100.0 * (1.0 - diagnosis.fit.improved), abs=0.5)
    assert len(diagnosis.bode().curves) == 2
    assert {r.model for r in diagnosis.poles().roots} == set(found.models)
    assert len(diagnosis.step().curves) == 2
    assert diagnosis.residuals().analysis.whiteness_p is not None


def views(result):
    return [result, result.compare(), result.bode(), result.poles(), result.step(), result.residuals()]


def test_a_repr_has_at_most_ten_lines(result, diagnosis):
    order = camid.identify(rig.recording(count=400), rig.simulation(), structure=(4, 3))
    for shown in [*views(result), diagnosis, order]:
        text = repr(shown)
        assert text.count("\n") < 10
        assert len(text) < 1200
        assert text.startswith("<")
    assert "natural frequency" in repr(result)
    assert "…" in repr(order)
    assert diagnosis.verdict in repr(diagnosis)


@pytest.mark.slow
def test_a_notebook_shows_a_table_and_a_picture_whose_text_is_escaped(result, diagnosis):
    for shown in [*views(result), diagnosis]:
        html = shown._repr_html_()
        assert "<table" in html
        assert html.startswith("<div>")
    assert result.plot()._repr_png_().startswith(b"\x89PNG")
    assert "data:image/png;base64," in result.bode()._repr_html_()
    table = rig.recording(count=100).rename(columns={"y": "<script>"})
    content = rig.simulation(sensor={"column": "<script>", "kind": "camera"})
    found = camid.identify(table, content)
    assert "<script>" not in found.residuals()._repr_html_() + found._repr_html_() + found.step()._repr_html_()


def test_figures_leave_no_trace_in_the_settings_of_matplotlib(result):
    import matplotlib.pyplot as plt

    before, shown = dict(mpl.rcParams), plt.get_fignums()
    figure = result.plot()
    result.step().figure()
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == shown
    assert len(figure.axes) == 2


def test_what_is_saved_is_the_same_at_every_run(result, tmp_path):
    for suffix in ("png", "svg", "pdf"):
        written = [result.step().save(tmp_path / f"{name}.{suffix}") for name in ("one", "two")]
        assert written[0] == [tmp_path / f"one.{suffix}", tmp_path / "one.csv"]
        first, second = ((tmp_path / f"{name}.{suffix}").read_bytes() for name in ("one", "two"))
        assert first == second
        assert len(first) > 5000
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()
    table = pd.read_csv(tmp_path / "one.csv")
    np.testing.assert_allclose(table["output"], result.step().numbers["output"], rtol=1e-12)
