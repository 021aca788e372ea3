"""Find a real recording and link to it, so that no copy of it is made."""

from pathlib import Path
from typing import TYPE_CHECKING

from camid.real_recordings.download import fetch
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Find a real recording and link to it."""
    link = Path(snakemake.output[0])
    link.unlink(missing_ok=True)
    link.symlink_to(fetch(snakemake.params.name).resolve())


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
