"""Diagnose a span of the rigs under laws outside the catalogue, and of those with nothing missing."""

from typing import TYPE_CHECKING

from camid.proof.unlisted.campaign import campaign
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose a span of the rigs."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    table = campaign(parameters.seed, int(wildcards.first), int(wildcards.last))
    write_dataset(table, snakemake.output[0], {"seed": int(parameters.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
