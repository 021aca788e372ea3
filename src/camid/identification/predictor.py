"""The simulated sensor output of a plant structure and its sensitivities to the plant's coefficients.

Everything that identification needs of the model is here: y = B/A u + C/A δ through hold and sensor, where C is the
polynomial of the unknown initial state, and the derivatives

    ∂w/∂b_j = S p^(m-j)/A u,    ∂w/∂a_i = -S p^(n-i)/A y,    ∂w/∂c_i = S p^(n-1-i)/A δ

with S the sensor. At the truth they are the noise-free regressors, hence the instruments of SRIVC (Young 2011, ch. 8).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camid.chain.companion_form import companion, derivative_rows, time_scale
from camid.chain.exact import respond
from camid.identification.experiment import Experiment
from camid.identification.factorisation import factorise
from camid.identification.least_squares import solve
from camid.identification.records import Records
from camid.identification.structure import Structure

Array = NDArray[np.float64]


@dataclass
class Predictor:
    """Simulated outputs and sensitivities for all experiments of one rig, in scaled time.

    The parameter vector is [b_0 … b_m, a_1 … a_n, c of experiment 1, c of experiment 2, …, bias, offset], the last two
    where they are unknown; the coefficients are scaled with the time unit so that they are of the order of one, see
    :meth:`to_physical`.
    """

    structure: Structure
    experiments: list[Experiment]
    time_unit: float
    records: Records = field(default=None)  # type: ignore[assignment]
    target: Array = field(init=False)
    free: NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        if self.records is None:
            self.records = Records.of(self.experiments)
        self.target = self.records.output[self.records.used]
        self.target_norm = float(np.linalg.norm(self.target))
        unknowns = self.records.linear_unknowns(self.structure.order)
        self.free = np.concatenate([self.structure.free, np.ones(unknowns, bool)])

    @classmethod
    def around(
        cls, structure: Structure, experiments: list[Experiment], denominator: Array, records: Records | None = None
    ) -> Predictor:
        """Predictor whose time unit fits a given monic denominator in physical units.

        ``records`` are the same experiments, packed; a caller that makes many predictors packs them once.
        """
        return cls(
            structure, experiments, time_scale(denominator), Records.of(experiments) if records is None else records
        )

    # -- units -----------------------------------------------------------------------------------------------------

    def coefficient_scale(self) -> Array:
        """Scaled coefficient divided by physical coefficient, shape (m + 1 + n,)."""
        order, degree = self.structure.order, self.structure.degree
        powers = np.concatenate([order - degree + np.arange(degree + 1.0), 1.0 + np.arange(order)])
        return self.time_unit**powers

    def scale(self) -> Array:
        """The same for the whole parameter vector; initial-state coefficients stay in scaled time."""
        return np.concatenate([self.coefficient_scale(), np.ones(self.linear_unknowns)])

    def to_physical(self, parameters: Array) -> Array:
        """[b_0 … b_m, a_1 … a_n] in SI units."""
        scale = self.coefficient_scale()
        return parameters[: len(scale)] / scale

    def from_physical(self, coefficients: Array, initial: Array | None = None) -> Array:
        """Parameter vector of coefficients in SI units, initial states zero where they are not given."""
        rest = np.zeros(self.linear_unknowns) if initial is None else initial
        return np.concatenate([coefficients * self.coefficient_scale(), rest])

    @property
    def linear_unknowns(self) -> int:
        """Number of initial-state coefficients in all experiments, and of unknown constants."""
        return len(self.free) - len(self.structure.free)

    def split(self, parameters: Array) -> tuple[Array, Array, list[Array | None]]:
        """Numerator, monic denominator and the initial polynomial of each experiment, all in scaled time."""
        order, split = self.structure.order, self.structure.degree + 1
        numerator = parameters[:split]
        denominator = np.concatenate([[1.0], parameters[split : split + order]])
        position = split + order
        initial: list[Array | None] = []
        for experiment in self.experiments:
            if experiment.estimate_initial_state:
                initial.append(parameters[position : position + order])
                position += order
            else:
                initial.append(None)
        return numerator, denominator, initial

    def bias_and_offset(self, parameters: Array) -> tuple[float, float]:
        """Constant that is added to the input, and what is left of the sensor's offset beside what is known."""
        offset = float(parameters[-1]) if self.records.sensor_offset else 0.0
        place = -2 if self.records.sensor_offset else -1
        return float(parameters[place]) if self.records.input_bias else 0.0, offset

    # -- model -----------------------------------------------------------------------------------------------------

    def simulate(self, parameters: Array) -> list[Array]:
        """Sensor output of every experiment, its offset included, all rows: shapes (N,)."""
        numerator, denominator, initial = self.split(parameters)
        bias, offset = self.bias_and_offset(parameters)
        order = self.structure.order
        output_row = numerator @ derivative_rows(denominator, range(self.structure.degree, -1, -1))
        results = []
        for experiment, polynomial in zip(self.experiments, initial, strict=True):
            matrix = companion(denominator)
            vector, start, row = np.eye(order)[0], np.zeros(order), output_row
            if polynomial is not None:
                matrix = np.asarray(np.kron(np.eye(2), matrix), dtype=np.float64)
                vector, start = np.eye(2 * order)[0], np.eye(2 * order)[order]
                row = np.concatenate([output_row[:order], polynomial, output_row[order:]])
            results.append(
                respond(
                    matrix,
                    vector,
                    start,
                    row[None, :],
                    experiment.signal + bias,
                    experiment.acquisition,
                    self.time_unit,
                    before_record=experiment.free_motion_before_record,
                )[:, 0]
                + (experiment.offset + offset)
            )
        return results

    def linearise(self, parameters: Array) -> tuple[Array, Array]:
        """Residual and sensitivities on the used rows.

        Returns
        -------
        residual : ndarray, shape (M,)
            Recorded minus simulated output.
        sensitivities : ndarray, shape (M, len(parameters))
            Derivatives of the simulated output, also for coefficients that are not free.
        """
        numerator, denominator, initial = self.split(parameters)
        bias, offset = self.bias_and_offset(parameters)
        order, split = self.structure.order, self.structure.degree + 1
        columns = len(parameters)
        block = companion(denominator)
        derivatives = derivative_rows(denominator, range(self.structure.degree, -1, -1))
        output_row = numerator @ derivatives
        outputs, tables = [], []
        position = split + order
        for experiment, polynomial in zip(self.experiments, initial, strict=True):
            chains = 2 if polynomial is None else 3
            size = chains * order
            # States: [z, z̃, z_δ] with z = u/A, z̃ = y/A and z_δ = δ/A.
            matrix = np.asarray(np.kron(np.eye(chains), block), dtype=np.float64)
            matrix[order, :order] += output_row[:order]
            vector = np.zeros(size)
            vector[0], vector[order] = 1.0, output_row[order]
            start = np.zeros(size)
            selection = np.zeros((1 + split + order + (chains - 2) * order, size + 1))
            selection[0, :order], selection[0, size] = output_row[:order], output_row[order]
            selection[1 : 1 + split, :order] = derivatives[:, :order]
            selection[1 : 1 + split, size] = derivatives[:, order]
            selection[1 + split : 1 + split + order, order : 2 * order] = -np.eye(order)
            if polynomial is not None:
                matrix[order, 2 * order :] += polynomial
                start[2 * order] = 1.0
                selection[0, 2 * order : size] = polynomial
                selection[1 + split + order :, 2 * order : size] = np.eye(order)
            result = respond(
                matrix,
                vector,
                start,
                selection,
                experiment.signal + bias,
                experiment.acquisition,
                self.time_unit,
                before_record=experiment.free_motion_before_record,
            )[experiment.used]
            outputs.append(result[:, 0] + offset)
            table = np.zeros((len(result), columns))
            table[:, : split + order] = result[:, 1 : 1 + split + order]
            if polynomial is not None:
                table[:, position : position + order] = result[:, 1 + split + order :]
                position += order
            if self.records.sensor_offset:
                table[:, -1] = 1.0
            if self.records.input_bias:
                table[:, -2 if self.records.sensor_offset else -1] = self._of_unit_bias(experiment, block, output_row)
            tables.append(table)
        return self.target - np.concatenate(outputs), np.concatenate(tables)

    def _of_unit_bias(self, experiment: Experiment, block: Array, output_row: Array) -> Array:
        """What a bias of one changes in the used rows, shape (M,)."""
        order = self.structure.order
        return respond(
            block,
            np.eye(order)[0],
            np.zeros(order),
            output_row[None, :],
            np.ones(len(experiment.signal)),
            experiment.acquisition,
            self.time_unit,
        )[experiment.used, 0]

    def factorise(self, parameters: Array, *, sensitive: bool = True) -> tuple[Array, float, Array]:
        """Triangle R of the QR factorisation of [sensitivities, residual], sum of squares, and residual of every row.

        Parameters
        ----------
        parameters : ndarray
            In scaled units.
        sensitive : bool
            False leaves the columns of the denominator at zero, at half the cost.

        Returns
        -------
        triangle : ndarray, shape (p + 1, p + 1)
        cost : float
        residual : ndarray, shape (total rows,)
            Recorded minus simulated output, experiments concatenated, rows that are not used included.
        """
        numerator, split, order = (
            parameters[: self.structure.degree + 1],
            self.structure.degree + 1,
            self.structure.order,
        )
        denominator = np.concatenate([[1.0], parameters[split : split + order]])
        residual = np.empty(len(self.records.signal))
        triangle, cost = factorise(
            numerator, denominator, parameters[split + order :], self.records, self.time_unit, sensitive, residual
        )
        return triangle, cost, residual

    def solve_numerator(self, denominator: Array) -> tuple[Array, float]:
        """Best numerator and initial states for a given denominator: a linear problem (variable projection).

        Parameters
        ----------
        denominator : ndarray, shape (n + 1,)
            Monic, in scaled time.

        Returns
        -------
        parameters : ndarray
        cost : float
            Sum of squared residuals.
        """
        order, split = self.structure.order, self.structure.degree + 1
        parameters = np.zeros(len(self.free))
        parameters[:split] = self.structure.numerator * self.coefficient_scale()[:split]
        parameters[split : split + order] = denominator[1:]
        # With every linear coefficient at its fixed value or zero, the sensitivities to the others are the regressors.
        linear = self.free.copy()
        linear[split : split + order] = False
        return self._solve_linear(parameters, linear)

    def with_fitted_initial_states(
        self, coefficients: Array, beside: tuple[Predictor, Callable[[float], float]] | None = None
    ) -> Array:
        """Parameter vector of coefficients in SI units with the initial states and constants that fit them best.

        The rows of a predictor ``beside`` count for what its function makes of the root mean square that is left
        without them.
        """
        parameters = self.from_physical(coefficients)
        linear = np.zeros(len(parameters), bool)
        linear[len(self.structure.free) :] = True
        if not self.linear_unknowns:
            return parameters
        found, cost = self._solve_linear(parameters.copy(), linear)
        if beside is None or not np.isfinite(cost):
            return found
        other, weight = beside
        parameters[linear] = 0.0
        more = other.factorise(parameters, sensitive=False)[0]
        return self._solve_linear(parameters, linear, weight(np.sqrt(cost / max(len(self.target), 1))) * more)[0]

    def _solve_linear(
        self, parameters: Array, linear: NDArray[np.bool_], more: Array | None = None
    ) -> tuple[Array, float]:
        """The parameters with those that enter linearly solved for, and the sum of squares that is left.

        ``more`` is the triangle of other rows, shape (p + 1, p + 1).
        """
        parameters[linear] = 0.0
        triangle, _, _ = self.factorise(parameters, sensitive=False)
        if more is not None:
            triangle = np.asarray(np.linalg.qr(np.vstack([triangle, more]), mode="r"))
        if not np.all(np.isfinite(triangle)):
            return parameters, np.inf
        solution, cost, _, _ = solve(triangle, np.flatnonzero(linear))
        parameters[linear] = solution
        return parameters, float(cost)
