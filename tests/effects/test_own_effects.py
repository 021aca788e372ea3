"""Effects of a user's own: in the catalogue while they are used, and refused in one line where they are wrong."""

import sys
import threading

import pytest

from camid.effects import known_effects
from camid.effects.known import declarable_effects
from camid.effects.own_effects import own_effects, own_effects_in_use
from camid.errors import InputError
from tests.support.own_effects import LAW, RIGHT, line_of, with_other


@pytest.fixture
def write(tmp_path):
    def write(text, name="mine.py"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def classes_of(path):
    with own_effects([path]) as found:
        return found


def test_they_are_known_within_the_block_alone(write):
    before = dict(known_effects())
    with own_effects([write(RIGHT)]) as (fading,):
        assert known_effects()["fading"] is declarable_effects()["fading"] is fading
        assert own_effects_in_use() == (fading,)
        seen = []
        thread = threading.Thread(target=lambda: seen.append("fading" in known_effects()))
        thread.start()
        thread.join()
        assert seen == [True]
    assert known_effects() == before
    assert own_effects_in_use() == ()
    assert not [name for name in sys.modules if name.startswith("own_effects")]


def test_a_block_that_fails_forgets_them(write):
    with pytest.raises(KeyError), own_effects([write(RIGHT)]):
        raise KeyError("something else")
    assert "fading" not in known_effects()


def test_several_files_and_several_classes(write):
    two = RIGHT + RIGHT.replace("Fading", "Growing").replace('"fading"', '"growing"')
    again = RIGHT.replace('"fading"', '"waning"')
    with own_effects([write(two), write(again, "other.py")]) as found:
        assert [kind.identifier for kind in found] == ["fading", "growing", "waning"]


def test_a_class_is_taken_as_it_is_and_may_be_given_twice(write):
    (fading,) = classes_of(write(RIGHT))
    with own_effects([fading]):
        with own_effects(fading) as again:
            assert again == (fading,)
        assert known_effects()["fading"] is fading


def test_a_class_that_is_only_defined_is_not_known(write):
    classes_of(write(RIGHT))
    assert "fading" not in declarable_effects()


def test_classes_that_others_build_on_need_no_identifier(write):
    text = RIGHT.replace("class Fading(Effect):", "class Base(Effect):\n    pass\n\n\nclass Fading(Base):")
    assert [kind.identifier for kind in classes_of(write(text))] == ["fading"]


HELPED = RIGHT.replace("\n\n\nclass", "\n\n\n@njit\ndef square(y):\n    return y * y\n\n\nclass").replace(
    "from camid.effects", "from camid.compiled import njit\nfrom camid.effects"
)


def test_compiled_helpers_and_constants_of_the_file_may_be_used(write):
    text = HELPED.replace(LAW, "        return values[0] * square(position) * TABLE[1] * sqrt(4.0) * signal\n")
    (fading,) = classes_of(write(text.replace("class Fading", "TABLE = (1.0, 3.0)\n\n\nclass Fading")))
    assert fading.force.at(0.0, 2.0, 0.0, 5.0, 0.0, values=[0.1]) == pytest.approx(0.1 * 4.0 * 3.0 * 2.0 * 5.0)


def test_a_change_in_the_file_is_compiled_again(write):
    """Machine code is kept between runs: an older version of the law must not be found there."""
    for factor in (2.0, 3.0):
        text = HELPED.replace("return y * y", f"return {factor} * y").replace("position * position", "square(position)")
        (fading,) = classes_of(write(text))
        assert fading.force.at(0.0, 1.0, 0.0, 1.0, 0.0, values=[1.0]) == factor


@pytest.mark.parametrize(
    ("text", "where", "says"),
    [
        (RIGHT.replace("def force(", "def force)"), "def force)", "this is no Python"),
        (RIGHT + "\n1 / 0\n", "1 / 0", "ZeroDivisionError: division by zero"),
        (RIGHT + "\nexit(3)\n", "exit(3)", "SystemExit: 3"),
        ("import helpers\n", "import helpers", "No module named 'helpers'; a file of effects is read alone"),
        ("from camid.effects import Efect\n", "Efect", "cannot import name 'Efect'"),
        ("x = 1\n", None, "no effect in this file; it needs a class that derives from camid.effects.Effect"),
        ("", None, "no effect in this file"),
        (with_other('    identifier = "fading"\n', ""), "class Fading", "Fading has no identifier"),
        (with_other('"fading"', '"coulomb-friction"'), "class Fading", "'coulomb-friction' is taken by the catalogue"),
        (with_other('"fading"', '"learned-force"'), "class Fading", "'learned-force' is taken by the catalogue"),
        (with_other('"fading"', '"unlisted"'), "class Fading", "'unlisted' is taken by the catalogue"),
        (with_other('"fading"', '"Fading Force"'), "class Fading", "'Fading Force' is not one"),
        (with_other('    place = "plant"\n', ""), "class Fading", "place 'None' is not one of actuator, plant"),
        (with_other('place = "plant"', 'place = "motor"'), "class Fading", "place 'motor' is not one of actuator"),
        (with_other('    title = "Fading force constant"\n', ""), "class Fading", "it has no title"),
        (with_other('    reference = "nobody"\n', ""), "class Fading", "it has no reference"),
        (with_other('strength = "coefficient"', 'strength = "size"'), "class Fading", "strength 'size' is none of its"),
        (
            with_other("(Parameter(", "[].append(Parameter(").replace('one"),)', 'one"))'),
            "class Fading",
            "no tuple of Parameter",
        ),
        (RIGHT[: RIGHT.index("    @classmethod")], "class Fading", "the method 'candidates' is missing"),
        (with_other("    @classmethod\n", ""), "def candidates", "'candidates' is no class method"),
        (with_other("    @compiled\n", ""), "def force", "'force' is not compiled; write @compiled above it"),
        (with_other("def force(time,", "def force(self, time,"), "def force", "'force' takes other arguments"),
        (
            with_other("def force(time, position, velocity,", "def force(time, velocity, position,"),
            "def force",
            "'force' has 'velocity' in the place of another argument; they come by their place",
        ),
        (with_other("def force(", "def push("), "class Fading", "it does nothing"),
        (RIGHT + "    force = 3.0\n", "class Fading", "'force' is not compiled"),
        (RIGHT + RIGHT.replace("Fading(", "Again("), "class Again", "'fading' is taken by"),
        (with_other(LAW, "        return values[0] * nowhere\n"), "nowhere", "name 'nowhere' is not defined"),
        (with_other(LAW, "        return [position]\n"), "[position]", "No conversion from list"),
        (
            HELPED.replace("return y * y", "return y.imaginary").replace("position * position", "square(position)"),
            "y.imaginary",
            "Unknown attribute 'imaginary'",
        ),
        (with_other(LAW, "        pass\n"), "pass", "No conversion from none to float64"),
        (with_other(LAW, "        raise ValueError('no')\n"), "raise ValueError", "'force' raises an error"),
        (with_other(LAW, "        assert position > 0.0\n" + LAW), "assert", "'force' raises an error"),
        (
            "TABLE = {'a': 1.0}\n" + with_other(LAW, "        return TABLE['a']\n"),
            "def force",
            "whose changes the kept machine code would not follow",
        ),
    ],
)  # fmt: skip
def test_wrong_files_are_refused_in_a_line(write, text, where, says):
    path = write(text)
    with pytest.raises(InputError) as refused, own_effects([path]):
        raise AssertionError("it was taken")
    place = str(path) if where is None else f"{path}, line {line_of(text, where)}"
    assert str(refused.value).startswith(f"{place}: "), refused.value
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "fading" not in declarable_effects()
    assert not [name for name in sys.modules if name.startswith("own_effects")]


def test_what_is_no_file_is_refused(tmp_path):
    for path, says in ((tmp_path / "none.py", "no such file"), (tmp_path, "this is a folder")):
        with pytest.raises(InputError, match=says), own_effects(path):
            pass
    with pytest.raises(InputError, match="int is not an effect"), own_effects([int]):
        pass
    with pytest.raises(InputError, match="3 is no effect"), own_effects([3]):
        pass


def test_two_files_with_one_identifier_name_each_other(write):
    first, second = write(RIGHT), write(RIGHT, "again.py")
    with pytest.raises(InputError) as refused, own_effects([first, second]):
        pass
    assert str(refused.value).startswith(f"{second}, line {line_of(RIGHT, 'class Fading')}: ")
    assert f"is taken by {first}, line" in str(refused.value)


def test_a_binary_file_is_refused(write):
    path = write(b"\x00\xff\xfe")
    with pytest.raises(InputError, match="this is no Python"), own_effects(path):
        pass


def test_a_file_that_is_no_python_is_not_run(write):
    with pytest.raises(InputError, match="this is no Python file"):
        classes_of(write(RIGHT, "mine.csv"))
