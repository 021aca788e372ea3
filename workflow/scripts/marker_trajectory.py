"""Write the trajectory of Fig. 3."""

from typing import TYPE_CHECKING

from camid.experiments.log import logged
from camid.experiments.marker_images import slow_marker_trajectory
from camid.experiments.tables import write_dataset

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the trajectory of Fig. 3."""
    imaging = snakemake.params.imaging
    write_dataset(slow_marker_trajectory(imaging), snakemake.output[0], {"imaging": imaging})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
