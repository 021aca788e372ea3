"""Diagnose one shard of concealed recordings blindly."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.proof.diagnoses import diagnose_all
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose one shard of concealed recordings blindly."""
    diagnoses = Path(snakemake.output.diagnoses)
    diagnoses.mkdir(parents=True, exist_ok=True)
    indices = pd.read_csv(snakemake.input.seals)["index"].tolist()
    run_times = diagnose_all(indices, Path(snakemake.input.recordings), diagnoses)
    run_times.to_csv(snakemake.output.run_times, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
