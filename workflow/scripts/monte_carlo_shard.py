"""Fit the noise seeds of one shard of the Monte Carlo."""

from typing import TYPE_CHECKING

from camid.ablations.monte_carlo.runs import compute_shard, shard_seeds
from camid.paper.dataset_files import write_dataset
from camid.paper.job_log import logged

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Fit the noise seeds of one shard of the Monte Carlo."""
    settings, shared = snakemake.params.settings, snakemake.params.shared
    seeds = shard_seeds(snakemake.params.seeds, snakemake.params.shard, snakemake.params.shards)
    table = compute_shard(settings, shared, seeds)
    write_dataset(table, snakemake.output[0], {**shared, "monte_carlo": settings, "seeds": [*map(str, [seeds])]})


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
