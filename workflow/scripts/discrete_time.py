"""Write the coefficients of section 3.1 from four sources."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.discrete_time import compare_discrete_time
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the coefficients of section 3.1 from four sources."""
    plant, periods = snakemake.params.plant, snakemake.params.periods
    signal = pd.read_parquet(snakemake.input.excitation)["u"].to_numpy()
    table = compare_discrete_time(signal, plant, periods)
    write_dataset(table, snakemake.output[0], {"plant": plant, "discrete_time": {"periods": periods}})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
