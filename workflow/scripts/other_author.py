"""Hold what another author's recordings show against the targets of the first proof."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import rounded
from camid.proof.other_authors import author_lines
from camid.proof.targets import quantities, to_markdown
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold what another author's recordings show against the targets of the first proof."""
    scores, parameters, weights = (
        pd.concat([read_dataset(file) for file in snakemake.input[name]], ignore_index=True)
        for name in ("scores", "parameters", "weights")
    )
    found = author_lines(scores, parameters, weights)
    others = snakemake.params.number - len(scores)
    left_out = f"; no rig shows the laws that were drawn for the other {others}" if others else ""
    stamp = (
        f"{len(scores)} recordings of seed {snakemake.params.seed}, made, diagnosed and scored by\n"
        f"`.venv/bin/snakemake -c2 {snakemake.params.author}` at commit {revision()}{left_out}."
    )
    target = Path(snakemake.output.markdown)
    write_whole(target, lambda path: path.write_text(to_markdown(found, stamp), encoding="utf-8"))
    table = rounded(quantities(found, snakemake.params.author))
    table.to_csv(snakemake.output.quantities, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
