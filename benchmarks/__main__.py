"""Run the benchmarks on one thread: ``python -m benchmarks [NAME …]``."""

import importlib
import os
import sys

from benchmarks.threads import SINGLE_THREAD

if __name__ == "__main__":
    # The libraries read their number of threads when they are imported, so this comes first.
    os.environ.update(SINGLE_THREAD)
    sys.exit(importlib.import_module("benchmarks.run").main(sys.argv[1:]))
