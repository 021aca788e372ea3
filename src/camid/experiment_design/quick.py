"""A quick design for the report of a diagnosis, in the place of general advice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.finding import Finding
from camid.diagnosis.watch import Watch
from camid.diagnosis.weights import UNLISTED
from camid.engine.mechanics import NotApplicable
from camid.errors import InputError
from camid.experiment_design.run import Task, design_for
from camid.experiment_design.sources import Wishes, known_from_mapping, limits_of, noise_of
from camid.experiment_design.words import sentence

# Weight of two names from which an experiment is designed for the report.
OPEN = 0.10
# Rows of simulations that it may cost, and seconds after which it stops: a few.
SIMULATED_ROWS, SECONDS = 6e5, 10.0
WRITE_IT = "camid design on this folder writes it as a file, and takes the limits of the rig."
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
    if improved.input_column is None or improved.controller is not None or improved.output_columns:
        return finding  # no input that could be designed
    likely = [w for n, w in [(finding.identifier, finding.weight), *finding.alternatives] if n != UNLISTED]
    text = None
    if sum(weight >= OPEN for weight in likely) > 1:
        text = _designed(replace(diagnosis, hypotheses=own))
    text = f"{text} {WRITE_IT}" if text else f"{finding.separating_experiment} {COMPUTE_IT}"
    return replace(finding, separating_experiment=text)


def _designed(diagnosis: Diagnosis) -> str | None:
    """The best experiment that a short search finds, in words; None where none can be designed."""
    try:
        known = known_from_mapping(diagnosis.to_mapping(), "diagnosis")
        likely = [h for h in known.hypotheses if not h.identifier or h.weight >= OPEN]
        known = replace(known, hypotheses=likely)
        task = Task(likely, limits_of(known, Wishes()), noise_of(known, Wishes()), known.rows, known.experiments)
        return sentence(design_for(task, Watch(None, SECONDS), simulated_rows=SIMULATED_ROWS, checked=1))
    except (InputError, NotApplicable, ValueError, ArithmeticError, KeyError, np.linalg.LinAlgError):
        return None
