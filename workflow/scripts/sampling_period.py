"""Identify in every case at every sampling period of Fig. 7."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.fig7_sampling_period.runs import identify_sampling_period
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Identify in every case at every sampling period of Fig. 7."""
    plant, sweep = snakemake.params.plant, snakemake.params.sweep
    outputs, noise = pd.read_parquet(snakemake.input.outputs), pd.read_parquet(snakemake.input.noise)
    table = identify_sampling_period(outputs, noise, plant, sweep, sweep["cases"])
    write_dataset(table, snakemake.output[0], {"plant": plant, "sampling_period_sweep": sweep})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
