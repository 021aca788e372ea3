"""Estimate the constants of one shard of the physical rigs."""

from typing import TYPE_CHECKING

from camid.proof.physical_rigs.campaign import campaign
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Estimate the constants of one shard of the physical rigs."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    tables = campaign(parameters.seed, parameters.seeds, int(wildcards.shard), int(wildcards.shards))
    for name, table in zip(("estimates", "undetermined"), tables, strict=True):
        write_dataset(table, snakemake.output[name], {"seed": int(parameters.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
