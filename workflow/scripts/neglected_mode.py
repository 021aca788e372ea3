"""Identify with a neglected mode at every ω1 of Fig. 8."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.fig8_neglected_mode.runs import identify_neglected_mode
from camid.paper.job_log import logged

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
