"""Diagnose one shard of the rigs, and those that stay open again with a designed and with a repeated experiment."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.designed_experiment.campaign import campaign
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose one shard of the rigs."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    share = int(wildcards.shard), int(wildcards.shards)
    with tempfile.TemporaryDirectory() as folder:
        table = campaign(parameters.seed, parameters.rigs, *share, Path(folder))
    write_dataset(table, snakemake.output[0], {"seed": int(parameters.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
