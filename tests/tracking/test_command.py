"""``camid track``: the files that it writes, what it prints, and a real clip."""

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares

import camid
from camid.cli import main

COLUMNS = ["t", "x", "y", "x_std", "y_std", "x_gradient", "y_gradient", "quality", "repeated"]


def test_the_recording_and_the_summary(clips, tmp_path, capsys):
    folder, positions = clips
    output = tmp_path / "r.csv"
    assert main(["track", str(folder / "dark.avi"), "--dark", "--output", str(output)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for said in ("followed: the darkest thing", "60 with the marker of 60; 0 missing", "60 frames/s effective"):
        assert said in out
    table = pd.read_csv(output)
    assert list(table.columns) == COLUMNS
    assert np.abs(table[["x", "y"]].to_numpy() - positions).max() < 0.03
    # It is a recording.
    recording = camid.read_recording(output, "t", ["x"])
    assert len(recording) == 60
    assert recording.period == pytest.approx(1.0 / 60.0)


def test_json(clips, tmp_path, capsys):
    folder, _ = clips
    arguments = ["track", str(folder / "bright.avi"), "--output", str(tmp_path / "r.parquet"), "--json"]
    assert main([*arguments, "--method", "gradient", "--scale", "0.5", "--unit", "mm"]) == 0
    content = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert content["marker"] == "what moves (brighter than what is behind it)"
    assert (content["frames"], content["rows"], content["unit"], content["method"]) == (60, 60, "mm", "gradient")
    assert content["missing"] == {"count": 0, "gaps": []}
    assert content["without_marker"] == content["repeated"] == []
    assert content["effective_rate"] == pytest.approx(60.0)
    assert content["image"] == {"width": 160, "height": 120}
    assert 0.0 < content["quality"]["lowest"] <= content["quality"]["median"] <= 1.0
    assert "x_grey_level" in pd.read_parquet(tmp_path / "r.parquet")


def test_a_second_run_writes_the_same_bytes(clips, tmp_path):
    folder, _ = clips
    for name in ("a", "b"):
        preview = ["--preview", str(tmp_path / f"{name}.png")]
        assert main(["track", str(folder / "bright.avi"), "--output", str(tmp_path / f"{name}.csv"), *preview]) == 0
    for suffix in ("csv", "png"):
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_the_preview_shows_path_and_frames(clips, tmp_path):
    folder, _ = clips
    camid.track(folder / "bright.avi", bright=True, preview=tmp_path / "p.png")
    image = cv2.imread(str(tmp_path / "p.png"))
    height, width = image.shape[:2]
    assert width == 1500
    assert 700 < height < 1500
    # Sky blue of the path, blue of x(t), vermilion of y(t), as BGR.
    for colour, least in (((233, 180, 86), 300), ((178, 114, 0), 300), ((0, 94, 213), 300)):
        assert np.count_nonzero(np.all(image == colour, axis=2)) > least


def test_what_is_done_without_a_terminal_is_quiet(clips, tmp_path, capsys):
    folder, _ = clips
    said = []
    camid.track(folder / "bright.avi", progress=said.append)
    assert any("what moves" in s for s in said)
    assert any("frame 50 of 60" in s for s in said)
    assert capsys.readouterr() == ("", "")


def test_a_real_pendulum(tmp_path, capsys):
    """A red ball before a white wall; its period is 2.629 s."""
    name = os.environ.get("CAMID_RECORDINGS")
    if name is None:
        pytest.skip("CAMID_RECORDINGS does not name the folder of the real recordings")
    film = Path(name) / "pendulum.mp4"
    if not film.exists():
        pytest.skip(f"{film} is absent")
    assert main(["track", str(film), "--colour", "red", "--output", str(tmp_path / "r.csv"), "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert (content["rows"], content["repeated"], content["without_marker"]) == (305, [], [])
    assert content["effective_rate"] == pytest.approx(29.75)
    assert 0.01 < content["scatter"]["x"] < 0.1
    table = pd.read_csv(tmp_path / "r.csv")
    time, x = table["t"].to_numpy(), table["x"].to_numpy()

    def residual(p):
        return p[0] + p[1] * np.exp(-p[2] * time) * np.cos(p[3] * time + p[4]) - x

    fits = [least_squares(residual, [315.0, 280.0, 0.03, 2.39, phase]) for phase in (0.0, 1.6, 3.1, 4.7)]
    best = min(fits, key=lambda fit: fit.cost)
    assert 2.0 * np.pi / abs(best.x[3]) == pytest.approx(2.629, abs=0.002)
    # Without a choice the same ball is found, by its grey levels.
    moving = camid.track(film)
    assert np.abs(moving.table["x"] - x).max() < 6.0
