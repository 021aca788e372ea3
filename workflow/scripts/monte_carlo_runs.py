"""Add up the shards of the Monte Carlo."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.experiments.ablations.monte_carlo import combine
from camid.experiments.log import logged
from camid.experiments.tables import read_configuration, write_dataset

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Add up the shards of the Monte Carlo."""
    configuration = {k: v for k, v in read_configuration(snakemake.input.shards[0]).items() if k != "seeds"}
    write_dataset(combine([pd.read_parquet(f) for f in snakemake.input.shards]), snakemake.output[0], configuration)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
