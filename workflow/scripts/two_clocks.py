"""Hold the stated uncertainties of two clocks against the truth."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import rounded
from camid.proof.two_clocks.campaign import summary, to_markdown
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold the stated uncertainties of two clocks against the truth."""
    errors = pd.concat([read_dataset(file) for file in snakemake.input.errors], ignore_index=True)
    found = summary(errors)
    stamp = (
        f"{snakemake.params.pairs} pairs of seed {snakemake.params.seed}, made and joined by\n"
        f"`.venv/bin/snakemake -c2 two_clocks` at commit {revision()}."
    )
    target = Path(snakemake.output.markdown)
    write_whole(target, lambda path: path.write_text(to_markdown(found, stamp), encoding="utf-8"))
    rounded(found).to_csv(snakemake.output.coverage, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
