"""Time the slowest diagnoses of a set again, one at a time, where it is asked how long they take."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.proof.diagnoses import timed_alone
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Time the slowest diagnoses of a set again, one at a time."""
    shards = zip(snakemake.input.run_times, snakemake.input.recordings, snakemake.input.diagnoses, strict=True)
    parts = [
        timed_alone(read, Path(recordings), Path(diagnoses)) if snakemake.params.asked else read.iloc[:0]
        for read, recordings, diagnoses in ((pd.read_csv(times), *folders) for times, *folders in shards)
    ]
    pd.concat(parts).to_csv(snakemake.output[0], index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
