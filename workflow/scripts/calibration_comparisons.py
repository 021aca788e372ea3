"""Diagnose one shard of the recordings that the weights are calibrated with."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.calibration import comparisons_of
from camid.proof.concealed.generator import plan
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose one shard of the recordings that the weights are calibrated with."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    cases = plan(parameters.seed, parameters.number)[int(wildcards.shard) :: parameters.shards]
    rows = comparisons_of(cases)
    Path(snakemake.output[0]).write_text(json.dumps(rows), encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
