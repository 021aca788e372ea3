"""Write the excitation."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid.chain.excitation import pseudo_random_binary_sequence
from camid.paper.dataset_files import write_dataset
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the excitation."""
    configuration = snakemake.params.excitation
    signal = pseudo_random_binary_sequence(configuration["order"], amplitude=configuration["amplitude"])
    table = pd.DataFrame({"k": np.arange(len(signal)), "u": signal})
    write_dataset(table, snakemake.output[0], {"excitation": configuration})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
