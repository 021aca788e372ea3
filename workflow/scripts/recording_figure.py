"""Collect and draw the results on a real recording."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.plotting import save
from camid.real_recordings.drawing import SETTLED_DIGITS, draw
from camid.real_recordings.laws import law
from camid.real_recordings.results import Results, quantities
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Collect and draw the results on a real recording."""
    files = snakemake.input
    folders = (Path(file).parent for file in (files.diagnosis, files.again))
    results = Results.read(snakemake.params.name, Path(files.recording), Path(files.simulation), *folders)
    linear = {Path(file).stem.split("_")[1]: pd.read_csv(file) for file in files.get("linear", [])}
    table = quantities(results, linear)
    # Recorded samples stay out of the table: they have no licence.
    save(draw(results, law(results)), table, snakemake.output.png, snakemake.output.csv, digits=SETTLED_DIGITS)


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
