"""What each rule of the diagnosis adds: concealed rigs diagnosed with all of them, and with each left out.

``python -m benchmarks.rules [RECORDINGS [SEED]]`` in the ordinary environment. The recordings are made by the generator
of the sealed proof (:mod:`camid.proof.concealed`), with a seed that is not one of proof, calibration or tests. A rule
that did nothing in a diagnosis is not left out of another one, which would be the same.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from pkgutil import resolve_name
from typing import Any
from unittest import mock

import pandas as pd
from tabulate import tabulate

import camid
from camid.diagnosis.search.decision import Decision
from camid.proof.concealed.cases import plan
from camid.proof.concealed.generator import Case, make
from camid.proof.scoring import score
from camid.proof.sealed_files import RECORDING, SIMULATION, write_case

RECORDINGS, SEED, WORKERS = 160, 777003, 2


def _kept(problem: object, decision: object, *_: object) -> object:
    return decision


def _none(*_: object, **__: object) -> list[object]:
    return []


def _never(*_: object) -> bool:
    return False


def _nothing(*_: object) -> None:
    return None


def _without_laws(problem: object, base: Any, *_: object) -> object:
    return Decision(base, base)


# What stands in the place of a rule; all of these are names in camid.diagnosis.
RULES: dict[str, dict[str, Any]] = {
    "all rules": {},
    "held-out rows refute names": {"run.borne_out": _kept},
    "names that coloured noise explains go": {"run.in_noise_metric": _kept},
    "fewest and simplest names where structure is left": {"run.simplest": _kept},
    "no further names beside an inexact law": {"search.forward_selection.laws_are_inexact": _never},
    "a look beside a name that chance may explain": {"search.forward_selection.WORTH_A_LOOK": 1.0},
    "further shapes of a resonance": {"search.hypothesis_search._further_shapes": _none},
    "laws that do nearly the same": {
        "search.hypothesis_search._relatives": _none,
        "search.effect_selection.relatives_in_place": _none,
    },
    "starts from other coefficients": {"search.hypothesis_search._starts_elsewhere": _none},
    "a search that begins with other first effects": {"search.effect_selection.with_other_beginnings": _kept},
    "a race where all are far off": {"search.hypothesis_search._is_lost": _never},
    "rows weighed by their noise": {"run.relative_noise": _nothing},
    "laws with more detail": {"search.hypothesis_search.finer_laws": _none},
    "learned laws": {"run.with_learned_laws": _kept},
    "learned laws in the place of all names": {"laws.laws_alone.with_laws_alone": _without_laws},
}
# Whether a rule did anything, by what it returned and was called with, and what stands in its place.
DID: dict[Any, Callable[[Any, tuple[Any, ...]], bool]] = {
    _kept: lambda found, arguments: found is not arguments[1],
    _none: lambda found, arguments: bool(found),
    _never: lambda found, arguments: bool(found),
    _nothing: lambda found, arguments: found is not None,
    _without_laws: lambda found, arguments: bool(found.laws),
}


@contextmanager
def without(rule: str) -> Iterator[None]:
    """Diagnoses without a rule."""
    with ExitStack() as stack:
        for name, replacement in RULES[rule].items():
            stack.enter_context(mock.patch(f"camid.diagnosis.{name}", replacement))
        yield


@contextmanager
def observed() -> Iterator[set[str]]:
    """Diagnoses with all rules, and those that did something or may have; a constant may always have."""
    used = {rule for rule, parts in RULES.items() if any(not callable(part) for part in parts.values())}

    def noting(rule: str, original: Callable[..., Any], did: Callable[[Any, tuple[Any, ...]], bool]) -> Any:
        def call(*arguments: Any, **options: Any) -> Any:
            found = original(*arguments, **options)
            if did(found, arguments):
                used.add(rule)
            return found

        return call

    with ExitStack() as stack:
        for rule, parts in RULES.items():
            for name, replacement in parts.items():
                if rule not in used:
                    path = f"camid.diagnosis.{name}"
                    stack.enter_context(mock.patch(path, noting(rule, resolve_name(path), DID[replacement])))
        yield used


def diagnosed(case: Case) -> list[dict[str, Any]]:
    """A row for each rule that is left out: what the diagnosis got right, and its seconds of a processor."""
    made = make(case)
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / folder for folder in ("recordings", "held_out", "truths")]
        write_case(case.index, made, *folders)
        own = folders[0] / str(case.index)

        def row(rule: str) -> dict[str, Any]:
            start = time.process_time()
            found = camid.diagnose(own / RECORDING, own / SIMULATION, time_limit=None).to_mapping()
            seconds = time.process_time() - start
            fit = found["fit"]
            error = fit["nrmse_improved"] / max(fit["nrmse_refitted"], 1e-12)
            return {"rule": rule, "case": case.index, **score(made.truth, found), "error": error, "s": seconds}

        usual, *others = RULES
        with observed() as used:
            rows = [row(usual)]
        for rule in others:
            if rule in used:
                with without(rule):
                    rows.append(row(rule))
            else:
                rows.append({**rows[0], "rule": rule})
            rows[-1]["used"] = rule in used
    return rows


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """What is right without each rule, one row each."""
    usual = rows[rows["rule"] == "all rules"].set_index("case")
    found = []
    for rule in RULES:
        part = rows[rows["rule"] == rule].set_index("case")
        listed = part[part["kind"] != "outside"]  # the others have no name
        found.append(
            {
                "left out": "–" if rule == "all rules" else rule,
                "did something in": "–" if rule == "all rules" else int(part["used"].sum()),
                "other names": int((part["names"] != usual["names"]).sum()),
                "strong effects named": f"{listed['strong_in_class'].sum()} of {listed['strong'].sum()}",
                "wrong names": int(part["wrong_names"].sum()),
                "confidently wrong": int(part["confidently_wrong"].sum()),
                "false alarms": int(part["false_alarm"].sum()),
                "held-out error, mean": f"{part['error'].clip(upper=2.0).mean():.3f}",
                "processor": f"{part['s'].sum():.0f} s",
            }
        )
    return pd.DataFrame(found)


def main(arguments: list[str]) -> None:
    """Print the table."""
    recordings, seed = (int(a) for a in [*arguments, *map(str, (RECORDINGS, SEED)[len(arguments) :])])
    with ProcessPoolExecutor(WORKERS) as pool:
        rows: list[dict[str, Any]] = []
        for number, some in enumerate(pool.map(diagnosed, plan(seed, recordings)), start=1):
            rows += some
            print(f"\r{number} of {recordings}", end="", file=sys.stderr, flush=True)
    print(tabulate(summary(pd.DataFrame(rows)), headers="keys", tablefmt="github", showindex=False))
    print(f"\n{recordings} recordings of seed {seed}; errors are shares of the re-estimated simulation's, at most 2.")


if __name__ == "__main__":
    main(sys.argv[1:])
