"""Hold designed experiments against repetitions of the first one."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
from ruamel.yaml import YAML

from camid.plotting import rounded, save
from camid.proof.designed_experiment.campaign import summary, to_markdown
from camid.proof.designed_experiment.drawing import draw
from camid.proof.designed_experiment.quantities import TARGET, quantities
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.workflow.tolerances import compare, print_comparison
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold designed experiments against repetitions of the first one."""
    rows = pd.concat([pd.read_parquet(file) for file in snakemake.input.rows], ignore_index=True)
    rows = rows.sort_values("number", ignore_index=True)
    found = summary(rows)
    stamp = (
        f"{snakemake.params.rigs} rigs of seed {snakemake.params.seed}, made, diagnosed and designed for by\n"
        f"`.venv/bin/snakemake -c2 designed_experiment` at commit {revision()}."
    )
    tolerances = YAML(typ="safe").load(Path(snakemake.input.tolerances))
    print_comparison(compare(quantities(rows), [entry for entry in tolerances if entry["target"] == TARGET]))
    target = Path(snakemake.output.markdown)
    write_whole(target, lambda path: path.write_text(to_markdown(found, rows, stamp), encoding="utf-8"))
    rounded(found).to_csv(snakemake.output.shares, index=False, lineterminator="\n")
    figure, table = draw(rows)
    save(figure, table, snakemake.output.png, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
