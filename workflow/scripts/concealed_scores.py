"""Collect the scores of all shards of a set."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.proof.diagnoses import with_times_alone
from camid.workflow.dataset_files import read_dataset, write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Collect the scores of all shards of a set."""
    configuration = {"seed": int(snakemake.wildcards.seed), "recordings": snakemake.params.number}
    for name in ("scores", "parameters", "weights", "run_times"):
        read = pd.read_csv if name == "run_times" else read_dataset
        # An empty table, of a shard without a named effect, has no types of its own.
        tables = [table for table in map(read, snakemake.input[name]) if len(table)]
        table = pd.concat(tables) if tables else read(snakemake.input[name][0])
        if name == "run_times":
            table = with_times_alone(table, pd.read_csv(snakemake.input.slowest))
        write_dataset(table.sort_values("index", kind="stable"), snakemake.output[name], configuration)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
