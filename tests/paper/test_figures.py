"""Figures: bytes, tables, labels. What they look like is for eyes."""

import numpy as np
import pandas as pd
import pytest

from camid import plotting as style
from camid.paper import block_diagrams
from camid.paper.cases import with_gain
from camid.paper.fig6_camera_models import drawing as camera_models
from camid.paper.fig6_camera_models.runs import camera_model_responses
from camid.paper.fig7_sampling_period import drawing as sampling_period
from camid.paper.fig8_neglected_mode import drawing as neglected_mode


def draw_block_diagram():
    return block_diagrams.draw_first_version()


def draw_bode():
    return camera_models.draw(
        camera_model_responses({"period": 0.02, "lowest": 0.1, "highest": 25.0, "points": 60}), 0.02
    )


def estimates_of_fig7():
    cases = [("camera", -1), ("zoh", -1), ("camera-noise", 0), ("camera-noise", 1)]
    return pd.DataFrame(
        {
            "period": period,
            "case": case,
            "sample": sample,
            "method": method,
            "converged": method == "srivc" or period < 0.2,
            **{f"error_{p}": 3e-14 if case == "camera" else 5.0 for p in ("b0", "a1", "a0")},
            **{f"bound_{p}": 2.0 for p in ("b0", "a1", "a0")},
        }
        for period in (0.05, 0.1, 0.3)
        for case, sample in cases
        for method in ("srivc", "plain-srivc")
    )


def draw_fig7():
    return sampling_period.draw(estimates_of_fig7(), 10.0, {"camera": "camera", "held": "zoh", "noise": "camera-noise"})


def draw_fig8():
    rows = [
        {"omega_1": omega, "period_times_omega_1": 0.02 * omega, "case": case, "converged": True}
        | {f"error_{p}": 10.0 / omega for p in ("b0", "a1", "a0")}
        for case in neglected_mode.LOOKS
        for omega in (30.0, 100.0, 300.0)
    ]
    return neglected_mode.draw(pd.DataFrame(rows), 0.02)


@pytest.mark.parametrize("draw", [draw_block_diagram, draw_bode, draw_fig7, draw_fig8])
def test_all_axes_are_labelled(draw):
    figure, _ = draw()
    for axes in figure.axes:
        shared = axes.get_shared_x_axes().get_siblings(axes)
        assert not axes.axison or axes.get_ylabel()
        assert not axes.axison or any(other.get_xlabel() for other in shared)


@pytest.mark.parametrize("draw", [draw_block_diagram, draw_bode])
def test_two_drawings_have_the_same_bytes(draw, tmp_path):
    contents = []
    for run in ("first", "second"):
        paths = [tmp_path / f"{run}.{kind}" for kind in ("png", "csv", "pdf")]
        style.save(*draw(), *paths)
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]
    assert len(contents[0][1].splitlines()) > 2


def marks(axes):
    """Symbol and place of every triangle on the frame."""
    lines = [line for line in axes.lines if line.get_label() == "_outside"]
    return [(line.get_marker(), x, y) for line in lines for x, y in zip(*line.get_data(), strict=True)]


@pytest.mark.parametrize(
    ("scale", "ordinate", "limits", "joined", "expected"),
    [
        ("linear", [0.0, 4.0, 0.0, -4.0], (-2.0, 2.0), True, [("^", 0.5, 2.0), ("^", 1.5, 2.0), ("v", 2.5, -2.0)]),
        ("linear", [0.0, 4.0, 0.0, -4.0], (-2.0, 2.0), False, [("^", 1.0, 2.0), ("v", 3.0, -2.0)]),
        ("linear", [0.0, 4.0, np.nan, -4.0], (-2.0, 2.0), True, [("^", 0.5, 2.0)]),
        ("linear", [0.0, 1.0, 0.0, -1.0], (-2.0, 2.0), True, []),
        # Half way between 1 and 0.01 lies 0.1, on a logarithmic axis.
        ("log", [1.0, 0.01, 0.01, 0.01], (0.1, 10.0), True, [("v", 0.5, 0.1)]),
    ],
)
def test_where_a_curve_leaves_an_axis_is_marked(scale, ordinate, limits, joined, expected):
    style.apply()
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots()
    axes.set(yscale=scale, ylim=limits)
    assert style.mark_outside(axes, [0.0, 1.0, 2.0, 3.0], ordinate, "black", joined) == bool(expected)
    found = marks(axes)
    assert [symbol for symbol, *_ in found] == [symbol for symbol, *_ in expected]
    np.testing.assert_allclose([place for _, *place in found], [place for _, *place in expected])
    plt.close(figure)


def test_figures_show_the_gain_of_the_paper():
    """(1 + 5 %)/(1 + 5 %) is one; an error of b0 alone is that of K."""
    for figure, table in (draw_fig7(), draw_fig8()):
        assert table["error_K"].abs().max() < 1e-9
        assert figure.axes[0].get_ylabel() == "error in $K = b_0/a_0$ (%)"
    alone = with_gain(pd.DataFrame({"error_b0": [5.0], "error_a0": [0.0]}))
    assert alone["error_K"].tolist() == pytest.approx([5.0])


def test_noise_samples_of_fig7_are_told_apart_and_all_is_named():
    figure, _ = draw_fig7()
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    for words in ("noise sample 1", "noise sample 2", "safeguarded SRIVC", "where it converges", "leaves the axis"):
        assert sum(words in text for text in texts) == 1, words
    looks = {(h.get_color(), h.get_linestyle()) for h, t in zip(legend.get_lines(), texts, strict=False)}
    assert len(looks) >= 4


def test_gaps_where_plain_srivc_did_not_converge_and_rounding_is_zero():
    _, table = draw_fig7()
    failed = table[(table["method"] == "plain-srivc") & (table["period"] > 0.2)]
    assert failed["error_b0"].isna().all()
    clean = table[(table["case"] == "camera") & (table["method"] == "srivc")]
    assert (clean["error_b0"] == 0.0).all()


def test_colours_differ_in_grey():
    from matplotlib.colors import to_rgb

    luminance = [np.dot(to_rgb(c), (0.2126, 0.7152, 0.0722)) for c in (style.BLUE, style.VERMILION, style.BLACK)]
    assert np.min(np.diff(np.sort(luminance))) > 0.02


def test_rounding_keeps_nine_digits():
    table = style.rounded(pd.DataFrame({"value": [1.0 / 3.0, 12345678.912], "name": ["a", "b"]}))
    assert list(table["value"]) == [0.333333333, 12345678.9]
