"""Write the camera-sampled outputs of Fig. 7."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.datasets import sampling_period_outputs
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the camera-sampled outputs of Fig. 7."""
    plant, sweep = snakemake.params.plant, {key: snakemake.params[key] for key in ("start", "stop", "step")}
    signal = pd.read_parquet(snakemake.input.excitation)["u"].to_numpy()
    table = sampling_period_outputs(signal, plant, sweep)
    write_dataset(table, snakemake.output[0], {"plant": plant, "sampling_period_sweep": sweep})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
