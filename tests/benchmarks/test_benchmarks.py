"""The benchmarks without their peers: what needs only scipy, and what the table says of a peer that is missing."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from benchmarks.peers import PEERS, Peer, from_discrete, from_state_space
from benchmarks.rendering_reference import corner_area, coverage, expose_reference
from scipy import signal

from benchmarks import figure, identification, long_diagnoses, measurement, rendering, report, rules, run, task

WITHOUT_EXTRA = [peer for peer in PEERS if peer.distribution == "scipy"]


@pytest.mark.parametrize("period", identification.PERIODS)
@pytest.mark.parametrize("peer", WITHOUT_EXTRA, ids=lambda peer: peer.name)
def test_scipy_finds_the_plant_in_clean_data(peer, period):
    recording = task.record(task.excitation(), period, None)
    assert peer.identify(recording, task.nominal()) == pytest.approx([100.0, 2.0, 100.0], rel=1e-8)


def test_clean_data_are_511_pairs_of_a_first_order_hold():
    given, measured = task.record(task.excitation(), 0.1, None).pairs()
    numerator, denominator, _ = signal.cont2discrete(([100.0], [1.0, 2.0, 100.0]), 0.1, "foh")
    assert len(given) == len(measured) == 511
    assert signal.lfilter(numerator.ravel(), denominator, given) == pytest.approx(measured, abs=1e-12)


def test_discrete_models_come_back_to_continuous_time():
    a, b, c, d = signal.tf2ss([100.0], [1.0, 2.0, 100.0])
    held = signal.cont2discrete((a, b, c, d), 0.1)
    assert from_state_space(*held[:4], 0.1) == pytest.approx([100.0, 2.0, 100.0], rel=1e-9)
    with pytest.raises(ValueError, match="negative real axis"):
        from_discrete([-0.5, 0.4], 1.0, 0.1)
    with pytest.raises(ValueError, match="no logarithm"):
        from_discrete([0.0, 0.4], 1.0, 0.1)


def _raise(_recording, _nominal):
    raise RuntimeError("did not converge")


def test_missing_and_failing_peers_stand_in_the_table():
    tools = (
        *identification.TOOLS[:2],
        *WITHOUT_EXTRA,
        Peer("absent", "no_such_package", "no-such-package", "none", _raise),
        Peer("failing", "numpy", "numpy", "none", _raise),
        Peer("wrong", "numpy", "numpy", "none", lambda recording, nominal: 2.0 * nominal, most_seeds=1),
    )
    result = identification.run(periods=(0.1,), seeds=2, tools=tools)
    rows = result.table.set_index("tool")
    assert rows.loc["absent", "fits"] == 0
    assert "ModuleNotFoundError" in rows.loc["absent", "missing"]
    assert "no_such_package" in result.shown.set_index("tool").loc["absent –", "not run because"]
    assert rows.loc["failing", "gross_failures"] == 2
    assert "did not converge" in rows.loc["failing", "raised"]
    assert (rows.loc["wrong", "fits"], rows.loc["wrong", "gross_failures"]) == (1, 1)
    assert not rows.loc[["absent", "failing", "wrong"], "equal_accuracy"].any()
    # The same model, hold and criterion: the same estimate.
    assert rows.loc[[peer.name for peer in WITHOUT_EXTRA], "equal_accuracy"].all()
    assert [goal.met for goal in result.goals] == [goal.measured <= goal.limit for goal in result.goals]
    drawn = figure.draw(result.table)
    assert {text.get_text() for text in drawn.axes[0].texts} >= {"camid (2 fits only)"}


def test_no_line_to_a_label_of_the_figure_crosses_a_label():
    """Three tools as near to each other as measured, under a long label."""
    tools = {"scipy": (1.089, 10.0), "pysib": (1.5415, 6.4), "SIPPY": (1.589, 6.24), "nfoursid": (1.576, 7.32)}
    table = pd.DataFrame(
        {"period": figure.PERIOD, "tool": tool, "start": "none", "to_bound": error, "milliseconds": time, "fits": 60}
        | {"gross_failures": 0}
        for tool, (error, time) in {**tools, "jax-sysid": (0.79, 5400.0), "sysidentpy": (7.8, 5.6)}.items()
    )
    table.loc[0, "tool"] = "scipy output error with a long name"
    drawn = figure.draw(table)
    drawn.draw_without_rendering()
    texts = [text for text in drawn.axes[0].texts if text.get_text()]
    lines = [text.arrow_patch for text in drawn.axes[0].texts if text.arrow_patch is not None]
    assert len(texts) == len(table)
    assert lines
    for line in lines:
        (x0, y0), (x1, y1) = line.get_path().transformed(line.get_transform()).vertices[[0, -1]]
        for share in np.linspace(0.1, 0.9, 50):
            at = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            assert not any(text.get_window_extent().contains(*at) for text in texts)


def test_reference_is_right_on_a_static_disk():
    centre, radius, shape = (20.3, 15.7), 6.0, (40, 48)
    image = expose_reference(lambda time: np.tile(centre, (len(time), 1)), 0.0, 1.0, radius, shape, 1)
    assert image.sum() == pytest.approx(np.pi * radius**2, rel=1e-12)
    lines = 400
    x = (np.arange(shape[1] * lines) + 0.5) / lines - 0.5 - centre[0]
    y = (np.arange(shape[0] * lines) + 0.5) / lines - 0.5 - centre[1]
    # Counted along x exactly: the chord of each scan line.
    half = np.sqrt(np.maximum(radius**2 - y**2, 0.0))
    left = x.reshape(shape[1], lines)[:, 0] - 0.5 / lines
    chords = np.clip(np.minimum(left + 1.0, half[:, None]) - np.maximum(left, -half[:, None]), 0.0, None)
    assert image == pytest.approx(chords.reshape(shape[0], lines, shape[1]).mean(axis=1), abs=1e-4)


def test_reference_is_cut_at_the_border_and_averages_a_motion():
    def path(time):
        return np.stack((4.0 * time - 2.0, np.zeros_like(time)), axis=-1)

    image = expose_reference(path, 0.0, 1.0, 3.0, (6, 7), 64)
    wide = expose_reference(lambda time: path(time) + 10.0, 0.0, 1.0, 3.0, (30, 30), 64)
    assert image == pytest.approx(wide[10:16, 10:17], abs=1e-14)
    assert expose_reference(lambda time: path(time) - 99.0, 0.0, 1.0, 3.0, (6, 7), 4).max() == 0.0


def test_corner_area_of_halves_and_quarters():
    assert corner_area(np.array([1.0, 0.0, 0.0, -1.0]), np.array([1.0, 0.0, 2.0, 1.0])) == pytest.approx(
        np.pi * np.array([1.0, 0.25, 0.5, 0.0]), abs=1e-15
    )
    row = coverage(0.0, 0.0, 5.0, np.arange(7), np.array([0]))[0, 0]
    assert row[:4] == pytest.approx(np.ones(4), abs=1e-13)
    assert 0.4 < row[5] < 0.5 < row[4] <= 1.0 + 1e-13
    assert row[6] == 0.0


def test_rendering_and_measurement_run():
    exposure = task.configuration()["imaging"]["exposure"]
    path = rendering.paths(exposure)["start and stop, 63 px"]
    rows = rendering.compare("start and stop", path, exposure, 30.0, rendering.FrameFormat(), 1)
    errors = {row["tool"]: row["largest_error"] for row in rows}
    assert errors["camid"] < 1e-3 < errors["OpenCV, 256 circles"] < 0.5
    errors = measurement.run(positions=10, rounds=1).table.set_index(["area", "tool"])["rms_error"]
    # The plain pipeline selects the same pixels.
    assert errors["64 × 64", measurement.PLAIN] == pytest.approx(errors["64 × 64", "camid gradient_centroid"], abs=1e-6)
    assert errors["64 × 64", "camid grey_level_centroid, threshold 10"] < 0.02


def test_numbers_and_names():
    assert [report.number(x) for x in (0.0, np.nan, 12345.0, 0.98765, 6.16e-5, 1e-12, 262.4)] == [
        "0", "–", "12 300", "0.988", "0.0000616", "1.00e-12", "262",
    ]  # fmt: skip
    assert run.main(["no-such-benchmark"]) == 2


def test_the_profile_of_a_diagnosis_replaces_its_part_of_the_page():
    from benchmarks.diagnosis import TITLE, put_in

    page = "# Benchmarks\n\ntext\n"
    once = put_in(page, f"{TITLE}\n\none\n")
    assert once == f"# Benchmarks\n\ntext\n\n{TITLE}\n\none\n"
    assert put_in(once, f"{TITLE}\n\ntwo\n") == once.replace("one", "two")


def test_long_recordings_are_diagnosed_and_timed(monkeypatch, capsys):
    monkeypatch.setattr(long_diagnoses, "LENGTHS", (1_000,))
    long_diagnoses.main()
    assert capsys.readouterr().out.startswith("1,000 frames: ")
    recording = long_diagnoses.recording(1_000)
    assert len(recording) == 1_000
    assert recording["t"].iloc[1] == long_diagnoses.PERIOD


def test_every_rule_can_be_left_out(capsys, monkeypatch, tmp_path):
    """A rule whose place in the code has another name fails here, and not after an hour."""
    for rule in rules.RULES:
        with rules.without(rule):
            pass
    two = (rules.ALL_RULES, "held-out rows refute names")
    monkeypatch.setattr(rules, "RULES", {name: rules.RULES[name] for name in two})
    monkeypatch.setattr(rules, "WORKERS", 1)
    rules.main(["--recordings", "2", "--seed", "5", "--rows", str(tmp_path / "rows.csv")])
    table = capsys.readouterr().out
    assert "| held-out rows refute names |" in table
    assert "2 recordings of concealed, seed 5" in table
    assert set(pd.read_csv(tmp_path / "rows.csv")["rule"]) == set(two)
