"""Estimate the constants of the weights, and write how reliable they make them."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from camid.diagnosis.weights import Comparison
from camid.proof.calibration import calibrate, outside_stated_and_true, read_comparisons, stated_and_true
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Estimate the constants of the weights, and write how reliable they make them."""
    comparisons = [*_read(snakemake.input.one), *_read(snakemake.input.two)]
    constants = calibrate(comparisons)
    content = {
        "seed": snakemake.params.seed,
        "recordings": snakemake.params.number,
        "comparisons": len(comparisons),
        "constants": {name: float(f"{value:.3g}") for name, value in asdict(constants).items()},
    }
    Path(snakemake.output.constants).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    table = stated_and_true(comparisons, constants)
    table.to_csv(snakemake.output.reliability, index=False, lineterminator="\n", float_format="%.4g")
    print(table.to_string())
    table = outside_stated_and_true(comparisons, constants)
    table.to_csv(snakemake.output.outside, index=False, lineterminator="\n", float_format="%.4g")
    print(table.to_string())


def _read(files: Iterable[str]) -> list[tuple[Comparison, set[str]]]:
    """The comparisons of some shards."""
    return read_comparisons(row for file in files for row in json.loads(Path(file).read_text(encoding="utf-8")))


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
