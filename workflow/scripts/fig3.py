"""Draw Fig. 3."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.fig3_marker_trajectory.drawing import draw
from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw Fig. 3."""
    figure, table = draw(pd.read_parquet(snakemake.input.trajectory), snakemake.params.frequency)
    save(figure, table, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
