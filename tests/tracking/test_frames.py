"""Time stamps, frames that are missing or copied, and frames without the marker."""

import cv2
import numpy as np
import pandas as pd
import pytest

import camid
from tests.support import films


def test_times_are_those_of_the_container(tmp_path):
    """Irregular time stamps are kept as they are, and no frame is called missing."""
    steps = np.random.default_rng(6).integers(10, 60, 39)
    times = 40 + np.concatenate(([0], np.cumsum(steps)))
    positions = films.path(40)
    for name, codec, pixels in (("film.mp4", "libx264", "gray"), ("film.mkv", "ffv1", "gray")):
        film = films.encode(tmp_path / name, films.film(positions, seed=1), codec=codec, pixels=pixels, times=times)
        track = camid.track(film, bright=True)
        np.testing.assert_allclose(track.table["t"], times / 1000.0, atol=1e-9)
        assert not track.clock.regular
        assert track.to_mapping()["missing"]["count"] is None
        assert any("irregular" in w for w in track.warnings())


def test_gaps_in_the_time_stamps(tmp_path):
    kept = np.delete(np.arange(60), [10, 30, 31, 32])
    film = films.encode(
        tmp_path / "film.mp4", films.film(films.path(60)[kept], seed=1), codec="libx264", times=20 * kept
    )
    track = camid.track(film, bright=True)
    assert len(track.table) == 56
    assert track.clock.regular
    assert track.clock.gaps == [(pytest.approx(0.18), 1), (pytest.approx(0.58), 3)]
    assert track.clock.effective_rate == pytest.approx(55 / (59 * 0.02))
    assert track.clock.period == pytest.approx(0.02)
    assert any("4 frames missing between the time stamps: 1 after t = 0.18 s, 3" in w for w in track.warnings())


@pytest.mark.parametrize(
    "how",
    [
        {"codec": "ffv1"},
        {"codec": "libx264", "pixels": "yuv420p", "options": {"crf": "18"}},
        {"codec": "mpeg4", "pixels": "yuv420p", "options": {"qmin": "2", "qmax": "3"}},
    ],
)
def test_copies_are_found(tmp_path, how):
    """Frames 12, 13 and 40 are copies of the one before; a turning point in between is none."""
    positions = films.path(60, frequency=1.5)
    shown = np.arange(60)
    shown[[12, 13, 40]] = [11, 11, 39]
    frames = films.film(positions, seed=1)
    film = films.encode(tmp_path / "film.mkv", [frames[k] for k in shown], **how)
    track = camid.track(film, bright=True)
    assert np.flatnonzero(track.table["repeated"]).tolist() == [12, 13, 40]
    assert track.to_mapping()["repeated"] == pytest.approx([0.2, 13 / 60, 40 / 60], abs=1e-3)


def test_turning_points_of_a_lossy_film_are_no_copies(tmp_path):
    phase = 2.0 * np.pi * 0.8 * np.arange(150) / 60.0
    positions = np.column_stack((80.0 + 40.0 * np.cos(phase), np.full(150, 60.0)))
    film = films.encode(
        tmp_path / "film.mp4", films.film(positions, seed=1), codec="libx264", pixels="yuv420p", options={"crf": "28"}
    )
    assert camid.track(film, bright=True).table["repeated"].sum() == 0


def test_frames_without_the_marker_have_no_row(tmp_path):
    positions = films.path(60)
    frames = films.film(positions, seed=1)
    empty = films.film([(-50.0, -50.0)] * 60, seed=9)
    for k in (20, 21, 22, 45):
        frames[k] = empty[k]
    film = films.encode(tmp_path / "film.avi", frames)
    for look in ({"bright": True}, {}):
        track = camid.track(film, **look)
        assert [k for k, _ in track.without_marker] == [20, 21, 22, 45]
        seen = np.delete(np.arange(60), [20, 21, 22, 45])
        np.testing.assert_allclose(track.table["t"], seen / 60.0, atol=1e-9)
        assert np.sqrt(np.mean((track.table[["x", "y"]].to_numpy() - positions[seen]) ** 2)) < 0.01
        assert not track.table.isna().any().any()
        assert "4 frames without the marker: t = 0.333333, 0.35, 0.366667, 0.75 s" in track.warnings()


def test_a_marker_that_appears_later(tmp_path):
    frames = films.film(films.path(30), seed=1)
    frames[:5] = films.film([(-50.0, -50.0)] * 5, seed=9)
    track = camid.track(films.encode(tmp_path / "film.avi", frames), bright=True)
    assert [k for k, _ in track.without_marker] == [0, 1, 2, 3, 4]
    assert len(track.table) == 25


def test_fast_and_jerky_motion_is_followed(tmp_path):
    """Steps of up to 45 px with a radius of 8 px, and other velocities from frame to frame."""
    generator = np.random.default_rng(8)
    positions = [np.array([150.0, 110.0])]
    while len(positions) < 40:
        new = positions[-1] + generator.uniform(-32.0, 32.0, 2)
        if np.all((new > 20.0) & (new < [300.0, 220.0])):
            positions.append(new)
    film = films.encode(tmp_path / "film.avi", films.film(positions, seed=1, size=(240, 320)))
    track = camid.track(film, bright=True)
    assert np.abs(track.table[["x", "y"]].to_numpy() - np.array(positions)).max() < 0.03


def test_another_thing_in_the_region_lowers_the_quality(tmp_path):
    """A marker passes a still one: it is measured alone, and quality says that it was not."""
    positions = np.column_stack((np.linspace(25.0, 135.0, 50), np.full(50, 60.0)))
    still = films.disk(120, 160, (80.0, 84.0), 9.0)
    frames = [
        np.clip(np.round(f + 150.0 * still), 0, 255).astype(np.uint8) for f in films.film(positions, seed=1, noise=1.0)
    ]
    track = camid.track(films.encode(tmp_path / "film.avi", frames), bright=True, region=(5, 40, 40, 40))
    assert np.abs(track.table["x"] - positions[:, 0]).max() < 0.1
    away = np.abs(positions[:, 0] - 80.0)
    assert track.table["quality"][away < 6.0].max() < 0.9
    assert track.table["quality"][away > 40.0].min() > 0.95


@pytest.fixture
def folder(tmp_path):
    """PNG images, numbered from 8 without leading zeros."""
    images = tmp_path / "images"
    images.mkdir()
    for k, frame in enumerate(films.film(films.path(12), seed=1)):
        cv2.imwrite(str(images / f"run2_{k + 8}.png"), frame)
    return images


def test_images_in_a_folder(folder):
    track = camid.track(folder, bright=True, frame_rate=60.0)
    np.testing.assert_allclose(track.table["t"], np.arange(12) / 60.0)
    assert np.abs(track.table[["x", "y"]].to_numpy() - films.path(12)).max() < 0.03
    (folder / "run2_12.png").unlink()
    track = camid.track(folder, bright=True, frame_rate=60.0)
    np.testing.assert_allclose(track.table["t"], np.delete(np.arange(12), 4) / 60.0)
    assert track.clock.missing == 1


def test_images_with_time_stamps(folder):
    times = np.cumsum(np.full(12, 0.01)) + 0.003 * np.sin(np.arange(12))
    pd.DataFrame({"file": "any", "t": times}).to_csv(folder / "timestamps.csv", index=False)
    np.testing.assert_allclose(camid.track(folder, bright=True).table["t"], times)


def test_images_of_sixteen_bits_and_in_colour(tmp_path):
    positions = films.path(6)
    deep, coloured = tmp_path / "deep", tmp_path / "coloured"
    deep.mkdir()
    coloured.mkdir()
    grey = films.film(positions, seed=1)
    for k, frame in enumerate(films.coloured(positions, (200, 30, 40), seed=1)):
        cv2.imwrite(str(deep / f"{k}.png"), grey[k].astype(np.uint16) * 257)
        cv2.imwrite(str(coloured / f"{k}.png"), frame[:, :, ::-1])
    plain = camid.track(deep, bright=True, frame_rate=60.0).table
    assert np.abs(plain[["x", "y"]].to_numpy() - positions).max() < 0.03
    table = camid.track(coloured, colour="red", frame_rate=60.0).table
    assert np.abs(table[["x", "y"]].to_numpy() - positions).max() < 0.05


def test_start_and_end(clips):
    folder, positions = clips
    table = camid.track(folder / "bright.avi", bright=True, start=0.25, end=0.5).table
    np.testing.assert_allclose(table["t"], np.arange(15, 31) / 60.0, atol=1e-9)
    assert np.abs(table[["x", "y"]].to_numpy() - positions[15:31]).max() < 0.03
