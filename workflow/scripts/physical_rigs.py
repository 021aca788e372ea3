"""Hold the stated uncertainties of physical constants against the truth."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import rounded
from camid.proof.physical_rigs.campaign import summary, summary_of_undetermined, to_markdown
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold the stated uncertainties of physical constants against the truth."""
    estimates, undetermined = (
        pd.concat([read_dataset(file) for file in snakemake.input[name]], ignore_index=True)
        for name in ("estimates", "undetermined")
    )
    determined, ambiguous = summary(estimates), summary_of_undetermined(undetermined)
    seed, seeds = snakemake.params.seed, snakemake.params.seeds
    stamp = (
        f"{seeds} recordings of each rig, seeds {seed} to {seed + seeds - 1}, made and identified by\n"
        f"`.venv/bin/snakemake -c2 physical_rigs` at commit {revision()}."
    )
    target = Path(snakemake.output.markdown)
    text = to_markdown(determined, ambiguous, stamp)
    write_whole(target, lambda path: path.write_text(text, encoding="utf-8"))
    parts = (determined.assign(determined=True), ambiguous.assign(determined=False))
    table = rounded(pd.concat(parts, ignore_index=True).astype({"open": "Int64", "named": "Int64"}))
    table.to_csv(snakemake.output.coverage, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
