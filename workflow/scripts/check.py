"""Compare the results with the stored tolerances; a failure ends the workflow with an error."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
from jsonschema import validate
from ruamel.yaml import YAML

from camid.workflow.job import logged
from camid.workflow.tolerances import compare, print_comparison, without_targets

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Compare the results with the stored tolerances; a failure ends the workflow with an error."""
    yaml = YAML(typ="safe")
    tolerances = [entry for file in snakemake.input.tolerances for entry in yaml.load(Path(file))]
    validate(tolerances, yaml.load(Path(snakemake.input.schema)))
    quantities = pd.concat([pd.read_csv(file) for file in snakemake.input.quantities])
    guarded, sentence = without_targets(tolerances, snakemake.params.not_checked)
    comparison = compare(quantities, guarded)
    print_comparison(comparison)
    if sentence:
        print(sentence)
    if not comparison["passed"].all():
        sys.exit("check: results outside their tolerances, see the table above")
    comparison.to_csv(snakemake.output[0], index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
