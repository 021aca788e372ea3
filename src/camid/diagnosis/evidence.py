"""The numbers that a diagnosis rests on, before and after: errors, gains, coefficients and tests; and the signals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camid.diagnosis.diagnosis import Coefficient, Signals, StructureTest
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.residual.mismatch_location import PlaceTest
from camid.diagnosis.residual.validation_rows import AT_REST_SHARE
from camid.diagnosis.search.decision import Decision
from camid.diagnosis.swinging_coefficient import Swing, swinging_coefficient
from camid.fitting.fit import Fitted
from camid.fitting.plant_with_effects import Model
from camid.fitting.problem import Problem
from camid.simulation.model import Simulation

Array = NDArray[np.float64]


def removed_shares(base: Fitted, decision: Decision) -> list[float]:
    """Share of the refitted sum of squares that each effect removes."""
    total = max(base.cost, 1e-300)
    return [min(max((w.cost - decision.fitted.cost) / total, 0.0), 1.0) for w in decision.without]


def is_at_rest(problem: Problem, rows: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether the recorded output rests in some rows, where its spread is that of the noise and no measure of errors.

    Another part is taken where one moves, see :mod:`camid.diagnosis.residual.validation_rows`.
    """
    still = all(np.ptp(e.output[r]) == 0.0 for e, r in zip(problem.experiments, rows, strict=True) if r.any())
    return still or problem.spread(rows) ** 2 < AT_REST_SHARE * problem.spread(_all_rows(problem, rows)) ** 2


def _all_rows(problem: Problem, rows: Sequence[NDArray[np.bool_]]) -> list[NDArray[np.bool_]]:
    """Rows that are fitted, and others."""
    return [e.used | r for e, r in zip(problem.experiments, rows, strict=True)]


def _reference(problem: Problem, rows: Sequence[NDArray[np.bool_]]) -> float:
    """Standard deviation of the recorded output that errors on some rows are measured by."""
    return problem.spread(_all_rows(problem, rows) if is_at_rest(problem, rows) else rows)


def simulated_error(problem: Problem, model: Model, rows: Sequence[NDArray[np.bool_]]) -> float:
    """Root of the mean square error on some rows of all recordings, over the spread of the recorded output there.

    Where the output rests in those rows it is over the spread of the whole recordings.
    """
    simulated = problem.simulate(model)
    errors = np.concatenate([(e.output - s)[r] for e, s, r in zip(problem.experiments, simulated, rows, strict=True)])
    return float(np.sqrt(np.mean(errors**2))) / _reference(problem, rows)


def errors(
    problem: Problem,
    nominal: tuple[Model, Model],
    decision: Decision,
    validation: Sequence[NDArray[np.bool_]],
    chosen: bool,
    left: Sequence[PlaceTest],
) -> NormalisedErrors:
    """Errors on validation rows, and what the noise alone would leave there.

    ``nominal`` is the simulation as ``simulate`` runs it, and the same with the constants that it leaves open.

    Where ``left``, the tests of what is left, find structure, that is no noise: the floor is then what the residual's
    own past does not predict, without what the tests explain.
    """
    final = decision.improved
    given, in_place = nominal
    energy = final.cost
    if left:
        innovations = problem.whitened(final.residual, final.noise.whitening)
        energy = min(energy * (1.0 - max(t.share for t in left)), float(innovations @ innovations))
    variance = energy / max(len(final.residual) - len(final.packing.names), 1)
    index = next(i for i, r in enumerate(validation) if r.any())
    times = problem.times[index][validation[index]]
    return NormalisedErrors(
        simulated_error(problem, given, validation),
        simulated_error(problem, decision.base.model, validation),
        simulated_error(problem, final.model, validation),
        float(np.sqrt(variance)) / _reference(problem, validation),
        (float(times[0]), float(times[-1])),
        chosen,
        problem.kind.position_errors(problem, (decision.base.model, final.model), validation),
        None if in_place is given else simulated_error(problem, in_place, validation),
        is_at_rest(problem, validation),
        simulated_error(problem, final.model, _all_rows(problem, validation)),
    )


def errors_without(problem: Problem, decision: Decision, validation: Sequence[NDArray[np.bool_]]) -> list[float]:
    """Normalised error on validation rows without each effect beside the others, and last with all of them."""
    fitted = [*decision.without, decision.fitted]
    return [simulated_error(problem, each.model, validation) for each in fitted]


def coefficients_of(
    problem: Problem, believed: Simulation, nominal: Model, base: Fitted, final: Fitted
) -> list[Coefficient]:
    """How far the coefficients had been bent by what was left out."""
    kind, structure = problem.kind, problem.structure
    given = kind.estimates(structure, nominal, None)
    bent, improved = (kind.estimates(structure, fitted.model, fitted) for fitted in (base, final))
    return [
        Coefficient(
            name,
            value,
            bent[i][1],
            bent[i][2],
            improved[i][1],
            improved[i][2],
            believed.unit_of_coefficient(name),
            believed.physical is not None,
        )
        for i, (name, value, _) in enumerate(given)
    ]


def tests_of(
    problem: Problem,
    base: Fitted,
    final: Fitted,
    before: Sequence[PlaceTest],
    after: Sequence[PlaceTest],
    swing: Swing | None,
) -> list[StructureTest]:
    """Tests of whiteness, of every place, and of coefficients that swing (``swing`` after), before and after."""
    white = problem.whiteness(base.residual, base.moving_sensitivities)
    still = white if final is base else problem.whiteness(final.residual, final.moving_sensitivities)
    rows = [StructureTest("whiteness", "Does the residual depend on its own past?", white, still)]
    rows += [StructureTest(b.place, b.question, b.p_value, a.p_value) for b, a in zip(before, after, strict=True)]
    swings = (swing if final is base else swinging_coefficient(problem, base), swing)
    before_and_after = [1.0 if each is None else each.p_value for each in swings]
    return [*rows, StructureTest("coefficients", "Does a coefficient of the plant swing in time?", *before_and_after)]


def signals_of(
    problem: Problem, nominal: Model, base: Fitted, final: Fitted, validation: Sequence[NDArray[np.bool_]]
) -> list[Signals]:
    """What the report draws and residuals.csv holds, of every recording."""
    nominal_output, refitted = problem.simulate(nominal), problem.simulate(base.model)
    improved = refitted if final is base else problem.simulate(final.model)
    return [
        Signals(
            time,
            experiment.signal,
            experiment.output / experiment.weight,
            nominal_output[i] / experiment.weight,
            refitted[i] / experiment.weight,
            improved[i] / experiment.weight,
            problem.kind.position_seen(problem, base.model, i, position),
            velocity,
            problem.kind.equivalent_input(problem, base.model, experiment.output - refitted[i]),
            experiment.used,
            validation[i],
        )
        for i, (experiment, time, (position, velocity)) in enumerate(
            zip(problem.experiments, problem.times, problem.motion(base.model), strict=True)
        )
    ]
