"""A quick design for the report of a diagnosis, in the place of general advice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.finding import Finding
from camid.diagnosis.watch import Watch
from camid.engine.mechanics import NotApplicable
from camid.errors import InputError
from camid.experiment_design.run import Task, design_for, refuse_rest_outside
from camid.experiment_design.sources import Wishes, known_from_mapping, limits_of, noise_of
from camid.experiment_design.sums import warnings_of
from camid.experiment_design.words import NOTHING_TELLS, sentence

# Weight of two names from which an experiment is designed for the report.
OPEN = 0.10
# Rows of simulations that it may cost, and seconds after which it stops: a few.
SIMULATED_ROWS, SECONDS = 6e5, 10.0
WRITE_IT = (
    "camid design on this folder searches longer, within the limits of the rig, and writes what it finds, which may be "
    "another input."
)
COMPUTE_IT = "camid design on this folder computes one, within the limits of the rig."


def with_designed_experiments(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis with the separating experiment of its findings designed, where two names are likely.

    Where one cannot be designed, or one name alone is likely, the general advice stays, and says how to get one.
    """
    findings = [_with_experiment(diagnosis, finding) for finding in diagnosis.findings]
    return replace(diagnosis, findings=findings)


def _with_experiment(diagnosis: Diagnosis, finding: Finding) -> Finding:
    own = [h for h in diagnosis.hypotheses if h.instead_of == finding.identifier]
    improved = diagnosis.improved
    if finding.separating_experiment is None or len(own) < 2:
        return finding
    held = improved.controller is not None or improved.observer is not None
    if improved.input_column is None or held or improved.output_columns:
        return finding  # no input that could be designed
    text = _advice(replace(diagnosis, hypotheses=own), finding.separating_experiment)
    return replace(finding, separating_experiment=text)


def _advice(diagnosis: Diagnosis, general: str) -> str:
    """What to play, what it would say and what it leaves open; general advice where no input can be designed yet."""
    try:
        known = replace(known_from_mapping(diagnosis.to_mapping(), "diagnosis"), source="")
        task = Task(
            known.hypotheses, limits_of(known, Wishes()), noise_of(known, Wishes()), known.rows, known.experiments
        )
        refuse_rest_outside(task)
        likely = [h for h in known.hypotheses if h.is_name and h.weight >= OPEN]
        if len(likely) > 1:
            watch = Watch(None, SECONDS)
            said = sentence(design_for(task, watch, simulated_rows=SIMULATED_ROWS, checked=1))
            return " ".join([said, *([general] if said.startswith(NOTHING_TELLS) else []), WRITE_IT])
        together = [f"{one[0].upper()}{one[1:]}." for one in warnings_of(likely)]
        return " ".join([*together, general, COMPUTE_IT])
    except InputError as refusal:
        needs = f"; {refusal.hint}" if refusal.hint else ""
        return f"{general} camid design on this folder computes one once it is told more: {refusal.problem}{needs}."
    except (NotApplicable, ValueError, ArithmeticError, KeyError, np.linalg.LinAlgError):
        return f"{general} {COMPUTE_IT}"
