"""Collect the numbers that are quoted and guarded, and judge the paper's claims by them."""

from pathlib import Path
from typing import TYPE_CHECKING

from camid.paper.claims import ambiguities, claims, to_markdown
from camid.paper.quantities import all_quantities
from camid.workflow.job import logged, tables

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the numbers and the claims."""
    quantities = all_quantities(tables(snakemake), {"plant": snakemake.params.plant})
    quantities.to_csv(snakemake.output.quantities, index=False, lineterminator="\n")
    judged = claims(quantities)
    judged.to_csv(snakemake.output.csv, index=False, lineterminator="\n")
    Path(snakemake.output.markdown).write_text(to_markdown(judged, ambiguities(quantities)), encoding="utf-8")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
