"""Draw one figure of the sealed proof."""

from importlib import import_module
from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.job_log import logged
from camid.plotting import save

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

# Table that a figure shows, where it is not the scores.
TABLES = {"weights": "weights", "run_time": "run_times"}


def main() -> None:
    """Draw one figure of the sealed proof."""
    name = snakemake.params.figure
    table = pd.read_parquet(snakemake.input[TABLES.get(name, "scores")])
    figure, plotted = import_module(f"camid.proof.figures.{name}").draw(table)
    save(figure, plotted, snakemake.output.png, snakemake.output.pdf, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
