"""Diagnose a real recording from several nominal plants."""

from typing import TYPE_CHECKING

from camid.real_recordings.starts import first_names
from camid.workflow.job import logged
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose from every start and write the names."""
    files, params = snakemake.input, snakemake.params
    table = first_names(files.recording, files.simulation, params.draws, params.seed)
    print(table.to_string(index=False))
    write_whole(snakemake.output[0], lambda path: table.to_csv(path, index=False, lineterminator="\n"))


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
