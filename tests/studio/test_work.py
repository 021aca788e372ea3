"""Commands run in processes: their progress, warnings and errors reach the page, and they end when they are told to."""

import asyncio
import json
import os
import shutil
import time

import pytest

import camid
from camid.studio.job import CANCELLED, Job
from camid.studio.look import main as look
from camid.studio.project import Project
from camid.studio.work import Work
from tests.support import ROOT


@pytest.fixture
def project(tmp_path):
    for name in ("slide.csv", "slide.yaml"):
        shutil.copy(ROOT / "examples" / name, tmp_path)
    return Project(tmp_path)


def run(project, *arguments, until=None):
    job, said = Job("testing", arguments, project.folder), []

    async def running():
        def heard():
            said.append(job.step)
            if until is not None and until in job.step:
                job.cancel()

        return await job.run(heard)

    return asyncio.run(running()), job, said


def find_repeatedly(group):
    """Signal a process group for five seconds: what was killed is there until the system has taken it away."""
    for _ in range(500):
        os.killpg(group, 0)
        time.sleep(0.01)


def test_progress_and_the_answer_of_a_command_are_heard(project):
    well, job, said = run(project, "camid", "identify", "slide.csv", "--simulation", "slide.yaml", "--json")
    assert (well, job.error, job.warnings) == (True, None, [])
    assert said[0] == "reading the recording"
    assert len(said) > 2
    assert json.loads(job.output)["converged"]


def test_the_error_of_a_command_is_its_one_line(project):
    well, job, _ = run(project, "camid", "identify", "slide.csv", "--order", "2", "0", "--input-column", "force")
    assert not well
    assert job.error.startswith("slide.csv: no column 'force'; known here: t, u, y;")
    assert job.output == ""


def test_a_command_that_dies_is_said_to_have_died(project):
    well, job, _ = run(project, "no_such_module_of_anybody")
    assert not well
    assert job.error == "testing ended without an answer (exit code 1)"


@pytest.mark.slow
def test_a_cancelled_command_ends_and_leaves_nothing(project):
    before = {p.name for p in project.folder.iterdir()}
    well, job, _ = run(
        project, *("camid", "diagnose", "slide.csv", "--simulation", "slide.yaml", "--output", "out"), until="reading"
    )
    assert (well, job.error) == (False, CANCELLED)
    assert {p.name for p in project.folder.iterdir()} == before
    with pytest.raises(ProcessLookupError):
        find_repeatedly(job._process.pid)


@pytest.mark.slow
def test_a_recording_gets_a_first_simulation_and_an_identified_one(project):
    project.take_recording("slide.csv")
    work, changes = Work(project), []
    work.watchers.append(lambda: changes.append(work.busy))

    async def all_steps():
        await work.draft()
        await work.change(("sensor", "kind"), "camera")
        await work.identify()

    asyncio.run(all_steps())
    assert project.errors == {}
    assert {"recording", "simulation", "identify", ""} == set(changes)
    assert project.columns["names"] == ["t", "u", "y"]
    direct = camid.identify(project.folder / "slide.csv", project.folder / "simulation.yaml")
    assert project.identification["nrmse"] == pytest.approx(direct.nrmse, rel=1e-9)
    assert project.files() == ["simulation.yaml", "model.yaml", "comparison.png", "comparison.csv"]
    asyncio.run(work.change(("sensor", "exposure"), "long"))
    assert project.errors["simulation"].startswith("simulation.yaml, line ")
    assert project.identification is None
    assert project.state("identify") == "waiting"


def test_a_file_that_is_no_recording_is_refused_by_name(project):
    (project.folder / "noise.csv").write_bytes(b"<script>alert(1)</script>\n")
    project.take_recording("noise.csv")
    asyncio.run(Work(project).draft())
    assert project.errors["recording"].startswith("noise.csv: ")
    assert project.recordings == []
    assert project.state("recording") == "open"


def test_a_second_file_that_is_refused_leaves_the_first_in_use(project):
    (project.folder / "noise.csv").write_bytes(b"nothing\n")
    for name in ("slide.csv", "noise.csv"):
        project.take_recording(name)
    work = Work(project)
    asyncio.run(work.draft())
    assert project.errors["recording"].startswith("noise.csv: ")
    assert (project.recordings, project.state("simulation")) == (["slide.csv"], "done")
    asyncio.run(work.start_over())
    assert (project.recordings, project.errors, project.state("recording")) == ([], {}, "open")


def test_closing_ends_what_runs(project):
    project.take_recording("slide.csv")
    work = Work(project)

    async def closed():
        task = asyncio.create_task(work.draft())
        while work.job is None or work.job._process is None:
            await asyncio.sleep(0.01)
        await work.close()
        await task

    asyncio.run(closed())
    assert (work.job, work.busy) == (None, "")
    assert project.errors == {"recording": CANCELLED}


def looked(capsys, what, **given):
    code = look([what, json.dumps(given)])
    printed = capsys.readouterr()
    return json.loads(printed.out) if code == 0 else (code, printed.err)


def test_the_first_frame_is_shown_with_its_marker(tmp_path, capsys, monkeypatch):
    import cv2

    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "examples/pendulum.mp4", tmp_path)
    found = looked(capsys, "frame", clip="pendulum.mp4", picture="frame.png", settings={"colour": "red"})
    assert (found["width"], found["height"]) == (240, 96)
    assert found["marker"]["region"] == [185.5, 43.5, 44.0, 42.0]  # that of `camid track --colour red`
    image = cv2.imread("frame.png")
    assert image.shape == (96, 240, 3)
    blue, _, red = image[round(found["marker"]["y"]), round(found["marker"]["x"])]
    assert red > 150 > blue


def test_a_frame_without_a_marker_is_shown_all_the_same(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "examples/pendulum.mp4", tmp_path)
    settings = {"colour": "red", "region": [0, 0, 20, 20]}
    found = looked(capsys, "frame", clip="pendulum.mp4", picture="frame.png", settings=settings)
    assert "the colour red" in found["problem"]
    assert (tmp_path / "frame.png").is_file()


def test_what_is_no_clip_is_refused_in_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clip.mp4").write_bytes(b"no clip")
    code, line = looked(capsys, "frame", clip="clip.mp4", picture="frame.png", settings={})
    assert code == 2
    assert line.startswith("camid: error: clip.mp4: ")
    assert line.count("\n") == 1


def test_columns_come_with_curves_of_few_points(project, capsys, monkeypatch):
    monkeypatch.chdir(project.folder)
    found = looked(capsys, "columns", recording="slide.csv")
    assert (found["names"], found["time"]) == (["t", "u", "y"], "t")
    assert {len(curve) for curve in found["curves"].values()} == {500}
    assert found["curves"]["t"][:2] == [0.0, 0.06]
