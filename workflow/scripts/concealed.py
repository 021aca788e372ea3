"""Hold what the sealed proof measured against its targets."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import rounded
from camid.proof.rates import coverage
from camid.proof.targets import lines, quantities, to_markdown
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold what the sealed proof measured against its targets."""
    scores, parameters, run_times, weights = (
        read_dataset(snakemake.input[name]) for name in ("scores", "parameters", "run_times", "weights")
    )
    found = lines(scores, parameters, run_times, weights)
    seed = snakemake.params.seed
    salt = Path(snakemake.input.salt).read_text(encoding="utf-8").strip()
    override = "" if snakemake.params.configured else f" --config concealed_seed={seed}"
    stamp = (
        f"{snakemake.params.number} recordings of seed {seed}, made, sealed, diagnosed and revealed by\n"
        f"`.venv/bin/snakemake -c2 concealed{override}` at commit {revision()}.\n"
        f"The seals are in `paper_figs/concealed_seals.csv`; their salt is `{salt}`."
    )
    write_whole(snakemake.output.markdown, lambda p: p.write_text(to_markdown(found, stamp), encoding="utf-8"))
    for table, path in (
        (quantities(found, "concealed"), snakemake.output.quantities),
        (coverage(parameters), snakemake.output.parameters),
        (pd.concat(map(pd.read_csv, snakemake.input.seals)).sort_values("index"), snakemake.output.seals),
    ):
        rounded(table).to_csv(path, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
