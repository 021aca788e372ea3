"""Write the parts of the Silverbox."""

from pathlib import Path
from typing import TYPE_CHECKING

from camid.real_recordings.download import silverbox_parts
from camid.workflow.job import logged
from camid.writing import write_table

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the parts of the Silverbox."""
    parts = silverbox_parts(Path(snakemake.input.recording))
    write_table(parts["training"], snakemake.output.training)
    write_table(parts["multisine"], snakemake.output.multisine)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
