"""``python -m camid``."""

import sys

from camid.cli import main

sys.exit(main())
