"""Write the outputs of Fig. 8."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.dataset_files import write_dataset
from camid.paper.datasets import neglected_mode_outputs
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the outputs of Fig. 8."""
    plant = snakemake.params.plant
    sweep = {key: snakemake.params[key] for key in ("period", "damping", "start", "stop", "points")}
    signal = pd.read_parquet(snakemake.input.excitation)["u"].to_numpy()
    table = neglected_mode_outputs(signal, plant, sweep)
    write_dataset(table, snakemake.output[0], {"plant": plant, "neglected_mode_sweep": sweep})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
