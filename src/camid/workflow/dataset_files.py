"""Datasets of the workflow: Parquet tables that carry the configuration that made them, and NPZ archives of arrays.

Each carries a checksum of its content, which is verified whenever it is read: a cache between workflows lives long, and
a flipped bit in it would change figures without a word.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from camid.errors import InputError
from camid.writing import write_whole

if TYPE_CHECKING:
    import pyarrow as pa

METADATA_KEY = b"camid"
CHECKSUM_KEY = b"camid.sha256"
CHECKSUM_ARRAY = "_sha256"
# Version of this format; files of before there was a number have none, and are read as version 1.
VERSION = 1
VERSION_KEY = b"camid.schema"
VERSION_ARRAY = "_schema"
# Added to the name of a dataset that is put aside.
DAMAGED = ".damaged"


class _DamagedError(Exception):
    """What a file holds is not what was written."""


class _NewerVersionError(InputError):
    """A file is whole, and of a version that this camid does not read."""

    def __init__(self, path: str | Path, version: str) -> None:
        hint = f"this camid reads up to version {VERSION}: update it, or name another cache"
        super().__init__(f"this dataset is of version {version}", where=str(path), hint=hint)


def write_dataset(table: pd.DataFrame, path: str | Path, configuration: Mapping[str, Any]) -> None:
    """Write a table with its generating configuration (seed included) and a checksum in the Parquet metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrow = pa.Table.from_pandas(table, preserve_index=False)
    metadata = {**(arrow.schema.metadata or {}), METADATA_KEY: json.dumps(configuration, sort_keys=True).encode()}
    metadata[VERSION_KEY] = str(VERSION).encode()
    metadata[CHECKSUM_KEY] = _checksum_of_table(arrow, metadata).encode()
    arrow = arrow.replace_schema_metadata(metadata)
    write_whole(path, lambda temporary: pq.write_table(arrow, temporary))


def write_arrays(arrays: Mapping[str, NDArray[Any]], path: str | Path) -> None:
    """Write arrays and a checksum of them as NPZ."""
    content = {name: np.asarray(array) for name, array in arrays.items()}
    content[VERSION_ARRAY] = np.array(VERSION)
    content[CHECKSUM_ARRAY] = np.array(_checksum_of_arrays(content))
    write_whole(path, lambda temporary: np.savez_compressed(temporary, allow_pickle=False, **content))


def read_dataset(path: str | Path) -> pd.DataFrame:
    """A table that :func:`write_dataset` wrote.

    Raises
    ------
    InputError
        If its content is not what was written. The file is put aside, out of the cache, too, so that the same command
        makes it anew. Also if it is of a newer version; then it stays.
    """
    try:
        return _verified_table(path).to_pandas()
    except _NewerVersionError:
        raise
    except Exception as error:  # a damaged file raises whatever the reader stumbles over
        raise _put_aside(path, error) from None


def read_arrays(path: str | Path) -> dict[str, NDArray[Any]]:
    """The arrays that :func:`write_arrays` wrote, by name.

    Raises
    ------
    InputError
        As :func:`read_dataset`.
    """
    try:
        with np.load(path) as archive:
            content = dict(archive)
        written = content.pop(CHECKSUM_ARRAY, None)
        if written is None or str(written) != _checksum_of_arrays(content):
            raise _DamagedError("its checksum is not that of its content")
        _refuse_newer(path, str(content.pop(VERSION_ARRAY, VERSION)))
        return content
    except _NewerVersionError:
        raise
    except Exception as error:
        raise _put_aside(path, error) from None


def read_configuration(path: str | Path) -> dict[str, Any]:
    """The configuration that a dataset was made with.

    Raises
    ------
    InputError
        As :func:`read_dataset`.
    """
    try:
        return dict(json.loads(_verified_table(path).schema.metadata[METADATA_KEY]))
    except _NewerVersionError:
        raise
    except Exception as error:
        raise _put_aside(path, error) from None


def _verified_table(path: str | Path) -> pa.Table:
    import pyarrow.parquet as pq

    # Of the open file: pyarrow would take the folders of a path for columns.
    with Path(path).open("rb") as stream:
        arrow = pq.read_table(stream)
    metadata = arrow.schema.metadata or {}
    checksum = _checksum_of_table(arrow, metadata)
    if metadata.get(CHECKSUM_KEY) != checksum.encode():
        raise _DamagedError("its checksum is not that of its content")
    _refuse_newer(path, metadata.get(VERSION_KEY, str(VERSION).encode()).decode())
    return arrow


def _refuse_newer(path: str | Path, version: str) -> None:
    """Refuse a whole file of a version that is not known; it stays where it is."""
    if not version.isdigit() or int(version) > VERSION:
        raise _NewerVersionError(path, version)


def _checksum_of_table(arrow: pa.Table, metadata: Mapping[bytes, bytes]) -> str:
    """SHA-256 over configuration, names, kinds and values, whatever the encoding and the chunks of the file."""
    import pyarrow as pa

    digest = hashlib.sha256()
    for key, value in sorted(metadata.items()):
        if key != CHECKSUM_KEY:  # configuration, and what pandas makes of the columns
            digest.update(repr((key, value)).encode())
    for name, column in zip(arrow.column_names, arrow.columns, strict=True):
        digest.update(json.dumps([name, str(column.type), len(column), column.null_count]).encode())
        if pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            digest.update(column.is_null().to_numpy().tobytes() if column.null_count else b"")
            digest.update(np.ascontiguousarray(column.to_numpy()).tobytes())
        else:
            digest.update(json.dumps(column.to_pylist(), default=str).encode())
    return digest.hexdigest()


def _checksum_of_arrays(arrays: Mapping[str, NDArray[Any]]) -> str:
    """SHA-256 over names, kinds, shapes and values."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(json.dumps([name, array.dtype.str, array.shape]).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _put_aside(path: str | Path, error: Exception) -> Exception:
    """The error for a damaged dataset, which keeps its bytes under another name; a link to it is removed.

    What the system says (no such file, no right to read) is passed on, and the file stays.
    """
    # An invalid argument is a place beyond the file's ends, to which damaged bytes lead.
    if isinstance(error, OSError) and error.errno not in {None, errno.EINVAL}:
        return error
    target = Path(os.path.realpath(path))
    aside = target.with_name(target.name + DAMAGED)
    with suppress(FileNotFoundError):  # another job came across it at the same time
        target.replace(aside)
        if Path(path).is_symlink():
            Path(path).unlink()
    detail = str(error) if isinstance(error, _DamagedError) else " ".join(str(error).split()) or type(error).__name__
    return InputError(
        f"this dataset is damaged: {detail}",
        where=str(path),
        hint=f"it was put aside as {aside}; give the same command again, and it is made anew",
    )
