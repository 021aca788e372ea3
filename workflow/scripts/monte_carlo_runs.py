"""Add up the shards of the Monte Carlo."""

import sys
from typing import TYPE_CHECKING

from camid.ablations.monte_carlo.runs import combine
from camid.workflow.dataset_files import read_configuration, read_dataset, write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Add up the shards of the Monte Carlo."""
    configurations = [read_configuration(file) for file in snakemake.input.shards]
    shards = [tuple(found.pop(key) for key in ("seeds", "shard", "shards")) for found in configurations]
    if len(set(shards)) < len(shards):
        sys.exit("two shards hold the same noise seeds: remove results/monte_carlo and call the workflow again")
    write_dataset(combine([read_dataset(f) for f in snakemake.input.shards]), snakemake.output[0], configurations[0])


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
