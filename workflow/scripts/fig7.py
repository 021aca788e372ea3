"""Draw Fig. 7."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.fig7_sampling_period.drawing import draw
from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw Fig. 7."""
    cases = {"camera": "camera", "held": "zoh", "noise": "camera-noise"}
    figure, table = draw(pd.read_parquet(snakemake.input.estimates), snakemake.params.natural_frequency, cases)
    save(figure, table, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
