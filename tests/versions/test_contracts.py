"""Every contract says its version; files of earlier commits are read, and what is not known is refused in one line.

``older/`` holds files as they were written: ``silverbox.yaml`` before simulations had a JSON schema; ``improved.yaml``
and ``diagnosis.json`` of the first diagnosis that an experiment could be designed from, of examples/slide.csv; datasets
before they had a version.
"""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import camid
from camid.cli import main
from camid.errors import InputError
from camid.experiment_design.sources import known_from_folder
from camid.simulation.file import load_simulation
from camid.workflow import dataset_files
from camid.workflow.dataset_files import read_arrays, read_configuration, read_dataset, write_arrays, write_dataset
from tests.support import ROOT

OLDER = Path(__file__).parent / "older"


def one_line(error):
    assert "\n" not in str(error)
    return str(error)


def test_an_older_simulation_is_read():
    loaded = load_simulation(OLDER / "silverbox.yaml")
    assert (loaded.input_column, loaded.output_column) == ("V1", "V2")
    assert loaded.initial_state == "estimate"


def test_an_older_improved_simulation_computes_what_it_did():
    """The rest that it leaves is what its diagnosis states, 0.459 % of the output's standard deviation."""
    simulated = camid.simulate(ROOT / "examples/slide.csv", OLDER / "improved.yaml")
    recorded = pd.read_csv(ROOT / "examples/slide.csv")["y"]
    rest = np.sqrt(np.mean((simulated["simulated"] - recorded) ** 2)) / recorded.std()
    assert rest == pytest.approx(0.00459, abs=1e-5)


@pytest.mark.parametrize("version", [0, 2, "1.0", True, None])
def test_a_simulation_of_a_version_that_is_not_known_is_refused(tmp_path, version):
    text = (OLDER / "silverbox.yaml").read_text(encoding="utf-8")
    path = tmp_path / "S.yaml"
    path.write_text(text.replace("schema: 1", f"schema: {json.dumps(version)}"), encoding="utf-8")
    with pytest.raises(InputError, match="this camid reads schema: 1") as caught:
        load_simulation(path)
    one_line(caught.value)


def test_a_simulation_without_a_version_is_refused(tmp_path):
    text = (OLDER / "silverbox.yaml").read_text(encoding="utf-8")
    path = tmp_path / "S.yaml"
    path.write_text(text.replace("schema: 1", ""), encoding="utf-8")
    with pytest.raises(InputError, match="'schema' is missing"):
        load_simulation(path)


def test_an_older_diagnosis_is_read():
    known = known_from_folder(OLDER)
    assert known.hypotheses[0].identifier == "stribeck-friction"
    assert known.rows > 1000


@pytest.mark.parametrize("version", [0, 2, None])
def test_a_diagnosis_of_a_version_that_is_not_known_is_refused(tmp_path, capsys, version):
    content = json.loads((OLDER / "diagnosis.json").read_text(encoding="utf-8"))
    (tmp_path / "diagnosis.json").write_text(json.dumps(content | {"schema": version}), encoding="utf-8")
    assert main(["design", str(tmp_path), "--output", str(tmp_path / "next")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"version {version} is not known; this camid reads schema: 1" in error
    assert not (tmp_path / "next").exists()


def test_older_datasets_are_read(tmp_path):
    for name in ("table.parquet", "arrays.npz"):
        shutil.copy(OLDER / name, tmp_path / name)
    assert list(read_dataset(tmp_path / "table.parquet")["k"]) == [1, 2, 3]
    assert read_configuration(tmp_path / "table.parquet") == {"seed": 3}
    assert list(read_arrays(tmp_path / "arrays.npz")) == ["image"]
    assert b"camid.schema" not in pq.read_schema(OLDER / "table.parquet").metadata


def test_a_dataset_of_a_newer_version_is_refused_and_stays(tmp_path, monkeypatch):
    table, arrays = tmp_path / "table.parquet", tmp_path / "arrays.npz"
    with monkeypatch.context() as newer:
        newer.setattr(dataset_files, "VERSION", 2)
        write_dataset(pd.DataFrame({"k": [1]}), table, {"seed": 3})
        write_arrays({"k": np.arange(3)}, arrays)
        assert list(read_arrays(arrays)) == ["k"]
    for read, path in ((read_dataset, table), (read_configuration, table), (read_arrays, arrays)):
        with pytest.raises(InputError, match="of version 2; this camid reads up to version 1") as caught:
            read(path)
        one_line(caught.value)
        assert path.exists()
