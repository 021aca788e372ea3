"""Open the seals of one shard and score its diagnoses."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from camid.proof.score_table import score_cases
from camid.proof.sealed_files import check_seals
from camid.workflow.dataset_files import write_dataset
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Open the seals of one shard and score its diagnoses."""
    seals = pd.read_csv(snakemake.input.seals)
    salt = Path(snakemake.input.salt).read_text(encoding="utf-8").strip()
    recordings, held_out, truths, diagnoses = (
        Path(snakemake.input[name]) for name in ("recordings", "held_out", "truths", "diagnoses")
    )
    check_seals(seals, salt, recordings, held_out, truths)
    tables = score_cases(seals["index"].tolist(), recordings, held_out, truths, diagnoses)
    for name, table in zip(("scores", "parameters", "weights"), tables, strict=True):
        write_dataset(table, snakemake.output[name], {"seed": int(snakemake.wildcards.seed)})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
