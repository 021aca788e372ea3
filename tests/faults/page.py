"""The table of docs/trust.md, from what `make test-faults` counted: ``python -m tests.faults.page``."""

import json
import sys

from tests.faults.__main__ import RESULT
from tests.support import ROOT

PAGE = ROOT / "docs/trust.md"
BEGIN, END = "<!-- table: python -m tests.faults.page -->", "<!-- end of the table -->"
# Campaigns of their own.
COMMANDS = {"slurm": "make test-slurm"}
HEADING = "| fault or input | tried on | asked for | trials | what happened | wrong |\n|---|---|---|---:|---|---:|\n"


def cell(text):
    """Text that stays in its cell."""
    return str(text).replace("|", "\\|").replace("\n", " ")


def table(content):
    """Rows of every campaign, and how to repeat each."""
    lines = [HEADING]
    for rows in (campaign["rows"] for campaign in content.values()):
        for row in rows:
            happened = "; ".join(f"{number} {what}" for what, number in row["outcomes"].items())
            cells = (row["fault"], row["tried_on"], row["expected"], row["trials"], happened, len(row["wrong"]))
            lines.append(f"| {' | '.join(map(cell, cells))} |\n")
    trials = sum(row["trials"] for campaign in content.values() for row in campaign["rows"])
    seconds = sum(campaign["seconds"] for campaign in content.values())
    seeds = sorted({seed for campaign in content.values() for seed in campaign["seeds"]})
    commands = ", ".join(f"`{COMMANDS.get(name, f'python -m tests.faults {name}')}`" for name in content)
    lines.append(f"\n{trials:,} trials in {seconds / 60:.0f} minutes, seed {', '.join(map(str, seeds))}; ")
    lines.append(f"parts of it: {commands}.\n")
    return "".join(lines)


def with_table(page, text, begin=BEGIN, end=END):
    """The page with a table in place of the one that it has."""
    before, _, rest = page.partition(begin)
    _, found, after = rest.partition(end)
    assert found, f"the page has lost its mark {begin}"
    return f"{before}{begin}\n\n{text}\n{end}{after}"


def main():
    """Write the page."""
    if not RESULT.exists():
        sys.exit(f"{RESULT} is missing: call make test-faults first")
    content = json.loads(RESULT.read_text(encoding="utf-8"))
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), table(content)), encoding="utf-8")


if __name__ == "__main__":
    main()
