"""Find the Silverbox recording and write its parts."""

import sys
from typing import TYPE_CHECKING

from camid.benchmark_recordings import fetch, silverbox_parts
from camid.errors import InputError
from camid.recording import write_table

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main() -> None:
    """Find the Silverbox recording and write its parts."""
    try:
        parts = silverbox_parts(fetch("silverbox"))
    except InputError as error:
        sys.exit(f"camid: error: {error}")
    write_table(parts["training"], snakemake.output.training)
    write_table(parts["multisine"], snakemake.output.multisine)


if __name__ == "__main__":
    main()
