"""A learned law as an effect of the user's own: a Python file that is ready to be searched for in other recordings."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Any

import numpy as np

from camid.diagnosis.diagnosis import Array, Diagnosis
from camid.diagnosis.laws.formula_program import DEFINED, IMPORTED, FormulaProgram, program_of
from camid.diagnosis.learned_part import LearnedPart, over_visited
from camid.diagnosis.weights import HEADLINE_WEIGHT
from camid.effects import known_effects
from camid.effects.plant_force import motion_sign, static_force
from camid.number_text import printable

NAME = "learned_effect.py"
DIGITS = 7
WIDTH = 108
LONGEST_NAME = 30
# Share of a learned curve, but for a straight line, that its formula has to carry to stand in its place.
LEAST_CARRIED = 0.8


@dataclass(frozen=True)
class _Form:
    """What the class of a law says and does.

    Attributes
    ----------
    left : str
        Left side of its equation, LaTeX.
    symbol, over : str
        Letter and argument for what the law is over.
    times : str
        Argument that it is multiplied with; empty for none.
    against_motion : bool
        Whether the sign of the force follows the motion, and not that of the input.
    """

    left: str
    symbol: str
    over: str
    times: str = ""
    against_motion: bool = False

    @property
    def uses_velocity(self) -> bool:
        """Whether the force depends on the velocity."""
        return "velocity" in (self.over, self.times)

    @property
    def factor(self) -> str:
        """What the law is multiplied with, LaTeX."""
        return {"": "", "velocity": r"\,\dot y", "signal": r"\,u"}[self.times]


FORMS = {
    "position": _Form("f = ", "y", "position", against_motion=True),
    "velocity": _Form("f = ", r"\dot y", "velocity", against_motion=True),
    "damping over position": _Form("f = ", "y", "position", "velocity", against_motion=True),
    "gain over position": _Form("f = ", "y", "position", "signal"),
    "gain over velocity": _Form("f = ", r"\dot y", "velocity", "signal"),
    "input": _Form("u' = u + ", "u", "signal"),
    "reading": _Form("w = y + ", "y", ""),
}


@dataclass(frozen=True)
class _Law:
    """How a program calls a law.

    Attributes
    ----------
    before : str
        What stands before the class: a curve or a function.
    compiled, arrays : str
        Its value at ``{at}`` in compiled code, without its sign, and at the array ``{at}``.
    values : str
        What compiled code gets.
    sign : int
        Where in these the sign of the force stands; -1 where the scale has it.
    parameters, strength, guess : str
        As the class writes them; no strength where several numbers are one.
    equation : str
    imports : frozenset of str
        Lines of the head, names of camid.effects alone.
    """

    before: str
    compiled: str
    arrays: str
    values: str
    sign: int
    parameters: str
    strength: str
    guess: str
    equation: str
    imports: frozenset[str]


HEAD = '''\
"""What camid diagnose learned from {source}, as an effect of your own.

    camid diagnose ANOTHER.csv --simulation S.yaml --effects {name} --output diagnosis

looks for it in another recording. The next diagnosis into this folder writes this file anew: copy it,
give the effect a name that says what it is, and put an equation in the place of a curve if you know one.
"""

{imports}
'''
FORCE = """
    @compiled
    def force(time, position, velocity, signal, memory, values):
        return {returns}

    def force_values(self, plant):
        return {values}
"""
INPUT = """    keeps_hold = True

    def bent(self, signal):
        return signal + {arrays}

    def transform(self, start, end, step):
        bent = self.bent(start)
        return bent, bent if end is start else self.bent(end)

    @compiled
    def actuated(time, position, velocity, signal, memory, values):
        return signal + {returns}

    def force_values(self, plant):
        return {values}
"""
READING = """
    def observe(self, output, time):
        return output + {arrays}
"""
GUESS = '''
    @classmethod
    def candidates(cls, situation):
        """As it was learned: a fit starts there."""
        yield {guess}
'''


def effect_file(diagnosis: Diagnosis) -> str | None:
    """Text of a Python file with a class for each law that was learned; None where there is none, or no form for it."""
    parts = [part for part in diagnosis.learned if part.variables in FORMS]
    if not parts:
        return None
    source = _source(diagnosis.recordings)
    taken = set(diagnosis.own_titles)
    written, imports = "", {"Effect", "Parameter"}
    for part in _without_those_of_a_formula([_with_what_resembles_it(part, diagnosis) for part in parts]):
        words = _new(_words(part), taken)
        taken.add("-".join(words).lower())
        law = _law_of(part, words)
        written += law.before + _class(part, law, words, source)
        imports |= law.imports
        if part.place != "sensor":
            imports.add("compiled")
        if FORMS[part.variables].against_motion:
            imports.add("motion_sign")
    return HEAD.format(source=source, name=NAME, imports=_imports(imports)) + written


def _with_what_resembles_it(part: LearnedPart, diagnosis: Diagnosis) -> LearnedPart:
    """A force with the forces of effects that only resemble a part of it: beside them it is what they lack."""
    form = FORMS[part.variables]
    if part.place != "plant" or form.times or part.curve is not None:  # a formula stands for all of it already
        return part
    plant, knots, total = diagnosis.improved.plant, np.array(part.knots), np.zeros(len(part.knots))
    doubtful = {f.identifier for f in diagnosis.findings if f.weight < HEADLINE_WEIGHT and f.place == "plant"}
    for declared in diagnosis.improved.effects:
        kind = known_effects().get(declared.identifier)
        if kind is not None and declared.identifier in doubtful:
            law = kind.with_keys(declared.parameters)(**declared.parameters)
            total += static_force(law, form.over, knots, plant)
    return replace(part, values=(np.array(part.values) + motion_sign(plant) * total).tolist())


def _imports(names: set[str]) -> str:
    """Head of the program, with what its formulas call."""
    functions = sorted(names & {*IMPORTED, "pi"})
    helpers = sorted(names & {*DEFINED})
    lines = [f"from math import {', '.join(functions)}\n"] if functions else []
    lines += ["import numpy as np\n"] if "np" in names else []
    lines += ["from camid.compiled import njit"] if "njit" in names else []
    own = sorted(names - {*functions, *helpers, "njit", "np"})
    lines += [f"from camid.effects import {', '.join(own)}"]
    lines += [f"\n\n@njit\n{DEFINED[name][0]}" for name in helpers]
    return "\n".join(lines)


def _without_those_of_a_formula(parts: Sequence[LearnedPart]) -> list[LearnedPart]:
    """The laws, but for those over a variable for all of which a formula stands."""
    whole = {part.variables for part in parts if part.to_mapping()["formula"]}
    return [part for part in parts if part.variables not in whole or part.to_mapping()["formula"]]


def _source(recordings: Sequence[str]) -> str:
    """What the recordings are called in the text of a program."""
    name = printable(PurePath(recordings[0]).name) if recordings else "a recording"
    name = name.replace("\\", "/").replace('"', "'")
    name = name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}…"
    return name if len(recordings) <= 1 else f"{name} and {len(recordings) - 1} more"


def _words(part: LearnedPart) -> list[str]:
    """Words of its name: Learned, force, over, velocity."""
    return [word for word in part.name.split() if word != "the"]


def _new(words: Sequence[str], taken: set[str]) -> list[str]:
    """The words, with a number behind them where their identifier is taken."""
    found, number = list(words), 1
    while "-".join(found).lower() in taken:
        number += 1
        found = [*words, str(number)]
    return found


def _law_of(part: LearnedPart, words: Sequence[str]) -> _Law:
    """Its formula, where it has one that the program can hold, or its curve."""
    entry: dict[str, Any] = part.to_mapping()
    if entry["formula"]:
        numbers = {name: float(number["value"]) for name, number in entry.get("formula_parameters", {}).items()}
        units = {name: str(number["unit"]) for name, number in entry.get("formula_parameters", {}).items()}
        program = program_of(str(entry["formula"]), numbers, np.array(part.learned.knots))
        # A formula in the place of the curve may stand for named effects, too.
        if program is not None and (part.curve is not None or entry["formula_replaces"] or _carries(program, part)):
            return _formula_law(program, part, words, units)
    return _curve_law(part, words)


def _heights(part: LearnedPart) -> Array:
    """What a law adds: values of a force, or the bend of a curve."""
    values = np.array(part.values)
    return values if part.place == "plant" else np.asarray(values - np.array(part.knots))


def _carries(program: FormulaProgram, part: LearnedPart) -> bool:
    """Whether a formula is about the learned curve, but for a straight line, which coefficients may stand for."""
    knots = np.array(part.knots)
    weights = 1.0 / np.maximum(np.array(part.standard_deviations), 1e-12 + 0.01 * float(np.ptp(part.values)))
    line = np.vander(knots, 2) * weights[:, None]
    rest = [
        curve * weights - line @ np.linalg.lstsq(line, curve * weights, rcond=None)[0]
        for curve in (_heights(part), program.values(knots))
    ]
    return float(np.sum((rest[0] - rest[1]) ** 2)) <= (1.0 - LEAST_CARRIED) * float(np.sum(rest[0] ** 2))


def _curve_law(part: LearnedPart, words: Sequence[str]) -> _Law:
    """Straight lines between the learned values, with a scale."""
    form, name = FORMS[part.variables], "_".join(words).upper()
    sign = "motion_sign(plant) * " if form.against_motion else ""
    lines = [
        "",
        "",
        *_visited(part),
        f"# In {part.knot_unit} and {part.unit or 'pure numbers'}: straight lines between points, constant beyond.",
        f"{name} = Curve(",
        f"    knots={_tuple(part.knots)},",
        f"    heights={_tuple(_heights(part))},",
        ")",
    ]
    return _Law(
        "\n".join(lines) + "\n",
        "values[0] * on_curve({at}, values, 1)",
        f'self.values["scale"] * {name}({{at}})',
        f'[{sign}self.values["scale"], *{name}.numbers]',
        -1,
        '    parameters = (Parameter("scale", "", "size s of the law; one as it was learned"),)',
        "scale",
        "cls(scale=1.0)",
        rf"s\,g({form.symbol})",
        frozenset({"Curve"} if part.place == "sensor" else {"Curve", "on_curve"}),
    )


def _visited(part: LearnedPart) -> list[str]:
    """A comment on how large a law is where the recording says what it is."""
    if part.visited is None:
        return []
    low, high = (_number(value) for value in part.visited)
    largest = float(np.max(np.abs(over_visited(part.visited, part.knots, _heights(part).tolist())[1])))
    return [f"# Up to {float(f'{largest:.3g}')!r} from {low} to {high}, where the middle 98 % of the rows lie."]


def _formula_law(program: FormulaProgram, part: LearnedPart, words: Sequence[str], units: dict[str, str]) -> _Law:
    """A function with the numbers of the formula free."""
    form, name, numbers = FORMS[part.variables], "_".join(words).lower(), list(program.numbers)
    before = f"\n\n@njit\ndef {name}({', '.join([program.variable, *numbers])}):\n    return {program.code}\n"
    rows = []
    for number in numbers:
        lower = f", lower={program.lower[number]}" if number in program.lower else ""
        rows.append(f'        Parameter("{number}", "{units[number]}", "number {number} of the formula"{lower}),\n')
    guess = f"cls({', '.join(f'{n}={_number(v)}' for n, v in program.numbers.items())})"
    strength = program.amplitudes[0] if len(program.amplitudes) == 1 else ""
    if not strength:
        nothing = ", ".join("0.0" if n in program.amplitudes else _number(v) for n, v in program.numbers.items())
        guess += f".measured_from({nothing})"
    arguments = ", ".join(f"values[{i}]" for i in range(len(numbers)))
    equation = rf"\left({program.equation}\right)" if form.times and " + " in program.equation else program.equation
    return _Law(
        before,
        f"{name}({{at}}, {arguments})",
        f"np.array([{name}(at, *self.vector) for at in {{at}}])",
        "[*self.vector, motion_sign(plant)]" if form.against_motion else "list(self.vector)",
        len(numbers) if form.against_motion else -1,
        "    parameters = (\n" + "".join(rows) + "    )",
        strength,
        guess,
        equation.replace(r"\left(", "(").replace(r"\right)", ")"),
        frozenset({*(program.functions & {*IMPORTED, *DEFINED}), "njit", *(["pi"] if "pi" in program.code else [])})
        | ({"np"} if part.place != "plant" else frozenset()),
    )


def _class(part: LearnedPart, law: _Law, words: Sequence[str], source: str) -> str:
    """Class of a law."""
    form = FORMS[part.variables]
    what = part.name.partition(" ")[2]
    title = f"{what[:1].upper()}{what[1:]}, as learned from {source}"
    lines = [
        "",
        "",
        f"class {''.join(word[:1].upper() + word[1:] for word in words)}(Effect):",
        f'    """{title}."""',
        "",
        f'    identifier = "{"-".join(words).lower()}"',
        f'    place = "{part.place}"',
        f'    title = "{title}"',
        f'    equation = r"{form.left}{law.equation}{form.factor}"',
        f'    reference = "camid diagnose, from {source}"',
        law.parameters,
    ]
    lines += [f'    strength = "{law.strength}"'] if law.strength else []
    lines += ["    uses_velocity = True"] if form.uses_velocity else []
    sign = f"values[{law.sign}] * " if law.sign >= 0 else ""
    times = f" * {form.times}" if form.times else ""
    body = {"plant": FORCE, "actuator": INPUT, "sensor": READING}[part.place]
    return (
        "\n".join(lines)
        + "\n"
        + body.format(
            returns=sign + law.compiled.format(at=form.over) + times,
            arrays=law.arrays.format(at="signal" if part.place == "actuator" else "output"),
            values=law.values,
        )
        + GUESS.format(guess=law.guess)
    )


def _number(value: float) -> str:
    return repr(float(f"{value:.{DIGITS}g}"))


def _tuple(numbers: Sequence[float] | Array) -> str:
    """A tuple over as many lines as it needs."""
    lines = textwrap.wrap(", ".join(map(_number, numbers)), WIDTH - 8, break_long_words=False)
    return "(\n" + "\n".join(f"        {line}" for line in lines) + ",\n    )"
