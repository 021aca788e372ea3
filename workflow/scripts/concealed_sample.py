"""Draw the small sample of the sealed proof and state its numbers."""

from typing import TYPE_CHECKING

from camid.plotting import save
from camid.proof.figures.sample import draw
from camid.proof.targets import lines, quantities
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw the small sample of the sealed proof and state its numbers."""
    scores, parameters = (read_dataset(snakemake.input[name]) for name in ("scores", "parameters"))
    figure, plotted = draw(scores)
    save(figure, plotted, snakemake.output.png, snakemake.output.csv)
    table = quantities(lines(scores, parameters), "concealed_sample")
    table.to_csv(snakemake.output.quantities, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
