"""What each rule of the diagnosis adds: concealed rigs diagnosed with all of them, and with each left out.

``python -m benchmarks.rules [--rigs NAME] [--recordings N] [--seed N]`` in the ordinary environment. The recordings are
made by a generator of the proofs (:mod:`camid.proof`), with a seed that is not one of proof, calibration or tests. A
rule that did nothing in a diagnosis is not left out of another one, which would be the same.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager, nullcontext
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd

import camid
from benchmarks.left_out_rules import ALL_RULES, RULES, Part
from camid.errors import InputError
from camid.proof.concealed import generator
from camid.proof.concealed.cases import plan
from camid.proof.other_authors import AUTHORS
from camid.proof.scoring import score
from camid.proof.sealed_files import RECORDING, SIMULATION, write_table, write_yaml
from camid.proof.second_author.concealment import NotShownError

RECORDINGS, SEED, WORKERS = 160, 777003, 2
# Words that the others' truths have, and those of authors who measured no images do not.
WITHOUT_IMAGES = {"snr_db": np.nan, "repeatable": False, "images": False}


def _of_the_sealed_proof(seed: int, index: int, count: int) -> Any:
    """A recording by the generator of the sealed proof."""
    return generator.make(plan(seed, count)[index])


# Whose recordings: a function of seed, index and count.
RIGS: dict[str, Any] = {"concealed": _of_the_sealed_proof, **AUTHORS}


def _alone(*_: object) -> nullcontext[None]:
    """In the place of a copy of this process, which would take its share of the work: the cores have work already."""
    return nullcontext()


@contextmanager
def without(rule: str) -> Iterator[None]:
    """Diagnoses without a rule."""
    with ExitStack() as stack:
        for path, part in RULES[rule].items():
            stack.enter_context(mock.patch(path, part.instead))
        yield


@contextmanager
def observed() -> Iterator[set[str]]:
    """Diagnoses with all rules, and those that did something or, as constants may always have, could have."""
    used = {rule for rule, parts in RULES.items() if any(part.did is None for part in parts.values())}
    parts_of: dict[str, list[tuple[str, Part]]] = {}
    for rule, parts in RULES.items():
        if rule not in used:
            for path, part in parts.items():
                parts_of.setdefault(path, []).append((rule, part))

    def noting(path: str, original: Any) -> Any:
        def call(*arguments: Any, **options: Any) -> Any:
            found = original(*arguments, **options)
            used.update(rule for rule, part in parts_of[path] if part.did is not None and part.did(found, arguments))
            return found

        return call

    with ExitStack() as stack:
        for path in parts_of:
            stack.enter_context(mock.patch(path, noting(path, resolve_name(path))))
        yield used


def diagnosed(rigs: str, seed: int, count: int, index: int) -> list[dict[str, Any]]:
    """A row for each rule that is left out: what the diagnosis got right, and its seconds of a processor."""
    try:
        made = RIGS[rigs](seed, index, count)
    except NotShownError:
        return []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_table(made.recording, folder / RECORDING)
        write_yaml(made.simulation, folder / SIMULATION)

        def row(rule: str) -> dict[str, Any]:
            start = time.process_time()
            found = _diagnosis(folder)
            seconds = time.process_time() - start
            fit = found["fit"] if found else {"nrmse_improved": np.nan, "nrmse_refitted": np.nan}
            error = fit["nrmse_improved"] / max(fit["nrmse_refitted"], 1e-12)
            judged = score({**WITHOUT_IMAGES, **made.truth}, found)
            said = {"rule": rule, "case": index, "verdict": found["verdict"] if found else "failed"}
            return {**said, **judged, "error": error, "s": seconds}

        # What a copy of this process does is not seen here.
        with mock.patch("camid.diagnosis.run.with_a_copy", _alone), observed() as used:
            rows = [row(ALL_RULES)]
        for rule in list(RULES)[1:]:
            if rule in used:
                with mock.patch("camid.diagnosis.run.with_a_copy", _alone), without(rule):
                    rows.append(row(rule))
            else:
                rows.append({**rows[0], "rule": rule})
            rows[-1]["used"] = rule in used
    return rows


def _diagnosis(folder: Path) -> Mapping[str, Any] | None:
    """What the diagnosis of the recording in a folder says; None where it is refused."""
    try:
        return camid.diagnose(folder / RECORDING, folder / SIMULATION, time_limit=None).to_mapping()
    except InputError:
        return None


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """What is right without each rule, one row each."""
    rows = rows.fillna({"names": ""})  # none
    usual = rows[rows["rule"] == ALL_RULES].set_index("case")
    found = []
    for rule in RULES:
        part = rows[rows["rule"] == rule].set_index("case")
        listed = part[part["kind"] != "outside"]  # the others have no name
        found.append(
            {
                "left out": "–" if rule == ALL_RULES else rule,
                "did something in": "–" if rule == ALL_RULES else int(part["used"].sum()),
                "other names": int((part["names"] != usual["names"]).sum()),
                "other verdicts": int((part["verdict"] != usual["verdict"]).sum()),
                "strong effects named": f"{listed['strong_in_class'].sum()} of {listed['strong'].sum()}",
                "wrong names": int(part["wrong_names"].sum()),
                "confidently wrong": int(part["confidently_wrong"].sum()),
                "false alarms": int(part["false_alarm"].sum()),
                "held-out error, mean": f"{part['error'].clip(upper=2.0).mean():.4f}",
                "processor": f"{part['s'].sum():.0f} s",
            }
        )
    return pd.DataFrame(found)


def main(arguments: list[str]) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rules", description=__doc__.splitlines()[0])
    parser.add_argument("--rigs", choices=list(RIGS), default="concealed", help="whose recordings (default: concealed)")
    parser.add_argument("--recordings", type=int, default=RECORDINGS, help=f"how many (default: {RECORDINGS})")
    parser.add_argument("--seed", type=int, default=SEED, help=f"(default: {SEED})")
    parser.add_argument("--rows", type=Path, help="a CSV that gets a row for each recording and rule, as they are made")
    asked = parser.parse_args(arguments)
    with ProcessPoolExecutor(WORKERS) as pool:
        rows: list[dict[str, Any]] = []
        work = partial(diagnosed, asked.rigs, asked.seed, asked.recordings)
        for number, some in enumerate(pool.map(work, range(asked.recordings)), start=1):
            rows += some
            if asked.rows is not None:
                write_table(pd.DataFrame(rows), asked.rows)
            print(f"\r{number} of {asked.recordings}", end="", file=sys.stderr, flush=True)
    print(summary(pd.DataFrame(rows)).to_markdown(index=False))
    print(f"\n{asked.recordings} recordings of {asked.rigs}, seed {asked.seed}; errors are shares of the re-estimated")
    print("simulation's, at most 2.")


if __name__ == "__main__":
    main(sys.argv[1:])
