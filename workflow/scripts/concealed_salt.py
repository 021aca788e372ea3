"""Draw the salt of the seals."""

from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.sealing import new_salt
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw the salt of the seals."""
    Path(snakemake.output[0]).write_text(new_salt() + "\n", encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
