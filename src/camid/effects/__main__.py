"""``python -m camid.effects FILE``: put the table of the catalogue into a document."""

import sys
from pathlib import Path

from camid.effects.document import write

if __name__ == "__main__":
    write(Path(sys.argv[1]))
