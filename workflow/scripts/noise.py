"""Write the noise samples of Fig. 7."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.datasets import noise_samples, with_closing_frame
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the noise samples of Fig. 7."""
    sweep = {key: snakemake.params[key] for key in ("start", "stop", "step", "noise_samples")}
    length = len(with_closing_frame(pd.read_parquet(snakemake.input.excitation)["u"].to_numpy()))
    table = noise_samples(length, sweep, snakemake.params.seed)
    write_dataset(table, snakemake.output[0], {"seed": snakemake.params.seed, "sampling_period_sweep": sweep})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
