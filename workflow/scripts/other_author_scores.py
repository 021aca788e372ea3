"""Make, diagnose and score one shard of another author's recordings."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.other_authors import diagnose_and_score
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Make, diagnose and score one shard of another author's recordings."""
    wildcards, number = snakemake.wildcards, snakemake.params.number
    indices = list(range(int(wildcards.shard), number, int(wildcards.shards)))
    with tempfile.TemporaryDirectory() as folder:
        tables = diagnose_and_score(wildcards.author, indices, int(wildcards.seed), number, Path(folder))
    for name, table in zip(("scores", "parameters", "weights"), tables, strict=True):
        write_dataset(table, snakemake.output[name], {"seed": int(wildcards.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
