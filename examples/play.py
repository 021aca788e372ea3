"""Play an input on the slide of ``make_recording.py``: ``python play.py next/input.csv second.csv``.

It stands for the rig: it reads the columns t and u, and writes t, u and y as the camera would have filmed it.
"""

import csv
import sys
from random import Random

from make_recording import NOISE, PERIOD, positions

SEED = 20261123


def main(played: str, recorded: str) -> None:
    """Write the recording of an input."""
    random = Random(SEED)
    with open(played, newline="", encoding="utf-8") as file:
        inputs = [float(row["u"]) for row in csv.DictReader(file)]
    with open(recorded, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", "u", "y"])
        for k, (level, position) in enumerate(zip(inputs, positions(inputs), strict=True)):
            writer.writerow([f"{k * PERIOD:.2f}", f"{level:g}", f"{position + random.gauss(0.0, NOISE):.4f}"])
    print(f"{len(inputs)} rows written to {recorded}")


if __name__ == "__main__":
    main(*sys.argv[1:])
