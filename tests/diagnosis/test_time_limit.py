"""A diagnosis ends in time: with the best answer until then, and with words for what it left out."""

import json

import pytest

import camid
from camid.cli import main
from camid.diagnosis.watch import Watch
from tests.support.mass_on_spring import effect, record, simulation


@pytest.fixture(scope="module")
def recording():
    return record(effect("coulomb-friction", force=0.2), count=400)


def test_what_there_was_no_time_for_is_said(recording):
    diagnosis = camid.diagnose(recording, simulation(), time_limit=1e-9)
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.findings == []
    (warning,) = diagnosis.warnings
    assert warning.startswith("the time limit of 1e-09 s was reached")
    assert "not tried: effects of the catalogue" in warning


def test_the_effect_that_was_found_until_then_is_kept(recording, monkeypatch):
    asked = []

    def no_time_for(watch, part):
        asked.append(part)
        late = part.startswith("effects in addition")
        if late:
            watch.left_out.append(part)
        return late

    monkeypatch.setattr(Watch, "no_time_for", no_time_for)
    diagnosis = camid.diagnose(recording, simulation(), time_limit=100.0)
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert "not tried: effects in addition to coulomb-friction; see --time-limit" in diagnosis.warnings[0]
    assert "effects of the catalogue" in asked


def test_without_a_limit_nothing_is_left_out(recording):
    assert camid.diagnose(recording, simulation(), time_limit=None).warnings == []


def test_the_command_warns_and_writes(recording, tmp_path, capsys):
    recording.to_csv(tmp_path / "rig.csv", index=False)
    (tmp_path / "rig.yaml").write_text(json.dumps(simulation()), encoding="utf-8")
    arguments = [str(tmp_path / "rig.csv"), "--simulation", str(tmp_path / "rig.yaml"), "--output", str(tmp_path / "d")]
    assert main(["diagnose", *arguments, "--no-report", "--time-limit", "1e-9"]) == 0
    assert "not tried: effects of the catalogue" in " ".join(capsys.readouterr().err.split())
    assert json.loads((tmp_path / "d/diagnosis.json").read_text(encoding="utf-8"))["verdict"] == "unexplained"
