"""Diagnose one shard of the recordings that the weights are calibrated with."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.calibration import comparisons_of, comparisons_of_two
from camid.proof.concealed.generator import plan
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Diagnose one shard of the recordings that the weights are calibrated with."""
    wildcards, parameters = snakemake.wildcards, snakemake.params
    cases = plan(parameters.seed, parameters.number)
    if wildcards.recordings == "two":
        # Where nothing is concealed, nothing is named, and nothing is learned of what names are worth.
        cases = [case for case in cases if case.kind != "none"][: parameters.second]
    shared = cases[int(wildcards.shard) :: int(wildcards.shards)]
    rows = comparisons_of_two(shared) if wildcards.recordings == "two" else comparisons_of(shared)
    Path(snakemake.output[0]).write_text(json.dumps(rows), encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
