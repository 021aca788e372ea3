"""Print the errors on the Silverbox multisine beside their references."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from camid.benchmark_recordings import SILVERBOX_TRANSIENT
from camid.experiments.log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

# Held and first-order-hold linear models on the official split: measured independently, and 6.95 mV for the best linear
# model in Champneys et al., arXiv 2405.10779.
REFERENCES = {"zoh": "14.8 ± 0.1", "foh": "7.0 ± 0.1"}


def main() -> None:
    """Print the errors on the Silverbox multisine beside their references."""
    rows = []
    for file in snakemake.input.simulated:
        hold = Path(file).stem.split("_")[1]
        table = pd.read_csv(file).iloc[SILVERBOX_TRANSIENT:]
        error = 1e3 * float(np.sqrt(np.mean((table["V2"] - table["simulated"]) ** 2)))
        rows.append(
            {"recording": "silverbox, test multisine", "hold": hold, "rmse_mV": error, "reference_mV": REFERENCES[hold]}
        )
    summary = pd.DataFrame(rows)
    print(summary.to_string(index=False, float_format="%.2f"))
    summary.to_csv(snakemake.output[0], index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
