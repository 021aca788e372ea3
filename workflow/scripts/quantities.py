"""Collect the numbers that are quoted and guarded."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.job_log import logged
from camid.paper.quantities import all_quantities

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Collect the numbers that are quoted and guarded."""
    names = [name for name, _ in snakemake.input.items() if name != "sources"]
    files = {name: Path(snakemake.input[name]) for name in names}
    tables = {n: pd.read_csv(f) if f.suffix == ".csv" else pd.read_parquet(f) for n, f in files.items()}
    table = all_quantities(tables, {"plant": snakemake.params.plant})
    table.to_csv(snakemake.output[0], index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
