"""Collect the conclusions of all ablations in one list."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.workflow.job import logged
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Collect the conclusions of all ablations in one list."""
    names = snakemake.params.names
    sentences = [Path(file).read_text(encoding="utf-8").strip() for file in snakemake.input.conclusions]
    targets = [f"ablation_{name}" for name in names]
    table = pd.DataFrame({"target": targets, "conclusion": sentences})
    write_whole(snakemake.output.csv, lambda p: table.to_csv(p, index=False, lineterminator="\n"))
    items = [
        f"- [**{name.replace('_', ' ')}**]({target}.png) (`{target}`): {sentence}\n"
        for name, target, sentence in zip(names, targets, sentences, strict=True)
    ]
    write_whole(snakemake.output.markdown, lambda p: p.write_text("".join(items), encoding="utf-8"))


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
