"""Datasets carry a checksum, and whatever is not what was written is noticed and put aside."""

import random

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from camid.errors import InputError
from camid.workflow.dataset_files import (
    DAMAGED,
    read_arrays,
    read_configuration,
    read_dataset,
    write_arrays,
    write_dataset,
)

TABLE = pd.DataFrame({"k": [1, 2, 3], "u": [0.5, np.nan, -0.0], "name": ["a", None, "ü"], "good": [True, False, True]})
ARRAYS = {"image": np.arange(12.0).reshape(3, 4), "chosen": np.array([True, False])}


@pytest.fixture
def table(tmp_path):
    write_dataset(TABLE, tmp_path / "table.parquet", {"seed": 3})
    return tmp_path / "table.parquet"


@pytest.fixture
def arrays(tmp_path):
    write_arrays(ARRAYS, tmp_path / "arrays.npz")
    return tmp_path / "arrays.npz"


def test_what_is_whole_is_read(table, arrays):
    pd.testing.assert_frame_equal(read_dataset(table), TABLE)
    assert read_configuration(table) == {"seed": 3}
    found = read_arrays(arrays)
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(found[name], array)


@pytest.mark.parametrize("seed", range(30))
def test_a_cut_is_noticed_and_the_file_put_aside(table, arrays, seed):
    for path, read in ((table, read_dataset), (arrays, read_arrays)):
        data = path.read_bytes()[: random.Random(seed).randrange(path.stat().st_size)]
        path.write_bytes(data)
        with pytest.raises(InputError, match="this dataset is damaged"):
            read(path)
        assert not path.exists()
        assert path.with_name(path.name + DAMAGED).read_bytes() == data


@pytest.mark.parametrize("seed", [*range(60), 69, 158])
def test_a_flipped_bit_is_noticed_or_changes_no_value(table, arrays, seed):
    for path, read, same in (
        (table, read_dataset, TABLE.equals),
        (arrays, read_arrays, lambda found: all(np.array_equal(found[n], a) for n, a in ARRAYS.items())),
    ):
        data = bytearray(path.read_bytes())
        place = random.Random(seed).randrange(8 * len(data))
        data[place // 8] ^= 1 << place % 8
        path.write_bytes(data)
        try:
            found = read(path)
        except InputError:
            assert not path.exists()
            assert path.with_name(path.name + DAMAGED).read_bytes() == data
        else:
            assert same(found)


def test_another_value_under_the_old_checksum_is_noticed(table):
    written = pq.read_table(table)
    changed = written.set_column(0, "k", [[1, 2, 4]]).replace_schema_metadata(written.schema.metadata)
    pq.write_table(changed, table)
    with pytest.raises(InputError, match="its checksum is not that of its content"):
        read_dataset(table)


def test_a_table_without_a_checksum_is_none_of_ours(tmp_path):
    TABLE.to_parquet(tmp_path / "foreign.parquet")
    with pytest.raises(InputError, match="this dataset is damaged"):
        read_configuration(tmp_path / "foreign.parquet")


def test_a_link_into_a_cache_is_removed_with_what_it_leads_to(table, tmp_path):
    link = tmp_path / "results.parquet"
    link.symlink_to(table)
    table.write_bytes(b"PAR1")
    with pytest.raises(InputError):
        read_dataset(link)
    assert not link.is_symlink()
    assert not table.exists()


def test_what_the_system_refuses_is_left_alone(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_dataset(tmp_path / "none.parquet")
    (tmp_path / "folder.parquet").mkdir()
    with pytest.raises(IsADirectoryError):
        read_dataset(tmp_path / "folder.parquet")
    assert (tmp_path / "folder.parquet").is_dir()
