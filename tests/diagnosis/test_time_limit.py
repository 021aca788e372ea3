"""A diagnosis ends in time: with the best answer until then, and with words for what it left out."""

import json

import pytest

import camid
from camid.cli import main
from camid.diagnosis.watch import LAWS, OVERTIME, WORK, WORK_OF_ROW, Watch
from camid.engine.work import ROW, RUN, Work
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
    asked, in_time = [], Watch.no_time_for

    def no_time_for(watch, part, **needed):
        asked.append(part)
        if part.startswith("effects in addition"):
            watch.limit = 0.0
        late = in_time(watch, part, **needed)
        watch.limit = 100.0
        return late

    monkeypatch.setattr(Watch, "no_time_for", no_time_for)
    diagnosis = camid.diagnose(recording, simulation(), time_limit=100.0)
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    assert "not tried: effects in addition to coulomb-friction; see --time-limit" in diagnosis.warnings[0]
    assert "effects of the catalogue" in asked


def test_without_a_limit_nothing_is_left_out(recording):
    assert camid.diagnose(recording, simulation(), time_limit=None, effort=None).warnings == []


def test_an_effort_leaves_out_the_same_on_every_machine(recording):
    first, again = (camid.diagnose(recording, simulation(), time_limit=None, effort=0.03) for _ in range(2))
    assert first.verdict in ("explained", "partly-explained", "unexplained")
    (warning,) = first.warnings
    assert warning.startswith("as much was simulated as an effort of 0.03 allows")
    assert "see --effort" in warning
    assert without_time(again) == without_time(first)


def test_what_is_likeliest_beside_an_effect_is_fitted_whatever_is_done():
    both = effect("coulomb-friction", force=0.2), effect("sensor-drift", rate=0.02)
    diagnosis = camid.diagnose(record(*both), simulation(), time_limit=None, effort=0.02)
    assert {f.identifier for f in diagnosis.findings} == {"coulomb-friction", "sensor-drift"}
    (warning,) = diagnosis.warnings
    assert "all but the likeliest effects in addition to coulomb-friction" in warning


def test_of_many_effects_it_is_said_how_many():
    watch = Watch(effort=1.0)
    for part in ("hysteresis", "other starts of delay", "perspective", "other starts of cogging", "finer laws"):
        watch.leave_out(part)
    assert (
        "not tried: hysteresis and perspective, other starts of delay and cogging, finer laws; see" in watch.warning()
    )
    for part in ("other starts of overflow", "end-stop"):
        watch.leave_out(part)
    assert "not tried: 3 less likely effects, other starts of 3 effects, finer laws; see --effort" in watch.warning()


def without_time(diagnosis):
    """diagnosis.json, but for how long it took."""
    return {name: value for name, value in diagnosis.to_mapping().items() if name not in ("seconds", "provenance")}


def test_an_effort_bounds_what_is_simulated():
    watch, work = Watch(effort=2.0), Work()
    watch.count(work, 1000)
    runs = int(2.0 * (WORK + 1000 * WORK_OF_ROW) / ((RUN + 1000 * ROW) * 1e-6)) - 1
    for _ in range(runs):
        work.add_run(1000)
    watch.take_stock()
    assert not watch.no_time_for("the last part")
    for _ in range(2):
        work.add_run(1000)
    # It is over where it is looked at, and not in the middle of what threads share.
    assert not watch.no_time_for("the last part")
    watch.take_stock()
    assert watch.no_time_for("the last part")
    assert watch.left_out == ["the last part"]


def test_the_command_warns_and_writes(recording, tmp_path, capsys):
    recording.to_csv(tmp_path / "rig.csv", index=False)
    (tmp_path / "rig.yaml").write_text(json.dumps(simulation()), encoding="utf-8")
    arguments = [str(tmp_path / "rig.csv"), "--simulation", str(tmp_path / "rig.yaml"), "--output", str(tmp_path / "d")]
    assert main(["diagnose", *arguments, "--no-report", "--time-limit", "1e-9"]) == 0
    assert "not tried: effects of the catalogue" in " ".join(capsys.readouterr().err.split())
    assert json.loads((tmp_path / "d/diagnosis.json").read_text(encoding="utf-8"))["verdict"] == "unexplained"


def test_what_is_ahead_counts_as_done():
    work, watch = Work(), Watch(effort=1.0)
    watch.count(work, 0)
    work.add_run(0)
    watch.take_stock(LAWS, 0.5 * WORK)
    assert not watch.no_time_for("a second law")
    watch.take_stock(LAWS, WORK)
    assert watch.no_time_for("a second law")
    watch.take_stock(LAWS)
    assert not watch.no_time_for("what costs nothing")


def test_what_is_left_of_the_effort_is_shared_out():
    work, watch = Work(), Watch(effort=1.0)
    assert watch.allowance(3) == float("inf")
    watch.count(work, 0)
    work.add_run(0)
    assert watch.allowance(2) == pytest.approx(0.5 * (OVERTIME * WORK - RUN * 1e-6))
    while work.seconds < 2.0 * OVERTIME * WORK:
        work.add(work.state())
    assert watch.allowance(2) == 0.0
    unbounded = Watch(effort=None)
    unbounded.count(work, 0)
    assert unbounded.allowance(3) == float("inf")


def test_a_search_in_more_recordings_ends_no_sooner():
    """Each fit takes longer there."""
    work = Work()
    work.add_run(0)
    one, two = Watch(effort=1.0), Watch(effort=1.0)
    one.count(work, 1000)
    two.count(work, 1000, 2)
    assert two.allowance(1) - one.allowance(1) == pytest.approx(OVERTIME * WORK)
