"""Hold what was learned of laws outside the catalogue against the truth."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
from ruamel.yaml import YAML

from camid.plotting import save
from camid.proof.figures.unlisted import draw
from camid.proof.unlisted.table import judged, quantities, to_markdown
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.workflow.tolerances import compare, print_comparison
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold what was learned against the truth."""
    answers = pd.concat([pd.read_parquet(file) for file in snakemake.input.answers], ignore_index=True)
    rows = judged(answers).sort_values(["missing", "number"], ascending=[False, True], ignore_index=True)
    parameters = snakemake.params
    count = parameters.recordings
    stamp = (
        f"{count} recordings under a law and as many with nothing missing, seed {parameters.seed}, diagnosed by\n"
        f"`.venv/bin/snakemake -c2 unlisted --config unlisted_recordings={count}` at commit {revision()}."
    )
    tolerances = YAML(typ="safe").load(Path(snakemake.input.tolerances))
    comparison = compare(quantities(rows), [entry for entry in tolerances if entry["target"] == "unlisted"])
    print_comparison(comparison)
    asked = dict(zip(comparison["quantity"], comparison["allowed"], strict=True))
    target = Path(snakemake.output.markdown)
    write_whole(target, lambda path: path.write_text(to_markdown(rows, stamp, asked), encoding="utf-8"))
    save(draw(rows), rows.drop(columns="seconds"), snakemake.output.png, snakemake.output.csv)


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
