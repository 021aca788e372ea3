"""Draw one figure: call the rule's function with the rule's inputs and parameters by name."""

from typing import TYPE_CHECKING

from camid.plotting import save
from camid.workflow.job import arguments, function_of, logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw and save the figure and the numbers that it shows."""
    figure, table = function_of(snakemake)(**arguments(snakemake))
    save(figure, table, snakemake.output.png, snakemake.output.csv, snakemake.output.get("pdf"))


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
