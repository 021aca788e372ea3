"""Write the trajectory of Fig. 3."""

from typing import TYPE_CHECKING

from camid.paper.dataset_files import write_dataset
from camid.paper.job_log import logged
from camid.paper.marker_images import slow_marker_trajectory

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the trajectory of Fig. 3."""
    imaging = snakemake.params.imaging
    write_dataset(slow_marker_trajectory(imaging), snakemake.output[0], {"imaging": imaging})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
