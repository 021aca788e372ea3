"""Diagnose a real recording from several of its rows on."""

from typing import TYPE_CHECKING

from camid.real_recordings.starts import names_by_first_row
from camid.workflow.job import logged
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose from every start and write the names."""
    files = snakemake.input
    table = names_by_first_row(files.recording, files.simulation, snakemake.params.starts)
    print(table.to_string(index=False))
    write_whole(snakemake.output[0], lambda path: table.to_csv(path, index=False, lineterminator="\n"))


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
