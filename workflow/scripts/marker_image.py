"""Write what Figs. 1 and 2 show."""

from typing import TYPE_CHECKING

import numpy as np

from camid.paper.job_log import logged
from camid.paper.marker_images import fast_marker_image

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write what Figs. 1 and 2 show."""
    np.savez_compressed(snakemake.output[0], allow_pickle=False, **fast_marker_image(snakemake.params.imaging))


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
