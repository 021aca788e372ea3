"""Positions against the known path, and stated standard deviations against the scatter of repeated noise."""

import numpy as np
import pytest

import camid
from tests.support import films

XY = ["x", "y"]


def errors(table, positions, columns=XY):
    assert len(table) == len(positions)
    difference = table[columns].to_numpy() - positions
    return difference.mean(axis=0), np.sqrt(np.mean(difference**2, axis=0))


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("bright.avi", {"bright": True}),
        ("bright.avi", {}),
        ("dark.avi", {"dark": True}),
        ("dark.avi", {}),
        ("bright.avi", {"bright": True, "region": (100, 50, 50, 50)}),
    ],
)
def test_lossless_positions(clips, name, options):
    """Measured: bias below 0.002 px, rms 0.005 px."""
    folder, positions = clips
    track = camid.track(folder / name, **options)
    bias, rms = errors(track.table, positions)
    assert np.all(np.abs(bias) < 0.005)
    assert np.all(rms < 0.01)
    np.testing.assert_allclose(track.table["t"], np.arange(60) / 60.0, atol=1e-9)
    assert track.table["quality"].min() > 0.8
    assert track.table["repeated"].sum() == 0
    assert track.warnings() == []
    _, rms = errors(track.table, positions, ["x_gradient", "y_gradient"])
    assert np.all((rms > 0.02) & (rms < 0.25))


def test_methods_are_the_two_centroids(clips):
    folder, _ = clips
    grey = camid.track(folder / "bright.avi", bright=True).table
    gradient = camid.track(folder / "bright.avi", bright=True, method="gradient").table
    np.testing.assert_array_equal(gradient[["x_grey_level", "y_grey_level"]], grey[XY])
    np.testing.assert_array_equal(grey[["x_gradient", "y_gradient"]], gradient[XY])
    assert gradient["x_std"].median() > 3.0 * grey["x_std"].median()


def test_motion_blur_gives_the_mean_position(tmp_path):
    """A disk that moves over 25 px during the exposure, at a speed that changes."""
    fine = films.path(40 * 32, 40.0 * 32.0, frequency=2.2, reach=(40.0, 20.0))
    blur = [fine[k * 32 : (k + 1) * 32] for k in range(40)]
    mean = np.array([b.mean(axis=0) for b in blur])
    assert np.hypot(*np.diff(mean, axis=0).T).max() > 13.0
    film = films.encode(tmp_path / "blur.avi", films.film(mean, seed=4, blur=blur, noise=1.0), rate=40)
    bias, rms = errors(camid.track(film, bright=True).table, mean)
    assert np.all(np.abs(bias) < 0.01)
    assert np.all(rms < 0.02)


@pytest.mark.parametrize(
    ("noise", "background", "marker", "radius"),
    [(2.0, 40.0, 210.0, 8.0), (5.0, 60.0, 180.0, 6.0), (1.0, 100.0, 130.0, 8.0), (6.0, 200.0, 50.0, 12.0)],
)
@pytest.mark.parametrize("method", ["grey-level", "gradient"])
def test_standard_deviations_are_those_of_repeated_noise(tmp_path, method, noise, background, marker, radius):
    """Several places, each with independent noise again and again; measured ratios: 0.95 to 1.1, gradient 0.75 to 1."""
    places = np.array([(35.3, 30.7), (36.0, 31.0), (34.75, 30.25), (35.5, 31.4)])
    scatter, stated = [], []
    for k, place in enumerate(places):
        frames = films.film(
            [place] * 80,
            seed=10 + k,
            size=(62, 70),
            noise=noise,
            background=background,
            marker=marker,
            radius=radius,
        )
        film = films.encode(tmp_path / "still.avi", frames)
        look = {"bright": True} if marker > background else {"dark": True}
        table = camid.track(film, method=method, **look).table
        scatter.append(table[XY].var(ddof=1))
        stated.append(np.square(table[["x_std", "y_std"]]).mean().to_numpy())
    ratio = np.sqrt(np.mean(scatter, axis=0) / np.mean(stated, axis=0))
    assert np.all((ratio > 0.7) & (ratio < 1.4))


@pytest.mark.parametrize(
    ("name", "rgb", "background"),
    [
        ("red", (200, 30, 40), (200, 200, 200)),
        ("green", (30, 160, 60), (200, 190, 180)),
        ("#1e3cdc", (30, 60, 220), (90, 90, 90)),
        ("Orange", (230, 140, 20), (20, 20, 20)),
    ],
)
@pytest.mark.parametrize(("pixels", "limit"), [("bgr0", 0.02), ("yuv444p", 0.02), ("yuv420p", 0.05)])
def test_colours(tmp_path, name, rgb, background, pixels, limit):
    positions = films.path(20)
    frames = films.coloured(positions, rgb, seed=3, background=background)
    film = films.encode(tmp_path / "colour.avi", frames, pixels=pixels)
    bias, rms = errors(camid.track(film, colour=name).table, positions)
    assert np.all(np.abs(bias) < 0.5 * limit)
    assert np.all(rms < limit)


@pytest.mark.parametrize(
    ("file", "how", "limit"),
    [
        ("film.mp4", {"codec": "libx264", "pixels": "yuv420p", "options": {"crf": "18"}}, 0.1),
        ("film.mp4", {"codec": "libx264", "pixels": "gray", "options": {"qp": "0"}}, 0.01),
        ("film.mp4", {"codec": "mpeg4", "pixels": "yuv420p", "options": {"qmin": "2", "qmax": "3"}}, 0.05),
        ("film.avi", {"codec": "mjpeg", "pixels": "yuvj420p", "options": {"qmin": "2", "qmax": "2"}}, 0.02),
        ("film.mkv", {"codec": "ffv1", "pixels": "gray10le"}, 0.01),
        ("film.avi", {"codec": "rawvideo", "pixels": "bgr24"}, 0.01),
    ],
)
def test_codecs(tmp_path, file, how, limit):
    positions = films.path(30)
    film = films.encode(tmp_path / file, films.film(positions, seed=1), **how)
    track = camid.track(film, bright=True)
    bias, rms = errors(track.table, positions)
    assert np.all(np.abs(bias) < 0.5 * limit)
    assert np.all(rms < limit)
    np.testing.assert_allclose(track.table["t"], np.arange(30) / 60.0, atol=6e-4)  # Matroska counts milliseconds


def test_a_lossy_codec_is_told_from_noise(tmp_path):
    """What H.264 does to the positions is more than the noise of the pixels, and the track says so."""
    options = {"codec": "libx264", "pixels": "yuv420p", "options": {"crf": "30"}}
    film = films.encode(tmp_path / "film.mp4", films.film(films.path(60), seed=1), **options)
    track = camid.track(film, bright=True)
    assert any("x scatters by" in w for w in track.warnings())
    _, rms = errors(track.table, films.path(60))
    assert track.scatter["x"] == pytest.approx(rms[0], rel=0.5)


def test_scale_origin_and_direction(clips):
    folder, _ = clips
    plain = camid.track(folder / "bright.avi", bright=True).table
    scaled = camid.track(folder / "bright.avi", bright=True, scale=0.02, unit="m", origin=(80.0, 60.0), upwards=True)
    assert scaled.unit == "m"
    table = scaled.table
    np.testing.assert_allclose(table["x"], 0.02 * (plain["x"] - 80.0))
    np.testing.assert_allclose(table["y"], -0.02 * (plain["y"] - 60.0))
    np.testing.assert_allclose(table["y_gradient"], -0.02 * (plain["y_gradient"] - 60.0))
    np.testing.assert_allclose(table["y_std"], 0.02 * plain["y_std"])
    assert scaled.to_mapping()["unit"] == "m"


@pytest.mark.parametrize(
    ("file", "codec", "pixels"),
    [
        ("film.avi", "rawvideo", "yuyv422"),
        ("film.nut", "rawvideo", "nv12"),
        ("film.mkv", "ffv1", "yuv422p10le"),
        ("film.mkv", "ffv1", "gbrp10le"),
        ("film.mkv", "ffv1", "bgra"),
        ("film.avi", "huffyuv", "rgb24"),
    ],
)
def test_pixel_formats(tmp_path, file, codec, pixels):
    positions = films.path(12)
    frames = films.coloured(positions, (200, 30, 40), seed=3)
    film = films.encode(tmp_path / file, frames, codec=codec, pixels=pixels)
    for look in ({"colour": "red"}, {"dark": True}):
        _, rms = errors(camid.track(film, **look).table, positions)
        assert np.all(rms < 0.02)
