"""Draw Fig. 6."""

from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.fig6_camera_models.drawing import draw
from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw Fig. 6."""
    figure, table = draw(pd.read_parquet(snakemake.input.responses), snakemake.params.period)
    save(figure, table, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
