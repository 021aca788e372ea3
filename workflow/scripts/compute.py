"""Compute one table (or set of arrays): call the rule's function with the rule's inputs and parameters by name."""

from typing import TYPE_CHECKING

from camid.workflow.dataset_files import write_arrays, write_dataset
from camid.workflow.job import arguments, function_of, logged, parameters_of

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Call the function and write what it returns, with the parameters beside it."""
    result = function_of(snakemake)(**arguments(snakemake))
    if snakemake.output[0].endswith(".npz"):
        write_arrays(result, snakemake.output[0])
    else:
        write_dataset(result, snakemake.output[0], parameters_of(snakemake))


if __name__ == "__main__":
    with logged(snakemake.log[0]):
        main()
