"""A folder in which commands run."""

import pytest

from tests.support import linear_rig as rig


@pytest.fixture(scope="module")
def film():
    return rig.recording().to_csv(index=False)


@pytest.fixture
def bench(film, tmp_path, monkeypatch):
    """A folder with a recording and the simulation that fits it, and the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recording.csv").write_text(film)
    rig.write_yaml(rig.simulation(), tmp_path / "S.yaml")
    return tmp_path
