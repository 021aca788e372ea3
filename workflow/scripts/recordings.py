"""Write the page on the real recordings, and print the errors on the Silverbox multisine beside their references."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.real_recordings.page import page
from camid.workflow.job import logged
from camid.writing import write_whole

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

# Held and first-order-hold linear models on the official split: measured independently, and 6.95 mV for the best linear
# model in Champneys et al., arXiv 2405.10779.
REFERENCES = {"zoh": "14.8 ± 0.1", "foh": "7.0 ± 0.1"}


def main() -> None:
    """Write the page and the summary."""
    files = [Path(file) for file in snakemake.input.figures if Path(file).suffix == ".csv"]
    quantities = {file.stem.removeprefix("recording_"): pd.read_csv(file) for file in files}
    silverbox = quantities["silverbox"].set_index("quantity")["value"]
    rows = [
        {
            "recording": "silverbox, test multisine",
            "hold": hold,
            "rmse_mV": silverbox[f"multisine_linear_{hold}"],
            "reference_mV": reference,
        }
        for hold, reference in REFERENCES.items()
    ]
    summary = pd.DataFrame(rows)
    print(summary.to_string(index=False, float_format="%.2f"))
    write_whole(snakemake.output.summary, lambda path: summary.to_csv(path, index=False, lineterminator="\n"))
    text = page(Path(snakemake.input.page), quantities)
    write_whole(snakemake.output.page, lambda path: path.write_text(text, encoding="utf-8"))


if __name__ == "__main__":
    with logged(snakemake.log[0], also_print=True):
        main()
