"""Every wrong input is refused in one line, with exit code 2, and nothing is written."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from camid.cli import main
from tests.support import films

H264 = {"codec": "libx264", "pixels": "yuv420p"}


@pytest.fixture(scope="module")
def frames():
    return films.film(films.path(60), seed=1)


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refusal(capsys, *arguments):
    before = {p: p.read_bytes() for p in Path().rglob("*") if p.is_file()}
    assert main(["track", *map(str, arguments), "--output", "r.csv"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("camid: error: ")
    assert err.count("\n") == 1
    assert {p: p.read_bytes() for p in Path().rglob("*") if p.is_file()} == before
    return err.removeprefix("camid: error: ")


def cut(source, share, target):
    content = Path(source).read_bytes()
    Path(target).write_bytes(content[: int(share * len(content))])


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.mp4", None, "none.mp4: no such file"),
        ("text.mp4", b"hello " * 100, "text.mp4: this is not a video"),
        ("text.txt", b"hello\n" * 100, "text.txt: this is not a video (text)"),
        ("empty.mp4", b"", "empty.mp4: this is not a video"),
    ],
)
def test_no_video(bench, capsys, name, content, said):
    if content is not None:
        Path(name).write_bytes(content)
    assert said in refusal(capsys, name)


def test_sound_only(bench, capsys):
    import av

    with av.open("sound.mp4", "w") as container:
        stream = container.add_stream("aac", rate=8000)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 4096), np.float32), format="fltp", layout="mono")
        frame.rate = 8000
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert "sound.mp4: there is no video in the file" in refusal(capsys, "sound.mp4")


def test_truncated_without_index(bench, capsys, frames):
    films.encode(bench / "film.mp4", frames, **H264)
    cut("film.mp4", 0.5, "cut.mp4")
    assert "cut.mp4: the file is truncated: its index ('moov') is missing" in refusal(capsys, "cut.mp4", "--bright")


@pytest.mark.parametrize(
    ("name", "how"),
    [("film.mp4", {**H264, "layout": {"movflags": "faststart"}}), ("film.avi", {}), ("film.mkv", {})],
)
def test_truncated_in_the_middle(bench, capsys, frames, name, how):
    films.encode(bench / name, frames, **how)
    cut(name, 0.7, f"cut_{name}")
    message = refusal(capsys, f"cut_{name}", "--bright")
    assert f"cut_{name}: the video is truncated: " in message
    count = int(message.split("truncated: ")[1].split()[0])
    assert 10 < count < 50
    assert "--allow-truncated" in message
    assert main(["track", f"cut_{name}", "--bright", "--output", "r.csv", "--allow-truncated"]) == 0
    out, err = capsys.readouterr()
    assert f"{count} with the marker of {count}" in out
    assert f"camid: warning: the video is truncated: {count} frames could be read" in err
    # What lies before the cut needs no permission.
    assert main(["track", f"cut_{name}", "--bright", "--output", "r.csv", "--end", "0.1"]) == 0


def test_unknown_codec(bench, capsys, frames):
    films.encode(bench / "film.mp4", frames[:5], **H264)
    Path("film.mp4").write_bytes(Path("film.mp4").read_bytes().replace(b"avc1", b"zzzz"))
    assert "film.mp4: the codec of the video is not known; re-encode it" in refusal(capsys, "film.mp4", "--bright")


def test_codec_that_cannot_be_decoded(bench, capsys, frames):
    films.encode(bench / "film.avi", frames[:5])
    content = bytearray(Path("film.avi").read_bytes())
    start = content.index(b"00dc", content.index(b"movi"))
    while content[start : start + 4] == b"00dc":  # zeros where the packets are
        length = int.from_bytes(content[start + 4 : start + 8], "little")
        content[start + 8 : start + 8 + length] = bytes(length)
        start += 8 + length + length % 2
    Path("film.avi").write_bytes(content)
    assert "film.avi: the video cannot be decoded (ffv1: " in refusal(capsys, "film.avi", "--bright")


def test_no_time_stamps(bench, capsys, frames):
    films.encode(bench / "film.h264", frames, **H264)
    assert "film.h264, frame 0: the video has no time stamps" in refusal(capsys, "film.h264", "--bright")
    assert main(["track", "film.h264", "--bright", "--frame-rate", "50", "--output", "r.csv"]) == 0
    capsys.readouterr()
    films.encode(bench / "film.avi", frames)
    assert "the video has its own time stamps" in refusal(capsys, "film.avi", "--bright", "--frame-rate", "50")


def test_no_frames(bench, capsys, frames):
    films.encode(bench / "film.avi", frames)
    said = "film.avi: there are no frames between --start and --end"
    message = refusal(capsys, "film.avi", "--bright", "--start", "100")
    assert said in message
    assert "; the clip lasts from 0 s to " in message
    films.encode(bench / "two.avi", frames[:2])
    assert "two.avi: 2 frames with a marker; a recording needs 3" in refusal(capsys, "two.avi", "--bright")


def test_the_marker_is_nowhere(bench, capsys, frames):
    films.encode(bench / "film.avi", frames)
    assert "film.avi: the video has no colour" in refusal(capsys, "film.avi", "--colour", "red")
    assert "film.avi: the marker is nowhere in the first 31 frames (the darkest thing)" in refusal(
        capsys, "film.avi", "--dark"
    )
    positions = films.path(40)
    films.encode(bench / "blue.avi", films.coloured(positions, (30, 60, 220), seed=3), pixels="yuv444p")
    assert "(the colour red)" in refusal(capsys, "blue.avi", "--colour", "red")


def test_the_marker_leaves_the_image(bench, capsys):
    positions = np.column_stack((np.linspace(40.0, 190.0, 60), np.full(60, 60.0)))
    films.encode(bench / "film.avi", films.film(positions, seed=1))
    message = refusal(capsys, "film.avi", "--bright")
    # The disk of radius 8 reaches the last pixel's edge when its centre is at 151.5.
    last = int(np.flatnonzero(positions[:, 0] + 8.0 < 159.0)[-1])
    assert f"film.avi, t = {(last + 1) / 60:.6g} s (frame {last + 1}): the marker leaves the image" in message
    end = message.rpartition("--end ")[2].strip()
    assert main(["track", "film.avi", "--bright", "--end", end, "--output", "r.csv"]) == 0
    assert f"frames: {last + 1} with the marker" in capsys.readouterr().out
    fast = np.column_stack((np.linspace(40.0, 940.0, 30), np.full(30, 60.0)))
    films.encode(bench / "fast.avi", films.film(fast, seed=1))
    assert "(frame 4): the marker leaves the image" in refusal(capsys, "fast.avi", "--bright")


def test_the_marker_is_lost(bench, capsys, frames):
    empty = films.film([(-50.0, -50.0)] * 40, seed=2)
    films.encode(bench / "film.avi", frames[:30] + empty)
    message = refusal(capsys, "film.avi", "--bright", "--longest-gap", "10")
    assert "film.avi, t = 0.5 s (frame 30): the marker is lost and not seen again in 11 frames" in message
    assert "--end 0.483333" in message


def test_two_markers(bench, capsys, frames):
    second = films.disk(120, 160, (30.0, 30.0), 8.0)
    both = [np.clip(f + 170.0 * second, 0, 255).astype(np.uint8) for f in frames]
    films.encode(bench / "film.avi", both)
    message = refusal(capsys, "film.avi", "--bright")
    assert "two things may be the marker" in message
    assert "at x = 30, y = 30 px" in message
    assert "at x = 121, y = 70 px" in message
    assert main(["track", "film.avi", "--bright", "--region", "10", "10", "40", "40", "--output", "r.csv"]) == 0
    assert main(["track", "film.avi", "--output", "r.csv"]) == 0  # only one of them moves


def test_the_region(bench, capsys, frames):
    films.encode(bench / "film.avi", frames)
    outside = refusal(capsys, "film.avi", "--bright", "--region", 150, 10, 30, 30)
    assert "the region 150 10 30 30 is not inside the image of 160 × 120 px" in outside
    assert "a region of 2 × 30 px" in refusal(capsys, "film.avi", "--bright", "--region", 150, 10, 2, 30)
    cutting = refusal(capsys, "film.avi", "--bright", "--region", 100, 50, 25, 50)
    assert "reaches the border of the region" in cutting


@pytest.mark.parametrize("how", [{}, {**H264, "options": {"crf": "28"}}])
def test_nothing_moves(bench, capsys, how):
    films.encode(bench / "film.mkv", films.film([(50.0, 50.0)] * 50, seed=1), **how)
    assert "film.mkv: nothing moves" in refusal(capsys, "film.mkv")


def test_a_motion_smaller_than_the_marker_needs_a_choice(bench, capsys):
    positions = np.column_stack((80.0 + 3.0 * np.sin(np.arange(60) / 5.0), np.full(60, 60.0)))
    films.encode(bench / "film.avi", films.film(positions, seed=1))
    assert "film.avi: what moves is both brighter and darker" in refusal(capsys, "film.avi")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--colour", "rde"], "--colour: there is no colour 'rde'; did you mean 'red'?"),
        (["--colour", "notacolour"], "there is no colour 'notacolour'; nearest are "),
        (["--colour", "#12345g"], "--colour: '#12345g' is not a colour"),
        (["--colour", "white"], "--colour: white has no hue; say --bright or --dark"),
        (["--bright", "--dark"], "--bright and --dark contradict each other"),
        (["--bright", "--scale", "2"], "--scale without --unit"),
        (["--bright", "--scale", "-1", "--unit", "m"], "--scale -1; it takes a positive number"),
        (["--bright", "--scale", "2", "--unit", "s"], "--unit: 's' is not a unit of length"),
        (["--bright", "--scale", "2", "--unit", "foo"], "--unit: unknown unit 'foo'"),
        (["--bright", "--unit", "mm"], "--unit mm without --scale"),
        (["--bright", "--start", "1", "--end", "0.5"], "--start 1 is not before --end 0.5"),
        (["--bright", "--start", "nan"], "--start nan; it takes a number of seconds"),
        (["--bright", "--origin", "inf", "0"], "--origin takes two finite numbers"),
        (["--bright", "--longest-gap", "-1"], "--longest-gap takes 0 or more"),
        (["--bright", "--method", "magic"], "'magic' is not one of"),
        (["--bright", "--preview", "p.pdf"], "p.pdf: a preview is a PNG image"),
        (["--bright", "--preview", "none/p.png"], "none: no such folder"),
        (["--bright", "--preview", "film.avi"], "film.avi: --preview would overwrite"),
    ],
)
def test_wrong_options(bench, capsys, frames, options, said):
    films.encode(bench / "film.avi", frames[:5])
    assert said in refusal(capsys, "film.avi", *options)


def test_the_output_may_not_be_the_video(bench, capsys):
    Path("r.csv").write_text("t\n")
    assert "r.csv: --output would overwrite what it is made from" in refusal(capsys, "r.csv")


def images(folder, frames, names):
    folder.mkdir()
    for name, frame in zip(names, frames, strict=False):
        cv2.imwrite(str(folder / name), frame)


def test_folders(bench, capsys, frames):
    (bench / "empty").mkdir()
    assert "empty: no PNG image in this folder" in refusal(capsys, "empty", "--frame-rate", "60")
    images(bench / "good", frames, ["1.png", "2.png", "3.png", "4.png"])
    assert "good: images have no time stamps; say --frame-rate" in refusal(capsys, "good", "--bright")
    images(bench / "unnumbered", frames, ["a.png", "b.png"])
    assert "a.png: no number in the name" in refusal(capsys, "unnumbered", "--frame-rate", "60")
    images(bench / "double", frames, ["1.png", "01.png"])
    assert "1.png: the same number as 01.png" in refusal(capsys, "double", "--frame-rate", "60")
    images(bench / "sizes", [frames[0], frames[1], frames[2][:100]], ["1.png", "2.png", "3.png"])
    said = refusal(capsys, "sizes", "--bright", "--frame-rate", "60")
    assert "3.png: 160 × 100 px where the first image has 160 × 120" in said
    images(bench / "broken", frames, ["1.png", "2.png", "3.png"])
    (bench / "broken" / "2.png").write_bytes(b"nothing")
    assert "2.png: this is not a PNG image" in refusal(capsys, "broken", "--bright", "--frame-rate", "60")


@pytest.mark.parametrize(
    ("stamps", "options", "said"),
    [
        ("t\n0\n0.1\n0.2\n", [], "3 rows for 4 images"),
        ("t\n0\n0.1\n0.1\n0.3\n", [], "line 4: the time 0.1 s does not follow"),
        ("time\n0\n0.1\n0.2\n0.3\n", [], "no column t of numbers"),
        ("t\n0\na\n0.2\n0.3\n", [], "no column t of numbers"),
        ("t\n0\n0.1\n0.2\n0.3\n", ["--frame-rate", "10"], "leave out --frame-rate"),
    ],
)
def test_time_stamps_beside_images(bench, capsys, frames, stamps, options, said):
    images(bench / "good", frames, ["1.png", "2.png", "3.png", "4.png"])
    (bench / "good" / "timestamps.csv").write_text(stamps)
    message = refusal(capsys, "good", "--bright", *options)
    assert "timestamps.csv" in message
    assert said in message
