"""Make, diagnose and score one shard of the second author's recordings."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.second_table import diagnose_and_score
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Make, diagnose and score one shard of the second author's recordings."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    indices = list(range(int(wildcards.shard), parameters.number, int(wildcards.shards)))
    with tempfile.TemporaryDirectory() as folder:
        tables = diagnose_and_score(indices, parameters.seed, parameters.number, Path(folder))
    for name, table in zip(("scores", "parameters", "weights"), tables, strict=True):
        write_dataset(table, snakemake.output[name], {"seed": int(parameters.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
