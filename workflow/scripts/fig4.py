"""Draw Fig. 4."""

from typing import TYPE_CHECKING

from camid.paper.block_diagrams import draw_first_version
from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw Fig. 4."""
    figure, table = draw_first_version()
    save(figure, table, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
