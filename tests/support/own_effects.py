"""Files with effects of a user's own, right and wrong in one place each."""

RIGHT = '''\
from math import sqrt

from camid.effects import Effect, Parameter, compiled


class Fading(Effect):
    """A coil that leaves its magnet."""

    identifier = "fading"
    place = "plant"
    title = "Fading force constant"
    equation = r"f = c\\,y^2\\,u"
    reference = "nobody"
    parameters = (Parameter("coefficient", "1/y^2", "relative loss of force at the displacement one"),)
    strength = "coefficient"

    @compiled
    def force(time, position, velocity, signal, memory, values):
        return values[0] * position * position * signal

    @classmethod
    def candidates(cls, situation):
        yield cls(coefficient=0.02 / situation.largest("position") ** 2)
'''
LAW = "        return values[0] * position * position * signal\n"
GUESS = '        yield cls(coefficient=0.02 / situation.largest("position") ** 2)\n'


def with_other(part, other):
    """The right file with another text in one place."""
    assert RIGHT.count(part) == 1
    return RIGHT.replace(part, other)


def line_of(text, part):
    """Number of the first line that holds a text."""
    return next(n for n, line in enumerate(text.splitlines(), 1) if part in line)
