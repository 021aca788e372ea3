"""What is chosen and computed so far, which step is next, and what becomes of names that people give to files."""

import pytest

from camid.studio.marker import Marker
from camid.studio.project import STEPS, Project, kind_of, safe_name


@pytest.fixture
def project(tmp_path):
    return Project(tmp_path)


def states(project):
    return [project.state(step) for step in STEPS]


def with_results(project):
    project.columns, project.simulation = {"names": ["t", "y"]}, "schema: 1\n"
    project.identification, project.diagnosis = {"nrmse": 0.1}, {"verdict": "explained"}
    for name in ("simulation.yaml", "model.yaml", "comparison.png", "comparison.csv"):
        (project.folder / name).write_text("x", encoding="utf-8")
    (project.folder / "diagnosis").mkdir()
    (project.folder / "diagnosis" / "report.html").write_text("x", encoding="utf-8")


def test_a_recording_needs_no_marker(project):
    assert states(project) == ["open", *["waiting"] * 5]
    project.take_recording("slide.csv")
    assert states(project) == ["done", "not needed", *["waiting"] * 4]
    with_results(project)
    assert states(project) == ["done", "not needed", *["done"] * 4]


def test_a_clip_waits_for_its_marker(project):
    project.take_clip("pendulum.mp4")
    project.frame = {"width": 240}
    assert states(project) == ["done", "open", *["waiting"] * 4]
    project.take_tracked("pendulum.csv", {"rows": 360}, ["it scatters"])
    assert (project.recordings, project.warnings) == (["pendulum.csv"], {"marker": ["it scatters"]})
    assert states(project)[:3] == ["done", "done", "waiting"]


def test_what_follows_from_a_step_goes_with_it(project):
    project.take_clip("pendulum.mp4")
    project.take_tracked("pendulum.csv", {"rows": 360}, [])
    with_results(project)
    project.forget("diagnose")
    assert project.identification is not None
    assert (project.diagnosis, (project.folder / "diagnosis").exists()) == (None, False)
    with_results(project)
    project.forget("simulation")
    assert (project.identification, project.diagnosis) == (None, None)
    assert project.simulation
    assert sorted(p.name for p in project.folder.iterdir()) == ["simulation.yaml"]
    project.forget("marker")
    assert (project.recordings, project.tracked, project.simulation) == ([], None, "")
    assert states(project)[1] == "open"


def test_another_clip_is_another_project_and_recordings_gather(project):
    project.take_clip("pendulum.mp4")
    project.marker.region = (1, 2, 30, 40)
    project.take_clip("stage.mp4")
    assert (project.clip, project.marker) == ("stage.mp4", Marker())
    for name in ("one.csv", "two.csv", "one.csv"):
        project.take_recording(name)
    assert (project.clip, project.recordings) == (None, ["two.csv", "one.csv"])


def test_a_simulation_with_an_error_is_not_used(project):
    project.take_recording("slide.csv")
    project.columns, project.simulation = {"names": []}, "schema: 1\n"
    project.errors["simulation"] = "simulation.yaml: no plant"
    assert states(project)[2:5] == ["open", "waiting", "waiting"]


def test_what_was_uploaded_is_not_offered_or_served(project):
    project.take_recording("slide.csv")
    (project.folder / "slide.csv").write_text("t,u,y\n", encoding="utf-8")
    (project.folder / "page.html").write_text("<script>", encoding="utf-8")
    with_results(project)
    assert project.files() == [
        "simulation.yaml",
        "model.yaml",
        "comparison.png",
        "comparison.csv",
        "diagnosis/report.html",
    ]


def test_messages_do_not_name_the_temporary_folder(project):
    assert project.without_folder(f"{project.folder}/simulation.yaml, line 3: no") == "simulation.yaml, line 3: no"


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("slide.csv", "slide.csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\data\\run 1.csv", "run 1.csv"),
        ("--output.csv", "output.csv"),
        (".bashrc", "bashrc"),
        ("<img src=x>.csv", "_img src=x_.csv"),
        ("a\nb\x00.csv", "a_b_.csv"),
        ("simulation.yaml", "my-simulation.yaml"),
        ("Model.YAML", "my-Model.YAML"),
        ("diagnosis", "my-diagnosis"),
        ("", "recording"),
        ("..", "recording"),
        ("Messung größer.csv", "Messung größer.csv"),
        ("x" * 300 + ".parquet", "x" * 93 + ".parquet"),
    ],
)
def test_names_of_files_stay_in_the_folder_and_are_no_options(given, kept, tmp_path):
    assert safe_name(given) == kept
    assert (tmp_path / kept).resolve().parent == tmp_path.resolve()


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *((f"a.{suffix}", "recording") for suffix in ("csv", "MAT", "xlsx", "csv.gz")),
        *((name, "clip") for name in ("a.mp4", "a.unknown", "a")),
        *((f"a.{suffix}", "simulation") for suffix in ("yaml", "YML")),
    ],
)
def test_the_suffix_says_what_a_file_is(name, kind):
    assert kind_of(name) == kind


def test_two_clicks_make_a_region_in_any_order():
    marker = Marker()
    assert marker.click("region", 229.7, 85.2)
    assert marker.region is None
    assert not marker.click("region", 186.4, 44.9)
    assert marker.region == (186, 44, 44, 42)
    assert marker.arguments() == ["--region", "186", "44", "44", "42"]


def test_two_clicks_and_a_length_make_a_scale():
    marker = Marker(length=30.0, unit="mm")
    assert marker.click("scale", 10.0, 20.0)
    assert marker.scale is None
    assert not marker.click("scale", 40.0, 60.0)
    assert (marker.pixels, marker.scale) == (50.0, 0.6)
    assert marker.arguments() == ["--scale", "0.6", "--unit", "mm"]
    assert marker.click("scale", 0.0, 0.0)
    assert marker.scale is None
    marker.click("scale", 0.0, 0.0)
    assert marker.scale is None  # two clicks on one point have no length


def test_the_origin_is_counted_from_the_centre_of_a_pixel():
    marker = Marker(upwards=True, start=1.5)
    marker.click("origin", 120.0, 48.0)
    assert marker.options() == {"origin": [119.5, 47.5], "start": 1.5, "upwards": True}
    assert marker.arguments() == ["--origin", "119.5", "47.5", "--start", "1.5", "--upwards"]


def test_a_click_on_the_marker_takes_its_colour():
    marker = Marker()
    assert marker.options() == {}
    assert not marker.click("colour", 5.0, 5.0, "#c02020")
    assert marker.options() == {"colour": "#c02020"}
    assert Marker(appearance="dark").arguments() == ["--dark"]
