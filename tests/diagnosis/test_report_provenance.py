"""Where a report comes from: command, files with date and hash, versions; its responses; the same bytes again."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from camid.cli import main
from camid.commands.diagnose import diagnose
from camid.diagnosis.provenance import FILE_TIME, FIRST_STAMP, recorded_file
from camid.diagnosis.report import page
from tests.support import linear_rig as rig
from tests.support import written_diagnoses
from tests.support.report_page import Page

MODIFIED = 1_750_000_000  # 2025-06-15 15:06:40 UTC


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    rig.recording(400).to_csv(folder / "a run.csv", index=False)
    os.utime(folder / "a run.csv", (MODIFIED, MODIFIED))
    rig.write_yaml(rig.simulation(), folder / "S.yaml")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for output in ("first", "again"):
            assert main(["diagnose", "a run.csv", "--simulation", "S.yaml", "--output", output]) == 0
    return folder


def test_the_page_says_what_made_it(bench):
    text = Page((bench / "first/report.html").read_text(encoding="utf-8")).text
    digest = hashlib.sha256((bench / "a run.csv").read_bytes()).hexdigest()
    assert "camid diagnose 'a run.csv' --simulation S.yaml --output first" in text
    assert "Simulation S.yaml" in text
    assert f"2025-06-15 15:06:40 UTC (time of the file) SHA-256 {digest}" in text
    for name, version in (("NumPy", np.__version__), ("Python", sys.version.split()[0])):
        assert f"{name} {version}" in text


def test_two_diagnoses_of_the_same_files_are_the_same_page(bench):
    first, again = ((bench / name / "report.html").read_text(encoding="utf-8") for name in ("first", "again"))
    assert first.replace("--output first", "--output again") == again


def test_the_contents_lead_to_every_section_and_the_files_are_there(bench):
    text = (bench / "first/report.html").read_text(encoding="utf-8")
    found = Page(text)
    links = [value for name, value in found.attributes if name == "href" and value]
    assert [link.removeprefix("#") for link in links if link.removeprefix("#") in found.sections] == found.sections
    files = [link for link in links if not link.startswith("#")]
    assert sorted(files) == ["diagnosis.json", "improved.yaml", "residuals.csv"]
    assert all((bench / "first" / name).is_file() for name in files)


def test_a_time_stamp_of_the_calendar_is_the_date():
    stamped = recorded_file("nowhere.csv", 1_750_000_000.5)
    assert (stamped.date, stamped.date_is) == ("2025-06-15 15:06:40 UTC", FIRST_STAMP)
    assert recorded_file("nowhere.csv", 0.0).date is None


def test_the_time_of_a_file_is_its_date_where_it_counts_from_its_start(tmp_path):
    path = tmp_path / "recording.csv"
    path.write_text("t,u,y\n")
    os.utime(path, (MODIFIED, MODIFIED))
    found = recorded_file(path, 0.0)
    assert (found.date, found.date_is) == ("2025-06-15 15:06:40 UTC", FILE_TIME)
    assert found.sha256 == hashlib.sha256(b"t,u,y\n").hexdigest()


def test_a_table_in_memory_has_neither_date_nor_hash():
    found = recorded_file(pd.DataFrame({"t": [0.0]}), 0.0)
    assert (found.name, found.sha256, found.date) == ("a table in memory (DataFrame)", None, None)


def test_hostile_names_of_files_are_text():
    provenance = written_diagnoses.PROVENANCE
    hostile = "<script>document.title = 'run'</script>"
    named = type(provenance)(hostile, hostile, [type(provenance.recordings[0])(hostile)], provenance.versions)
    found = Page(page.render(written_diagnoses.diagnosis("explained", provenance=named)))
    assert found.tags.count("script") == 1
    assert found.text.count(hostile) == 3


@pytest.fixture(scope="module")
def diagnosed():
    return diagnose(rig.recording(400), rig.simulation())


def test_the_responses_are_those_of_the_plants_as_given_and_re_estimated(diagnosed):
    responses = diagnosed.responses
    names = [curve.name for curve in responses.curves]
    assert names[:2] == ["as given", "re-estimated"]
    for curve, simulation in zip(responses.curves, (diagnosed.believed, diagnosed.refitted), strict=False):
        expected = np.abs(simulation.plant.frequency_response(curve.angular_frequency))
        assert curve.magnitude == pytest.approx(expected)
    # A band where something was estimated.
    assert responses.curves[0].relative_deviation is None
    assert np.all(responses.curves[1].relative_deviation > 0.0)
    assert "Magnitude of the plant" in page.render(diagnosed)


def test_without_an_input_there_is_no_response():
    assert "response" not in Page(page.render(written_diagnoses.diagnosis("explained"))).sections


@pytest.mark.slow
def test_the_report_does_not_wait_for_python_control(tmp_path):
    """It is an extra of its own, and takes longer to load than a diagnosis."""
    rig.recording(300).to_csv(tmp_path / "run.csv", index=False)
    rig.write_yaml(rig.simulation(), tmp_path / "S.yaml")
    program = (
        "import sys; from camid.cli import main\n"
        "code = main(['diagnose', 'run.csv', '--simulation', 'S.yaml', '--output', 'out', '--time-limit', '1'])\n"
        "sys.exit(code or 'control' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Magnitude of the plant" in (tmp_path / "out/report.html").read_text(encoding="utf-8")
