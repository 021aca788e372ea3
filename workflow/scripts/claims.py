"""Judge the paper's claims."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.paper.claims import ambiguities, claims, to_markdown
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Judge the paper's claims."""
    quantities = pd.read_csv(snakemake.input.quantities)
    table = claims(quantities)
    table.to_csv(snakemake.output.csv, index=False, lineterminator="\n")
    Path(snakemake.output.markdown).write_text(to_markdown(table, ambiguities(quantities)), encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
