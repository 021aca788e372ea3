"""Compute one ablation; its folder in camid.ablations says what it is about."""

from importlib import import_module
from typing import TYPE_CHECKING

from camid.paper.dataset_files import write_dataset
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Compute one ablation."""
    name, settings, shared = snakemake.params.ablation, snakemake.params.settings, snakemake.params.shared
    table = import_module(f"camid.ablations.{name}.runs").compute(settings, shared)
    write_dataset(table, snakemake.output[0], {**shared, name: settings})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
