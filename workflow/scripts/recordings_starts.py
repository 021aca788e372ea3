"""Write the page on what diagnoses of the real recordings owe to their starts."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.real_recordings.starts_page import starts_page
from camid.workflow.job import logged
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Write the page."""
    files = [Path(file) for file in snakemake.input.draws]
    draws = {file.stem.removesuffix("_starts"): pd.read_csv(file) for file in files}
    text = starts_page(draws, pd.read_csv(snakemake.input.windows))
    write_whole(snakemake.output.page, lambda path: path.write_text(text, encoding="utf-8"))


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
