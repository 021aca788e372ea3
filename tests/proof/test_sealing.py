"""Seals: they reproduce, and nothing that was sealed can be altered unnoticed."""

import pandas as pd
import pytest

from camid.proof.diagnoses import Worker, diagnose_all, timed_alone, with_times_alone
from camid.proof.sealing import BrokenSealError, canonical, check_seal, new_salt, seal


@pytest.fixture
def files(tmp_path):
    paths = [tmp_path / name for name in ("recording.csv", "same_kind.csv")]
    for number, path in enumerate(paths):
        path.write_text(f"t,u,y\n0,1,{number}\n", encoding="utf-8")
    return paths


TRUTH = {"kind": "single", "effects": [{"id": "delay", "multiple": 3.5}], "noise_std": 0.1 + 0.2}


def test_seal_reproduces_whatever_the_order_of_the_keys(files):
    salt = new_salt()
    turned = dict(reversed(TRUTH.items()))
    assert list(turned) != list(TRUTH)
    assert seal(salt, TRUTH, files) == seal(salt, turned, files)
    check_seal(3, seal(salt, TRUTH, files), salt, turned, files)


def test_seal_is_the_digest_that_anybody_can_compute():
    import hashlib

    empty = hashlib.sha256()
    expected = hashlib.sha256(bytes.fromhex("ab" * 32) + b'{"kind":"none"}' + empty.digest()).hexdigest()
    assert seal("ab" * 32, {"kind": "none"}, []) == expected


def test_salts_differ_and_have_256_bits():
    salts = {new_salt() for _ in range(5)}
    assert len(salts) == 5
    assert {len(bytes.fromhex(s)) for s in salts} == {32}


def test_altered_truth_is_refused_with_its_index(files):
    salt = new_salt()
    published = seal(salt, TRUTH, files)
    altered = {**TRUTH, "effects": [{"id": "exposure", "multiple": 3.5}]}
    with pytest.raises(BrokenSealError, match="recording 17 "):
        check_seal(17, published, salt, altered, files)


@pytest.mark.parametrize("change", ["byte", "name", "order", "salt", "moved byte"])
def test_altered_files_and_salt_are_refused(files, change):
    salt = new_salt()
    published = seal(salt, TRUTH, files)
    if change == "byte":
        files[1].write_text(files[1].read_text(encoding="utf-8").replace("1", "2"), encoding="utf-8")
    elif change == "name":
        files[1] = files[1].rename(files[1].with_name("double_amplitude.csv"))
    elif change == "order":
        files.reverse()
    elif change == "salt":
        salt = new_salt()
    else:
        first = files[0].read_bytes()
        files[0].write_bytes(first[:-1])
        files[1].write_bytes(first[-1:] + files[1].read_bytes())
    with pytest.raises(BrokenSealError):
        check_seal(0, published, salt, TRUTH, files)


def test_truth_with_an_infinite_number_is_refused():
    with pytest.raises(ValueError, match="JSON"):
        canonical({"multiple": float("inf")})


SIMULATION = """\
schema: 1
time: {column: t}
input: {column: u, hold: zoh}
plant:
  transfer_function: {numerator: [100.0], denominator: [1.0, 2.0, 100.0]}
sensor: {column: y, kind: camera, exposure: 0.02, latency: 0.0}
effects: []
"""


@pytest.fixture
def working_copy(tmp_path):
    """A folder with a recording and its simulation in results/, beside a truth."""
    import numpy as np
    import pandas as pd
    from scipy.signal import cont2discrete, lfilter

    generator = np.random.default_rng(3)
    folder = tmp_path / "copy/results/0"
    folder.mkdir(parents=True)
    signal, noise = generator.standard_normal((2, 300))
    numerator, denominator, _ = cont2discrete(([100.0], [1.0, 2.0, 100.0]), 0.02)
    output = lfilter(numerator.ravel(), denominator, signal) + 0.05 * noise
    pd.DataFrame({"t": 0.02 * np.arange(300), "u": signal, "y": output}).to_csv(folder / "recording.csv", index=False)
    (folder / "simulation.yaml").write_text(SIMULATION, encoding="utf-8")
    return tmp_path / "copy"


def test_process_that_diagnoses_is_refused_every_file_of_the_working_copy(working_copy, tmp_path):
    """Shown with a command that does open what it is told to open."""
    source = working_copy / "results/0"
    alone = tmp_path / "alone"
    alone.mkdir()
    for name in ("recording.csv", "simulation.yaml"):
        (alone / name).write_bytes((source / name).read_bytes())
    (alone / "link.csv").symlink_to(source / "recording.csv")
    with Worker(working_copy) as worker:
        fair = ["simulate", "recording.csv", "--simulation", "simulation.yaml", "--output", "simulated.csv"]
        answer = worker.run(alone, fair)
        assert (answer["code"], answer["forbidden"]) == (0, [])
        assert (alone / "simulated.csv").is_file()
        for recording in (str(source / "recording.csv"), "link.csv"):
            answer = worker.run(alone, [fair[0], recording, *fair[2:]])
            assert answer["code"] != 0
            assert answer["forbidden"] == [str((source / "recording.csv").resolve())]
        assert worker.run(alone, fair)["forbidden"] == []


def test_failed_diagnosis_is_written_down_and_does_not_stop_the_others(working_copy, tmp_path, monkeypatch):
    monkeypatch.chdir(working_copy)
    (working_copy / "results/1").mkdir()
    for name in ("recording.csv", "simulation.yaml"):
        (working_copy / "results/1" / name).write_text("no such column\n1\n", encoding="utf-8")
    run_times = diagnose_all([1, 0], working_copy / "results", tmp_path / "diagnoses")
    assert run_times["index"].tolist() == [1, 0]
    assert (run_times["seconds"] > 0.0).all()
    assert "exit code 2" in (tmp_path / "diagnoses/1/failure.txt").read_text(encoding="utf-8")
    assert (tmp_path / "diagnoses/0").is_dir()


def test_slow_diagnoses_are_timed_again_and_say_the_same(working_copy, tmp_path, monkeypatch):
    monkeypatch.chdir(working_copy)
    recordings, diagnoses = working_copy / "results", tmp_path / "diagnoses"
    run_times = diagnose_all([0], recordings, diagnoses)
    assert timed_alone(run_times.assign(seconds=0.01), recordings, diagnoses).empty
    run_times = pd.concat([run_times.assign(seconds=99.0), pd.DataFrame({"index": [1], "seconds": [0.5]})])
    alone = timed_alone(run_times, recordings, diagnoses)
    assert alone["index"].tolist() == [0]
    seconds = with_times_alone(run_times, alone).set_index("index")["seconds"]
    assert seconds[0] == alone["seconds"].iloc[0] < 99.0
    assert seconds[1] == 0.5

    improved = diagnoses / "0/improved.yaml"
    improved.write_text(improved.read_text(encoding="utf-8") + "# another answer\n", encoding="utf-8")
    with pytest.raises(ValueError, match="recording 0 says something else"):
        timed_alone(run_times, recordings, diagnoses)


def test_temporary_folder_in_the_working_copy_is_refused(working_copy, tmp_path, monkeypatch):
    monkeypatch.chdir(working_copy)
    monkeypatch.setattr("tempfile.tempdir", str(working_copy / "results"))
    with pytest.raises(ValueError, match="TMPDIR"):
        diagnose_all([0], working_copy / "results", tmp_path / "diagnoses")
