"""A plant of named constants in a simulation file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from camid.errors import InputError, nearest_match
from camid.physical.equations import Equations, plant_function
from camid.physical.expressions import refuse_name
from camid.physical.linear_form import LinearForm, RationalForm, StateSpaceForm
from camid.physical.plant import PhysicalPlant
from camid.simulation.refused_plant import refuse_table
from camid.simulation.yaml_file import Where

if TYPE_CHECKING:
    from camid.simulation.plant_schema import EquationsPart, PhysicalParameters, PhysicalPart

FORMS = ("transfer_function", "state_space", "equations")


def declared_physical(written: PhysicalPart, where: Where, columns: Mapping[str, str]) -> dict[str, Any]:
    """What a file says about a plant of named constants, as arguments of :class:`camid.simulation.model.Simulation`.

    Parameters
    ----------
    written : PhysicalPart
    where : callable
        Gives file, line and key of a path of keys.
    columns : mapping of str to str
        Several columns of the sensor and what they read, as expressions.

    Raises
    ------
    InputError
        If an expression is none, a name is not known or both fixed and free, or the constants make no proper
        plant.
    """
    constants = written.physical
    names = _names(constants, where)
    form = _form(constants, names, where)
    if isinstance(form, Equations) and columns:
        form = _with_readings(form, columns, where)
    for key, given in (("fixed", constants.fixed), ("units", constants.units or {})):
        _refuse_strangers(given, names, where("plant", "physical", key))
    fixed = _fixed(written, names, where)
    deviations = written.standard_deviations
    _refuse_strangers(deviations or {}, names, where("plant", "standard_deviations"))
    if written.covariance is not None:
        refuse_table(written.covariance, len(names), f"it has one row for each of {', '.join(names)}", where)
    physical = PhysicalPlant(
        dict(zip(names, map(float, constants.parameters.values()), strict=True)),
        form,
        fixed,
        {str(k): str(v) for k, v in (constants.units or {}).items()},
        None if not deviations else {str(k): float(v) for k, v in deviations.items()},
        None if written.covariance is None else [[float(v) for v in row] for row in written.covariance],
    )
    place = where("plant", "physical")
    try:
        plant = physical.transfer_function()
        _ = plant.monic
        free_numerator, free_denominator = physical.freedom()
    except ValueError as error:
        hint = "correct the expressions or the constants"
        if physical.equations is not None and not any(physical.equations.start):
            hint = "they are linearised at the state before the first sample: give it under start, or correct them"
        raise InputError(str(error), where=place, hint=hint) from None
    for name in names:
        if not _depends_on(physical, name):
            raise InputError(
                f"nothing depends on '{name}'",
                where=where("plant", "physical", "parameters", name),
                hint="use it in an expression, or leave it out",
            )
    return {
        "plant": plant,
        "physical": physical,
        "free_numerator": free_numerator,
        "free_denominator": free_denominator,
    }


def _depends_on(physical: PhysicalPlant, name: str) -> bool:
    if physical.equations is not None:
        return plant_function(physical.equations).depends_on(name)
    column = physical.names.index(name)
    return bool((physical.coefficients.sensitive(physical.values)[:, column] != 0.0).any())


def _fixed(written: PhysicalPart, names: tuple[str, ...], where: Where) -> tuple[str, ...]:
    """Constants that keep their values: those under ``fixed``, and those that ``free`` says are not."""
    fixed, free = tuple(map(str, written.physical.fixed)), written.free or {}
    _refuse_strangers(free, names, where("plant", "free"))
    for name in fixed:
        if free.get(name, False):
            raise InputError(
                f"'{name}' is fixed and free", where=where("plant", "free", name), hint="take it out of one of them"
            )
    return tuple(name for name in names if name in fixed or not free.get(name, True))


def _names(constants: PhysicalParameters, where: Where) -> tuple[str, ...]:
    for name in constants.parameters:
        try:
            refuse_name(name)
        except ValueError as error:
            raise InputError(
                str(error), where=where("plant", "physical", "parameters", name), hint="for instance mass"
            ) from None
    return tuple(map(str, constants.parameters))


def _form(constants: PhysicalParameters, names: tuple[str, ...], where: Where) -> LinearForm | Equations:
    """How the plant follows from the constants, as it is written."""
    given = [key for key in FORMS if getattr(constants, key) is not None]
    if len(given) != 1:
        said = f"{' and '.join(given)} are both given" if given else "nothing says how the plant follows from them"
        raise InputError(said, where=where("plant", "physical"), hint=f"write one of {', '.join(FORMS)}")
    rational, states = constants.transfer_function, constants.state_space
    if constants.equations is not None:
        return _equations(constants.equations, names, where)
    form: LinearForm
    if rational is not None:
        form = RationalForm(names, _texts(rational.numerator), _texts(rational.denominator))
    else:
        assert states is not None
        rows = tuple(_texts(row) for row in states.state_matrix)
        form = StateSpaceForm(names, rows, _texts(states.input_vector), _texts(states.output_row))
    try:
        form.polynomials()
    except ValueError as error:
        raise InputError(
            str(error),
            where=where("plant", "physical", given[0]),
            hint="expressions hold names of parameters, numbers, + - * / ^ and functions such as sqrt",
        ) from None
    return form


def _equations(written: EquationsPart, names: tuple[str, ...], where: Where) -> Equations:
    """Nonlinear equations as they are written."""
    place = ("plant", "physical", "equations")
    known = set(names)
    if written.input in names:
        named = where("plant", "physical", "parameters", str(written.input))
        raise InputError(f"'{written.input}' is the input of the equations", where=named, hint="rename one of them")
    for name, *path in (*((state, "states", state) for state in written.states), (written.input, "input")):
        try:
            refuse_name(name)
        except ValueError as error:
            raise InputError(str(error), where=where(*place, *path), hint="for instance speed") from None
        if name in known:
            raise InputError(f"'{name}' means two things", where=where(*place, *path), hint="choose another name")
        known.add(name)
    start = written.start or {}
    _refuse_strangers(start, [*written.states], where(*place, "start"), "states")
    form = Equations(
        names,
        tuple(zip(map(str, written.states), _texts([*written.states.values()]), strict=True)),
        str(written.output),
        str(written.input),
        tuple(float(start.get(name, 0.0)) for name in written.states),
    )
    try:
        plant_function(form)
    except ValueError as error:
        raise InputError(
            str(error),
            where=where(*place),
            hint="expressions hold names, numbers, + - * / ^ and functions such as sqrt",
        ) from None
    return form


def _with_readings(form: Equations, columns: Mapping[str, str], where: Where) -> Equations:
    """The equations with what several columns read."""
    for column, text in columns.items():
        try:
            plant_function(replace(form, readings=(str(text),)))
        except ValueError as error:
            raise InputError(
                str(error),
                where=where("sensor", "columns", column),
                hint="expressions hold states, parameters, numbers, + - * / ^ and functions such as sin",
            ) from None
    return replace(form, readings=tuple(map(str, columns.values())))


def _texts(expressions: Sequence[str | float]) -> tuple[str, ...]:
    """Expressions as text; a number is one that is read back as it is."""
    return tuple(repr(float(e)) if isinstance(e, int | float) else str(e) for e in expressions)


def _refuse_strangers(given: Any, names: Sequence[str], where: str, what: str = "parameters") -> None:
    for name in given:
        if name not in names:
            raise InputError(f"'{name}' is not among the {what}", where=where, hint=nearest_match(name, names))
