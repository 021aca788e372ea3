"""Draw one ablation and state its numbers and its conclusion."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import save
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Draw one ablation and state its numbers and its conclusion."""
    name = snakemake.params.ablation
    table = read_dataset(snakemake.input.runs)
    figure, plotted = import_module(f"camid.ablations.{name}.drawing").draw(table)
    save(figure, plotted, snakemake.output.png, snakemake.output.csv)
    runs = import_module(f"camid.ablations.{name}.runs")
    rows = [
        {"target": f"ablation_{name}", "quantity": quantity, "value": float(value), "unit": unit}
        for quantity, (value, unit) in runs.quantities(table).items()
    ]
    pd.DataFrame(rows).to_csv(snakemake.output.quantities, index=False, lineterminator="\n")
    sentence = runs.conclusion({row["quantity"]: row["value"] for row in rows})
    Path(snakemake.output.conclusion).write_text(sentence + "\n", encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
