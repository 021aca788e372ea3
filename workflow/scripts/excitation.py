"""Write the excitation."""

from typing import TYPE_CHECKING

from camid.experiments.datasets import excitation
from camid.experiments.log import logged
from camid.experiments.tables import write_dataset

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the excitation."""
    configuration = snakemake.params.excitation
    write_dataset(excitation(configuration), snakemake.output[0], {"excitation": configuration})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
