"""Make and seal one shard of concealed recordings."""

from pathlib import Path
from typing import TYPE_CHECKING

from camid.proof.concealed.generator import make, plan
from camid.proof.sealed_files import seal_cases, write_case
from camid.workflow.job import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Make and seal one shard of concealed recordings."""
    wildcards = snakemake.wildcards
    folders = [Path(snakemake.output[name]) for name in ("recordings", "held_out", "truths")]
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    # Every so-many-th of the plan, so that kinds and costs are spread evenly over the shards.
    cases = plan(int(wildcards.seed), snakemake.params.number)[int(wildcards.shard) :: int(wildcards.shards)]
    for case in cases:
        print(f"recording {case.index}: {case.kind}", flush=True)
        write_case(case.index, make(case), *folders)
    salt = Path(snakemake.input.salt).read_text(encoding="utf-8").strip()
    seals = seal_cases([case.index for case in cases], salt, *folders)
    seals.to_csv(snakemake.output.seals, index=False, lineterminator="\n")


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
