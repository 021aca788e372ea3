"""Identify with a neglected mode at every ω1 of Fig. 8."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.experiments.log import logged
from camid.experiments.neglected_mode import identify_neglected_mode
from camid.experiments.tables import write_dataset

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Identify with a neglected mode at every ω1 of Fig. 8."""
    plant, sweep = snakemake.params.plant, snakemake.params.sweep
    table = identify_neglected_mode(pd.read_parquet(snakemake.input.outputs), plant, sweep, sweep["cases"])
    write_dataset(table, snakemake.output[0], {"plant": plant, "neglected_mode_sweep": sweep})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
