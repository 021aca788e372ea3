"""Pictures as they are drawn: names, units, bands, shades, and lines that grey print tells apart."""

from itertools import pairwise

import numpy as np
import pytest

import camid
from camid import plotting
from camid.drawing.lines import COLOURS, DASHES, line_of, short
from tests.support import linear_rig as rig


@pytest.fixture(scope="module")
def recording():
    return rig.recording(count=400)


@pytest.fixture(scope="module")
def result(recording):
    return camid.identify(recording, rig.simulation())


def texts(figure):
    from matplotlib.text import Text

    return [t.get_text() for t in figure.findobj(Text) if t.get_text()]


def luminance(colour):
    from matplotlib.colors import to_rgb

    return float(np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722)))


def test_lines_differ_in_dash_as_well_as_in_colour():
    assert len(set(map(str, DASHES))) == len(COLOURS) == len(set(COLOURS)) == 6
    assert line_of(0) != line_of(1)
    # Neighbours are also apart in grey, where colour and dash are all there is.
    assert all(abs(luminance(a) - luminance(b)) > 0.02 for a, b in pairwise(COLOURS))


def test_axes_name_quantities_and_units(result):
    axes = result.bode(recording=True).figure().axes
    assert axes[0].get_ylabel() == "magnitude, dB of y/u"
    assert axes[1].get_ylabel() == "phase, °"
    assert axes[1].get_xlabel() == "angular frequency, rad/s"
    assert "frequency, Hz" in texts(axes[0].figure)
    assert any("plant alone; bands of 95 %" in text for text in texts(axes[0].figure))
    compared = result.compare().figure().axes
    assert [a.get_ylabel() for a in compared] == ["y", "error, y"]
    assert compared[1].get_xlabel() == "time, s"
    assert result.step().figure().axes[0].get_xlabel() == "time, s"
    assert result.poles().figure().axes[0].get_xlabel() == "real part, rad/s"
    assert "lag in periods of 50\u00a0ms" in result.residuals().figure().axes[1].get_xlabel()


def test_no_tick_shows_the_markup_of_mathematics(result):
    for view in (result.bode(), result.compare(), result.step(), result.poles(), result.residuals()):
        figure = view.figure()
        with plotting.look():
            figure.canvas.draw()
        assert not [text for text in texts(figure) if "mathdefault" in text or "$" in text]


def test_a_column_may_have_any_name(recording):
    for name in ("$x^{", "y" * 200, "two\nlines", "\u202e"):
        table = recording.rename(columns={"y": name})
        content = rig.simulation(sensor={"column": name, "kind": "camera"})
        view = camid.compare(table, content)
        assert len(plotting.rendered(view.figure(), "png")) > 5000


def test_the_held_out_part_is_shaded(result):
    axes = result.compare(held_out=(10.0, 15.0)).figure().axes[0]
    (shade,) = [p for p in axes.patches if p.get_label() == "held out"]
    box = shade.get_extents().transformed(axes.transData.inverted())
    assert (box.x0, box.x1) == pytest.approx((10.0, 15.0), abs=1e-6)
    plain = result.compare().figure().axes[0]
    assert not [p for p in plain.patches if p.get_label() == "held out"]


def test_the_legend_states_the_fit(result):
    view = result.compare(held_out=(10.0, 15.0))
    row = view.fits.iloc[0]
    expected = f"identified: {row['fit']:.2f}\u00a0%, held out {row['fit_held_out']:.2f}\u00a0%"
    assert expected in texts(view.figure())


def test_bands_are_drawn_where_there_is_a_covariance(result):
    def bands(view):
        return [len(axes.collections) for axes in view.figure().axes]

    assert bands(result.step()) == [1]
    assert bands(camid.step(rig.simulation())) == [0]
    assert bands(result.bode())[:2] == [1, 1]
    assert bands(camid.bode(rig.simulation()))[:2] == [0, 0]


def test_a_simulation_that_runs_away_does_not_hide_the_recording(recording):
    runaway = rig.simulation(plant=rig.plant([3e5], [2.0, 0.0, 200.0]))
    axes = camid.compare(recording, runaway, rig.simulation()).figure().axes[0]
    low, high = axes.get_ylim()
    assert high - low < 4.0 * np.ptp(recording["y"])


def test_correlations_outside_of_their_bounds_are_marked(recording):
    wrong = camid.residuals(recording, rig.simulation(plant=rig.plant([130.0], [1.0, 3.0, 90.0])))
    axes = wrong.figure().axes[0]
    (marked,) = [line for line in axes.lines if line.get_label() == "outside"]
    table = wrong.numbers.query("lag > 0").dropna(subset=["autocorrelation"])
    outside = table["autocorrelation"].abs() > table["bound_autocorrelation"]
    assert len(marked.get_xdata()) == outside.sum() > 5


def test_a_small_ellipse_is_enlarged(result):
    figure = result.poles().figure()
    assert len(figure.axes) == 2
    assert "enlarged" in figure.axes[1].get_title()
    low, high = figure.axes[1].get_xlim()
    edge = result.poles().roots[-1].ellipse()
    assert low < np.min(edge.real) < np.max(edge.real) < high
    assert np.ptp(edge.real) > 0.2 * (high - low)


def test_long_names_are_cut_in_the_middle():
    assert short("a" * 20) == "a" * 20
    assert len(short("a" * 200)) <= 34
    assert short("x" * 100 + ".yaml").endswith(".yaml")
    assert "\n" not in short("a\nb")
