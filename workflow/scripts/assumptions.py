"""Write what happens when the assumptions fail."""

from typing import TYPE_CHECKING

from camid.paper.dataset_files import write_dataset
from camid.paper.job_log import logged
from camid.paper.marker_images import assumption_failures

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write what happens when the assumptions fail."""
    imaging = snakemake.params.imaging
    write_dataset(assumption_failures(imaging), snakemake.output[0], {"imaging": imaging})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
