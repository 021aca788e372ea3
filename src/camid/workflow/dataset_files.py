"""Parquet tables that carry the configuration that made them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from camid.writing import write_whole

METADATA_KEY = b"camid"


def write_dataset(table: pd.DataFrame, path: str | Path, configuration: Mapping[str, Any]) -> None:
    """Write a table with its generating configuration (seed included) in the Parquet metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrow = pa.Table.from_pandas(table, preserve_index=False)
    metadata = {**(arrow.schema.metadata or {}), METADATA_KEY: json.dumps(configuration, sort_keys=True).encode()}
    arrow = arrow.replace_schema_metadata(metadata)
    write_whole(path, lambda temporary: pq.write_table(arrow, temporary))


def read_configuration(path: str | Path) -> dict[str, Any]:
    """The configuration that a dataset was made with."""
    import pyarrow.parquet as pq

    return dict(json.loads(pq.read_schema(path).metadata[METADATA_KEY]))
