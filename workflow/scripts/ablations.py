"""Collect the conclusions of all ablations in one table."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.experiments.log import logged
from camid.recording import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Collect the conclusions of all ablations in one table."""
    names = snakemake.params.names
    sentences = [Path(file).read_text(encoding="utf-8").strip() for file in snakemake.input.conclusions]
    table = pd.DataFrame(
        {
            "ablation": [f"[{name.replace('_', ' ')}](paper_figs/ablation_{name}.png)" for name in names],
            "conclusion": sentences,
            "target": [f"ablation_{name}" for name in names],
        }
    )
    write_whole(snakemake.output.csv, lambda p: table.to_csv(p, index=False, lineterminator="\n"))
    write_whole(
        snakemake.output.markdown, lambda p: p.write_text(table.to_markdown(index=False) + "\n", encoding="utf-8")
    )


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
