"""A learned law as an effect of the user's own: a Python file that is ready to be searched for in other recordings."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from camid.diagnosis.diagnosis import Array, Diagnosis
from camid.diagnosis.learned_part import LearnedPart
from camid.number_text import printable

NAME = "learned_effect.py"
DIGITS = 7
WIDTH = 116
LONGEST_NAME = 30


@dataclass(frozen=True)
class _Form:
    """What the class of a law says and does.

    Attributes
    ----------
    equation : str
        LaTeX; s is the scale and g the curve.
    returns : str
        What the compiled function returns; empty where there is none.
    against_motion : bool
        Whether the sign of the force follows the motion, and not that of the input.
    uses_velocity : bool
    """

    equation: str
    returns: str
    against_motion: bool = False
    uses_velocity: bool = False


FORMS = {
    "position": _Form(r"f = s\,g(y)", "on_curve(position, values, 1)", against_motion=True),
    "velocity": _Form(r"f = s\,g(\dot y)", "on_curve(velocity, values, 1)", against_motion=True, uses_velocity=True),
    "damping over position": _Form(
        r"f = s\,g(y)\,\dot y", "on_curve(position, values, 1) * velocity", against_motion=True, uses_velocity=True
    ),
    "gain over position": _Form(r"f = s\,g(y)\,u", "on_curve(position, values, 1) * signal"),
    "gain over velocity": _Form(r"f = s\,g(\dot y)\,u", "on_curve(velocity, values, 1) * signal", uses_velocity=True),
    "input": _Form(r"u' = u + s\,g(u)", "signal + values[0] * on_curve(signal, values, 1)"),
    "reading": _Form(r"w = y + s\,g(y)", ""),
}
HEAD = '''\
"""What camid diagnose learned from {source}, as an effect of your own.

    camid diagnose ANOTHER.csv --simulation S.yaml --effects {name} --output diagnosis

looks for it in another recording, its size left free. The next diagnosis into this folder writes this file anew: copy
it, give the effect a name that says what it is, and put an equation in the place of the curve if you know one.
"""

from camid.effects import {imports}
'''
FORCE = """
    @compiled
    def force(time, position, velocity, signal, memory, values):
        return values[0] * {returns}

    def force_values(self, plant):
        return [{scale}, *{curve}.numbers]
"""
INPUT = """    keeps_hold = True

    def bent(self, signal):
        return signal + self.values["scale"] * {curve}(signal)

    def transform(self, start, end, step):
        bent = self.bent(start)
        return bent, bent if end is start else self.bent(end)

    @compiled
    def actuated(time, position, velocity, signal, memory, values):
        return {returns}

    def force_values(self, plant):
        return [{scale}, *{curve}.numbers]
"""
READING = """
    def observe(self, output, time):
        return output + self.values["scale"] * {curve}(output)
"""
GUESS = '''
    @classmethod
    def candidates(cls, situation):
        """A share of it: what it does is proportional to its scale."""
        yield cls(scale=0.2)
'''


def effect_file(diagnosis: Diagnosis) -> str | None:
    """Text of a Python file with a class for each law that was learned; None where there is none, or no form for it."""
    parts = [part for part in diagnosis.learned if part.variables in FORMS]
    if not parts:
        return None
    source = _source(diagnosis.recordings)
    taken = set(diagnosis.own_titles)
    names = ["Curve", "Effect", "Parameter"]
    if any(FORMS[part.variables].returns for part in parts):
        names += ["compiled", "on_curve"]
    if any(FORMS[part.variables].against_motion for part in parts):
        names.append("motion_sign")
    imports = ", ".join(sorted(names))
    text = HEAD.format(source=source, name=NAME, imports=imports)
    for part in parts:
        name = _new(_words(part), taken)
        taken.add("-".join(name).lower())
        text += _class(part, name, source)
    return text


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


def _class(part: LearnedPart, words: Sequence[str], source: str) -> str:
    """Curve and class of one law."""
    form = FORMS[part.variables]
    curve = "_".join(words).upper()
    scale = 'self.values["scale"]'
    if form.against_motion:
        scale = f"motion_sign(plant) * {scale}"
    knots, values = np.array(part.knots), np.array(part.values)
    heights = values - knots if part.place != "plant" else values
    what = part.name.partition(" ")[2]
    title = f"{what[:1].upper()}{what[1:]}, as learned from {source}"
    lines = [
        "",
        "",
        f"# {part.knot_unit} and {part.unit or 'a pure number'}: {_comment(part)}",
        f"{curve} = Curve(",
        f"    knots={_tuple(knots)},",
        f"    heights={_tuple(heights)},",
        ")",
        "",
        "",
        f"class {''.join(word[:1].upper() + word[1:] for word in words)}(Effect):",
        f'    """{title}; its size is free."""',
        "",
        f'    identifier = "{"-".join(words).lower()}"',
        f'    place = "{part.place}"',
        f'    title = "{title}"',
        f'    equation = r"{form.equation}"',
        f'    reference = "camid diagnose, from {source}"',
        '    parameters = (Parameter("scale", "", "size s of the law; one as it was learned"),)',
        '    strength = "scale"',
    ]
    if form.uses_velocity:
        lines.append("    uses_velocity = True")
    body = READING if not form.returns else INPUT if part.place == "actuator" else FORCE
    return "\n".join(lines) + "\n" + body.format(returns=form.returns, scale=scale, curve=curve) + GUESS


def _comment(part: LearnedPart) -> str:
    if part.formula:
        return f"about {printable(part.formula)}"
    return "straight lines between these points, and beyond them as at the last ones"


def _tuple(numbers: Array) -> str:
    """A tuple over as many lines as it needs."""
    text = ", ".join(repr(float(f"{number:.{DIGITS}g}")) for number in numbers)
    lines = textwrap.wrap(text, WIDTH - 8, break_long_words=False)
    return "(\n" + "\n".join(f"        {line}" for line in lines) + ",\n    )"
