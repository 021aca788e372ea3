"""Draw Fig. 1."""

from typing import TYPE_CHECKING

import numpy as np

from camid.paper.fig1_marker_image.drawing import draw
from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw Fig. 1."""
    with np.load(snakemake.input.image) as image:
        figure, table = draw(image["quantised"], image["trajectory"])
    save(figure, table, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
