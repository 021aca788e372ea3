"""Hold what was found in filmed rigs against what was put in."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import rounded
from camid.proof.filmed_rigs.campaign import to_markdown
from camid.workflow.dataset_files import read_dataset
from camid.workflow.job import logged
from camid.workflow.revision import revision
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Hold what was found in filmed rigs against what was put in."""
    found = pd.concat([read_dataset(file) for file in snakemake.input.diagnoses], ignore_index=True)
    found = found.sort_values("clip")
    stamp = (
        f"{snakemake.params.clips} clips of seed {snakemake.params.seed}, made and diagnosed by\n"
        f"`.venv/bin/snakemake -c2 filmed_rigs` at commit {revision()}."
    )
    target = Path(snakemake.output.markdown)
    write_whole(target, lambda path: path.write_text(to_markdown(found, stamp), encoding="utf-8"))
    rounded(found).to_csv(snakemake.output.clips, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
