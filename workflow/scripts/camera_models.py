"""Write the frequency responses of Fig. 6."""

from typing import TYPE_CHECKING

from camid.paper.dataset_files import write_dataset
from camid.paper.fig6_camera_models.runs import camera_model_responses
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the frequency responses of Fig. 6."""
    configuration = snakemake.params.camera_models
    write_dataset(camera_model_responses(configuration), snakemake.output[0], {"camera_models": configuration})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
